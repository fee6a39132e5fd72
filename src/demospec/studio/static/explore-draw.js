// Drawing of the Explore page: documents and state in, SVG out. No state is kept here.
import { placeOf } from "./explore.js";
import { html, node } from "./parts.js";

const MODES = ["#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#d55e00"];

export const SAID = {
  accept: { mark: "✓", word: "accepted", does: "accepts this path", look: "yes" },
  reject: { mark: "✕", word: "rejected", does: "rejects this path", look: "no" },
  unknown: { mark: "?", word: "not known", does: "not known of this path", look: "open" },
};
export const percent = (p) => `${(100 * p).toFixed(p > 0.995 || p < 0.005 ? 0 : 1)} %`;

const titled = (words) => { const t = node("title"); t.textContent = words; return t; };
const curve = (scene, control) =>
  `M${scene.start.join(" ")}Q${control.join(" ")} ${scene.goal.join(" ")}`;

function frame(svg, scene, box = scene.bounds) {
  const [x0, y0, x1, y1] = box;
  svg.setAttribute("viewBox", `${x0} ${y0} ${x1 - x0} ${y1 - y0}`);
  const unit = Math.max(x1 - x0, y1 - y0) / 140;
  svg.style.setProperty("--unit", `${unit}px`);
  svg.style.setProperty("--line-px", `${(0.7 * unit).toFixed(4)}px`);
  return unit;
}

// The same picture stays the same element: it need not be decoded for every move of the hand.
const pictures = new WeakMap();
function picture(svg, scene) {
  if (scene.picture === null) return [];
  const known = pictures.get(svg);
  if (known?.getAttribute("href") === scene.picture) return [known];
  const [width, height] = scene.size ?? [0, 0];
  const made = node("image", { href: scene.picture, width, height, preserveAspectRatio: "none" });
  pictures.set(svg, made);
  return [made];
}

function mapLayers(scene, map, id) {
  if (!map) return [];
  const [x0, y0, x1, y1] = scene.bounds;
  const all = `M${x0} ${y0}H${x1}V${y1}H${x0}Z`, maybe = map.open ?? map.region;
  const layers = [
    node("path", { class: "map-no", d: all + maybe, "fill-rule": "evenodd" }),
    node("path", { class: "map-hatch", d: all + maybe, "fill-rule": "evenodd", fill: `url(#${id})` }),
  ];
  if (map.open !== null) layers.push(node("path", { class: "map-open", d: map.open + map.region, "fill-rule": "evenodd", fill: `url(#${id}-dots)` }),
    node("path", { class: "map-rim thin", d: map.open }));
  layers.push(
    node("path", { class: "map-yes", d: map.region, "fill-rule": "evenodd" }),
    node("path", { class: "map-rim under", d: map.region }), node("path", { class: "map-rim", d: map.region }));
  for (const line of map.sure ?? []) layers.push(node("path", { class: "map-sure", d: line }));
  return layers;
}

