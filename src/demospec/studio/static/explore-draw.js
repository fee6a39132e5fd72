// Drawing of the Explore page: documents and state in, SVG out. No state is kept here.
import { placeOf } from "./explore.js";

const NS = "http://www.w3.org/2000/svg";
const MODES = ["#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#d55e00"];

function node(name, attributes = {}, ...children) {
  const made = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) if (value !== null) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

const titled = (words) => { const t = node("title"); t.textContent = words; return t; };
const curve = (scene, control) =>
  `M${scene.start.join(" ")}Q${control.join(" ")} ${scene.goal.join(" ")}`;

function frame(svg, scene) {
  const [x0, y0, x1, y1] = scene.bounds;
  svg.setAttribute("viewBox", `${x0} ${y0} ${x1 - x0} ${y1 - y0}`);
  return Math.max(x1 - x0, y1 - y0) / 140;
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
  const all = `M${x0} ${y0}H${x1}V${y1}H${x0}Z`;
  const layers = [
    node("path", { class: "map-no", d: all + map.region, "fill-rule": "evenodd" }),
    node("path", { class: "map-hatch", d: all + map.region, "fill-rule": "evenodd", fill: `url(#${id})` }),
    node("path", { class: "map-yes", d: map.region, "fill-rule": "evenodd" }),
    node("path", { class: "map-rim under", d: map.region }),
    node("path", { class: "map-rim", d: map.region }),
  ];
  for (const line of map.sure ?? []) layers.push(node("path", { class: "map-sure", d: line }));
  return layers;
}

function hatch(id, unit) {
  const size = 3 * unit;
  return node("defs", {}, node("pattern", { id, width: size, height: size, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" },
    node("rect", { width: 0.3 * unit, height: size, class: "hatch" })));
}

function ends(scene, unit) {
  const [gx, gy] = scene.goal, r = 2.2 * unit;
  const star = Array.from({ length: 10 }, (_, i) => {
    const a = -Math.PI / 2 + (i * Math.PI) / 5, s = i % 2 ? 0.45 * r * 1.4 : r * 1.4;
    return `${(gx + s * Math.cos(a)).toFixed(2)} ${(gy + s * Math.sin(a)).toFixed(2)}`;
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
      "aria-label": `${item.symbol} ${item.id}, arrow keys move it`, transform: `translate(${dx.toFixed(2)} ${dy.toFixed(2)})`,
    }, node("path", { d: item.outline, class: "under" }), node("path", { d: item.outline }), titled(`${item.symbol} (${item.id}): drag it`));
  });
}

// Dark to light blue, as the paper draws repair.
function shade(share) {
  const [a, b] = [[8, 38, 92], [124, 196, 240]];
  return `rgb(${a.map((v, i) => Math.round(v + share * (b[i] - v))).join(" ")})`;
}

function reasons(scene, why, unit) {
  if (!why) return [];
  const [x, y] = why.place, r = 2.3 * unit, layers = [];
  if (why.counterfactual) {
    layers.push(node("path", { class: "ex-instead", d: "M" + why.counterfactual.map((p) => p.join(" ")).join("L") },
      titled("the path pushed just far enough")));
  }
  layers.push(node("circle", { class: `ex-place under`, cx: x, cy: y, r }), node("circle", { class: `ex-place`, cx: x, cy: y, r }, titled("the place that decides")));
  return layers;
}

