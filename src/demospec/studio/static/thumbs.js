// Paths as small pictures, and what pages of paths share.
import { html, node } from "./parts.js";

export const tab = sessionStorage.demospecTab || (sessionStorage.demospecTab = "tab-" + Math.random().toString(36).slice(2, 12));
export const WORDS = { true: "accepted", false: "rejected", null: "unsaid" };

/** Asks an end point of the API; what is refused becomes an error with its words. */
export async function ask(method, path, body) {
  const [place, query] = path.split("?");
  const whole = new URLSearchParams(query);
  if (method !== "GET") whole.set("actor", tab);
  const sent = body === undefined ? {} : { headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) };
  const answer = await fetch(`/api/${place}?${whole}`, { method, ...sent });
  const text = await answer.text();
  let found = text;
  try { found = JSON.parse(text); } catch { /* plain words of the guard */ }
  if (!answer.ok) throw new Error(found.detail ?? found);
  return found;
}

const line = (points) => points.map((p) => p.join(",")).join(" ");

/** One or more paths over their scene. */
export function thumb(scene, demos) {
  const [x, y, w, h] = scene.size ? [0, 0, ...scene.size] : padded(around(scene.bounds, demos));
  const unit = Math.max(w, h) / 200;
  const layers = [];
  if (scene.picture) layers.push(node("image", { href: `/api/scenes/${encodeURIComponent(demos[0].scene_id)}/picture.png`, width: w, height: h, preserveAspectRatio: "none", loading: "lazy" }));
  for (const outline of scene.outlines) layers.push(node("polygon", { class: "standing", points: line(outline) }));
  for (const d of demos) layers.push(node("polyline", { class: "halo", points: line(d.points) }), node("polyline", { class: `path ${WORDS[d.valid]}`, points: line(d.points) }));
  const [gx, gy] = scene.goal, r = 6 * unit;
  const star = Array.from({ length: 10 }, (_, i) => { const a = -Math.PI / 2 + i * Math.PI / 5, s = (i % 2 ? 0.45 : 1) * 1.6 * r; return `${gx + s * Math.cos(a)} ${gy + s * Math.sin(a)}`; }).join("L");
  layers.push(node("circle", { class: "end", cx: scene.start[0], cy: scene.start[1], r }), node("path", { class: "end", d: `M${star}Z` }));
  return node("svg", { class: "scene thumb", viewBox: `${x} ${y} ${w} ${h}`, "aria-hidden": "true", style: `--line-px:${unit}px` }, ...layers);
}

/** Without a picture nothing says where a table ends: paths are always inside. */
function around([x0, y0, x1, y1], demos) {
  const all = demos.flatMap((d) => d.points), xs = all.map((p) => p[0]), ys = all.map((p) => p[1]);
  return [Math.min(x0, ...xs), Math.min(y0, ...ys), Math.max(x1, ...xs), Math.max(y1, ...ys)];
}

function padded([x0, y0, x1, y1]) {
  const pad = 0.08 * Math.max(x1 - x0, y1 - y0);
  const w = x1 - x0 + 2 * pad, h = Math.max(y1 - y0 + 2 * pad, 0.5 * w); // never a strip
  return [x0 - pad, (y0 + y1 - h) / 2, w, h];
}

/** Where a path is taught on. */
export const teachAt = (d) => `/teach?${new URLSearchParams({ scene: d.scene_id, ...(d.type ? { type: d.type } : {}), path: d.demo_id })}`;

export function figure(scene, d, ...more) {
  const by = d.demonstrator ? ` · ${d.demonstrator}` : "";
  return html("figure", { class: "path-figure" }, thumb(scene, [d]),
    html("figcaption", {}, html("span", { class: `key ${WORDS[d.valid]}` }), `${d.name} ${WORDS[d.valid]}${d.type ? ` · ${d.type === "me" ? "you" : d.type}` : ""}${by}`), ...more);
}