function hatch(id, unit) {
  const size = 3 * unit;
  return node("defs", {},
    node("pattern", { id, width: size, height: size, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" },
      node("rect", { width: 0.3 * unit, height: size, class: "hatch" })),
    node("pattern", { id: `${id}-dots`, width: size, height: size, patternUnits: "userSpaceOnUse" },
      node("circle", { cx: size / 2, cy: size / 2, r: 0.35 * unit, class: "dots" })));
}

function ends(scene, unit) {
  const [gx, gy] = scene.goal, r = 2.2 * unit;
  const star = Array.from({ length: 10 }, (_, i) => {
    const a = -Math.PI / 2 + (i * Math.PI) / 5, s = i % 2 ? 0.45 * r * 1.4 : r * 1.4;
    return `${(gx + s * Math.cos(a)).toFixed(4)} ${(gy + s * Math.sin(a)).toFixed(4)}`;
  }).join("L");
  return [
    node("circle", { class: "ex-end", cx: scene.start[0], cy: scene.start[1], r: 1.6 * unit }, titled("start")),
    node("path", { class: "ex-end", d: `M${star}Z` }, titled("goal")),
  ];
}

function objects(scene, view) {
  return scene.objects.map((item) => {
    const [x, y] = placeOf(item.id), dx = x - item.center[0], dy = y - item.center[1];
    const chosen = view.selected === item.id ? " selected" : "";
    return node("g", {
      class: `ex-object${chosen}${item.added === null ? "" : " added"}`, "data-handle": item.id, tabindex: 0, role: "button",
      "aria-label": `${item.symbol} ${item.id}, arrow keys move it`, transform: `translate(${dx} ${dy})`,
    }, node("path", { d: item.outline, class: "under" }), node("path", { d: item.outline }), titled(`${item.symbol} (${item.id}): drag it`));
  });
}

// The table with a narrow rim: the picture, else all that the scene is made of.
function table(scene) {
  if (!scene.size) return scene.bounds;
  const [w, h] = scene.size, pad = 0.02 * Math.max(w, h);
  return [-pad, -pad, w + pad, h + pad];
}

// What the rule keeps from each object: the studio's own drawing, as in Teach and in the report.
const drawn = new WeakMap();
function rings(svg, doc, view) {
  if (!doc.rings || view.stale) return [];
  if (drawn.get(svg)?.from !== doc.rings) {
    const group = node("g", { class: "ex-rings", "aria-hidden": "true" });
    group.innerHTML = doc.rings;
    drawn.set(svg, { from: doc.rings, group });
  }
  return [drawn.get(svg).group];
}

// Dark to light blue, as the paper draws repair.
function shade(share) {
  const [a, b] = [[8, 38, 92], [124, 196, 240]];
  return `rgb(${a.map((v, i) => Math.round(v + share * (b[i] - v))).join(" ")})`;
}

function reasons(why, unit) {
  if (!why?.place || why.object === null) return [];
  const [x, y] = why.place, r = 2.3 * unit, layers = [];
  if (why.counterfactual) {
    layers.push(node("path", { class: "ex-instead", d: "M" + why.counterfactual.map((p) => p.join(" ")).join("L") },
      titled("the path pushed just far enough")));
  }
  layers.push(node("circle", { class: "ex-place under", cx: x, cy: y, r }), node("circle", { class: "ex-place", cx: x, cy: y, r }, titled("the place that decides")));
  return layers;
}

export function drawStage(svg, doc, state, view) {
  const { scene } = doc, unit = frame(svg, scene, table(scene));
  const one = doc.verdicts.find((v) => v.type === state.type);
  const focused = document.activeElement?.closest?.("[data-handle]")?.dataset.handle;
  const layers = [...picture(svg, scene)];
  const [w, h] = scene.size ?? [0, 0];
  if (w) layers.push(node("rect", { class: "ex-edge", width: w, height: h }));
  layers.push(...rings(svg, doc, view), ...objects(scene, view));
  const passed = view.steps ?? [];
  passed.forEach((c, i) => layers.push(node("path", {
    class: "ex-step", d: curve(scene, c), stroke: shade(passed.length > 1 ? i / (passed.length - 1) : 1) })));
  for (const p of view.paths ?? []) {
    layers.push(node("path", { class: "ex-solution under", d: curve(scene, p.control) }));
    layers.push(node("path", { class: "ex-solution", d: curve(scene, p.control), stroke: MODES[p.mode % MODES.length], "data-control": JSON.stringify(p.control) },
      titled(`region ${p.mode + 1}${p.true_valid === false ? ", the true rule rejects it" : ""}: click to take this path`)));
  }
  const look = one ? ` ${SAID[one.verdict].look}` : "";
  layers.push(node("path", { class: "ex-path under", d: curve(scene, state.control) }));
  layers.push(node("path", { class: `ex-path${look}`, d: curve(scene, state.control) }));
  layers.push(node("path", { class: "ex-grip", d: curve(scene, state.control), "data-grip": "path" }, titled("drag the path")));
  if (!view.stale && !view.steps && !view.paths) layers.push(...reasons(doc.why, unit));
  layers.push(...ends(scene, unit), ...handle(scene, state, view, unit));
  svg.replaceChildren(...layers);
  if (focused) svg.querySelector(`[data-handle="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
}

// The handle sits on the path, at its middle, where it never leaves the table before the path does.
export const middle = (scene, control) => [0, 1].map((k) => (scene.start[k] + 2 * control[k] + scene.goal[k]) / 4);

function handle(scene, state, view, unit) {
  const [cx, cy] = middle(scene, state.control);
  return [node("g", { class: `ex-control${view.selected === "control" ? " selected" : ""}`, "data-handle": "control", tabindex: 0, role: "button",
    "aria-label": "Bends the path, arrow keys move it", transform: `translate(${cx} ${cy})` },
  node("circle", { r: 5 * unit, class: "reach" }), node("circle", { r: 2.4 * unit }), node("circle", { r: 0.8 * unit, class: "dot" }), titled("bends the path: drag it"))];
}

// The map of the bend: a place of its own, where the handle is moved over it.
export function drawMap(svg, doc, state, view) {
  const { scene } = doc, unit = frame(svg, scene);
  svg.setAttribute("class", view.stale ? "ex-map stale" : "ex-map");
  const [cx, cy] = state.control;
  svg.replaceChildren(hatch("ex-hatch", 1.6 * unit), ...picture(svg, scene), ...mapLayers(scene, doc.map, "ex-hatch"),
    node("path", { class: "ex-arm", d: `M${scene.start.join(" ")}L${state.control.join(" ")}L${scene.goal.join(" ")}` }),
    ...ends(scene, unit), node("circle", { class: "ex-knob", cx, cy, r: 4 * unit, "data-knob": "control" }));
}

let count = 0;
export function drawSmall(svg, scene, map, control, verdict) {
  const unit = frame(svg, scene), id = `ex-hatch-${count++}`;
  svg.setAttribute("class", "ex-small");
  svg.setAttribute("aria-hidden", "true");
  const look = SAID[verdict].look;
  svg.replaceChildren(hatch(id, 2 * unit), ...picture(svg, scene), ...mapLayers(scene, map, id),
    node("path", { class: "ex-path under", d: curve(scene, control) }),
    node("path", { class: `ex-path ${look}`, d: curve(scene, control) }),
    node("circle", { class: "ex-knob", cx: control[0], cy: control[1], r: 4 * unit }));
}

export function chip(verdict, words) {
  const { mark, look } = SAID[verdict];
  return html("span", { class: `ex-chip ${look}` }, `${mark} ${words}`);
}

export function drawSides(box, doc, state) {
  const focused = document.activeElement?.dataset?.type;
  box.replaceChildren(...doc.verdicts.map((v, i) => {
    const svg = node("svg");
    drawSmall(svg, doc.scene, doc.small[i], state.control, v.verdict);
    const known = v.unknown > 0.0005 ? `, not known of ${percent(v.unknown)}` : "";
    return html("button", { type: "button", role: "radio", "aria-checked": String(v.type === state.type), "data-do": "type", "data-type": v.type },
      svg, html("span", {}, v.type), chip(v.verdict, SAID[v.verdict].does),
      html("span", { class: "soft" }, `would accept ${percent(v.share)} of all paths here${known}`));
  }));
  if (focused) box.querySelector(`[data-type="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
}