export function drawStage(svg, doc, state, view) {
  const { scene } = doc, unit = frame(svg, scene);
  svg.style.setProperty("--unit", `${unit}px`);
  const one = doc.verdicts.find((v) => v.type === state.type);
  const focused = document.activeElement?.closest?.("[data-handle]")?.dataset.handle;
  const layers = [hatch("ex-hatch", unit), ...picture(svg, scene)];
  layers.push(node("g", { class: view.stale ? "ex-map stale" : "ex-map" }, ...mapLayers(scene, doc.map, "ex-hatch")));
  const [w, h] = scene.size ?? [0, 0];
  if (w) layers.push(node("rect", { class: "ex-edge", width: w, height: h }));
  layers.push(...objects(scene, view));
  layers.push(node("path", { class: "ex-arm", d: `M${scene.start.join(" ")}L${state.control.join(" ")}L${scene.goal.join(" ")}` }));
  const passed = view.steps ?? [];
  passed.forEach((c, i) => layers.push(node("path", {
    class: "ex-step", d: curve(scene, c), stroke: shade(passed.length > 1 ? i / (passed.length - 1) : 1) })));
  for (const p of view.paths ?? []) {
    layers.push(node("path", { class: "ex-solution under", d: curve(scene, p.control) }));
    layers.push(node("path", { class: "ex-solution", d: curve(scene, p.control), stroke: MODES[p.mode % MODES.length], "data-control": JSON.stringify(p.control) },
      titled(`region ${p.mode + 1}${p.true_valid === false ? ", the true rule rejects it" : ""}: click to take this path`)));
  }
  const verdict = !one ? "" : one.valid ? " yes" : " no";
  layers.push(node("path", { class: "ex-path under", d: curve(scene, state.control) }));
  layers.push(node("path", { class: `ex-path${verdict}`, d: curve(scene, state.control) }));
  if (!view.stale && !view.steps && !view.paths) layers.push(...reasons(scene, doc.why, unit));
  layers.push(...ends(scene, unit));
  const [cx, cy] = state.control;
  layers.push(node("g", { class: `ex-control${view.selected === "control" ? " selected" : ""}`, "data-handle": "control", tabindex: 0, role: "button",
    "aria-label": `Control point of the path at ${cx.toFixed(0)}, ${cy.toFixed(0)}, arrow keys move it`, transform: `translate(${cx} ${cy})` },
  node("circle", { r: 5 * unit, class: "reach" }), node("circle", { r: 2.4 * unit }), node("circle", { r: 0.8 * unit, class: "dot" }), titled("bends the path: drag it")));
  svg.replaceChildren(...layers);
  if (focused) svg.querySelector(`[data-handle="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
}

let count = 0;
export function drawSmall(svg, scene, map, control, valid) {
  const unit = frame(svg, scene), id = `ex-hatch-${count++}`;
  svg.setAttribute("class", "ex-small");
  svg.setAttribute("aria-hidden", "true");
  svg.replaceChildren(hatch(id, 2 * unit), ...picture(svg, scene), ...mapLayers(scene, map, id),
    node("path", { class: "ex-path under", d: curve(scene, control) }),
    node("path", { class: `ex-path ${valid ? "yes" : "no"}`, d: curve(scene, control) }),
    node("circle", { class: "ex-knob", cx: control[0], cy: control[1], r: 4 * unit }));
}

export function drawSides(box, doc, state) {
  const focused = document.activeElement?.dataset?.type;
  box.replaceChildren(...doc.verdicts.map((v, i) => {
    const button = document.createElement("button");
    Object.assign(button.dataset, { do: "type", type: v.type });
    button.type = "button";
    button.setAttribute("role", "radio");
    button.setAttribute("aria-checked", String(v.type === state.type));
    const svg = node("svg");
    drawSmall(svg, doc.scene, doc.small[i], state.control, v.valid);
    const name = document.createElement("span");
    name.textContent = v.type;
    const chip = document.createElement("span");
    chip.className = `ex-chip ${v.valid ? "yes" : "no"}`;
    chip.textContent = v.valid ? "✓ accepts" : "✕ rejects";
    const share = document.createElement("span");
    share.className = "soft";
    share.textContent = `${(100 * v.mean_p).toFixed(0)} % of paths`;
    button.append(svg, name, chip, share);
    return button;
  }));
  if (focused) box.querySelector(`[data-type="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
}
