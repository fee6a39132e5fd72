// Table: the picture, its scale, start and goal, the objects and their names. The server keeps
// everything at once; every answer is the whole table as it stands.
import { html, node, steps, waitFor } from "./parts.js";
import { prepared, ready } from "./connection.js";
import { ask } from "./thumbs.js";

const root = await waitFor("#table");
const asked = new URLSearchParams(location.search);
const MOST_BYTES = 12 * 1024 * 1024; // as the server has it
const view = { doc: null, tool: "move", ruler: [], loop: null, chosen: null, box: null, drag: null };

function say(words, wrong = false) {
  const line = root.querySelector(".tb-said");
  line.textContent = words;
  line.classList.toggle("wrong", wrong);
}

async function act(method, path, body, words = "") {
  try {
    show(await ask(method, path, body));
    say(words);
    return true;
  } catch (error) { say(error.message, true); return false; }
}
const change = (path, body, words) => act("PUT", path, { scene_id: view.doc.scene_id, ...body }, words);

function show(doc) {
  if (view.doc?.scene_id !== doc.scene_id) Object.assign(view, { box: null, ruler: [], chosen: null });
  view.doc = doc;
  asked.set("scene", doc.scene_id);
  history.replaceState(null, "", `?${asked}`);
  steps(document, doc.steps, doc.scene_id, asked.get("type"));
  paint();
  panel();
}
const open = async (scene) => { const query = new URLSearchParams({ scene_id: scene ?? "", type: asked.get("type") ?? "" }); show(await ask("GET", `table?${query}`)); };

// What is drawn.
function whole() {
  const { size_px: size, objects, start, goal } = view.doc;
  if (size) return [0, 0, ...size];
  const all = [start, goal, ...objects.flatMap((o) => o.outline)], xs = all.map((p) => p[0]), ys = all.map((p) => p[1]);
  const side = Math.max(Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys)) || 1, pad = 0.1 * side;
  return [Math.min(...xs) - pad, Math.min(...ys) - pad, Math.max(...xs) - Math.min(...xs) + 2 * pad, Math.max(...ys) - Math.min(...ys) + 2 * pad];
}
const line = (points) => points.map((p) => p.join(",")).join(" ");

function paint() {
  const { doc } = view, svg = root.querySelector("#tb-svg"), box = view.box ?? whole();
  svg.setAttribute("viewBox", box.join(" "));
  svg.dataset.tool = view.tool;
  const unit = Math.max(box[2], box[3]) / 200;
  svg.style.setProperty("--line-px", `${unit}px`);
  const layers = [];
  const [, , w, h] = whole();
  if (doc.picture) layers.push(known(svg, doc.scene_id, w, h));
  doc.objects.forEach((o, i) => layers.push(outline(o, i, unit)));
  if (view.loop) layers.push(node("polyline", { class: "tb-loop", points: line(view.loop) }));
  if (view.ruler.length) layers.push(...measure(unit));
  layers.push(...ends(unit));
  const focused = document.activeElement?.dataset?.handle;
  svg.replaceChildren(...layers);
  if (focused) svg.querySelector(`[data-handle="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
}

const pictures = new Map();
function known(svg, scene, width, height) {
  if (!pictures.has(scene)) {
    pictures.clear();
    pictures.set(scene, node("image", { href: `/api/scenes/${encodeURIComponent(scene)}/picture.png`, width, height, preserveAspectRatio: "none" }));
  }
  return pictures.get(scene);
}

const middleOf = (points) => [0, 1].map((k) => (Math.min(...points.map((p) => p[k])) + Math.max(...points.map((p) => p[k]))) / 2);

function outline(o, i, unit) {
  const chosen = view.chosen === o.id, drawn = view.drag?.id === o.id ? view.drag.outline : o.outline;
  const [x, y] = middleOf(drawn);
  const parts = [
    node("polygon", { points: line(drawn), class: "under" }), node("polygon", { points: line(drawn), class: o.named ? "" : "nameless" }),
    node("text", { x, y: y + 2.5 * unit, "font-size": 7 * unit, class: "tb-number" }, String(i + 1)),
  ];
  if (o.heading_deg !== null) {
    const a = o.heading_deg * Math.PI / 180, r = 14 * unit;
    parts.push(node("path", { class: "tb-heading", d: `M${x} ${y}L${x + r * Math.cos(a)} ${y + r * Math.sin(a)}` }));
  }
  if (chosen && view.doc.may_mark && view.tool === "move") {
    drawn.forEach((p, k) => parts.push(node("circle", { class: "tb-corner", cx: p[0], cy: p[1], r: 2.2 * unit, "data-corner": k, "data-object": o.id })));
  }
  return node("g", { class: `tb-object${chosen ? " chosen" : ""}`, "data-object": o.id }, ...parts);
}

function ends(unit) {
  return ["start", "goal"].map((name) => {
    const [x, y] = view.drag?.end === name ? view.drag.at : view.doc[name];
    const r = 4 * unit, star = Array.from({ length: 10 }, (_, i) => {
      const a = -Math.PI / 2 + (i * Math.PI) / 5, s = (i % 2 ? 0.45 : 1) * 1.6 * r;
      return `${x + s * Math.cos(a)} ${y + s * Math.sin(a)}`;
    }).join("L");
    const mark = name === "start" ? node("circle", { class: "end", cx: x, cy: y, r }) : node("path", { class: "end", d: `M${star}Z` });
    return node("g", { class: "tb-end", "data-handle": name, tabindex: 0, role: "button", "aria-label": `${name}, arrow keys move it` },
      node("circle", { cx: x, cy: y, r: 3 * r, class: "tb-reach" }), mark, node("title", {}, `${name}: drag it`));
  });
}

function measure(unit) {
  const [a, b] = view.ruler, layers = view.ruler.map((p) => node("circle", { class: "tb-dot", cx: p[0], cy: p[1], r: 2.4 * unit }));
  if (b) layers.unshift(node("line", { class: "tb-ruler under", x1: a[0], y1: a[1], x2: b[0], y2: b[1] }), node("line", { class: "tb-ruler", x1: a[0], y1: a[1], x2: b[0], y2: b[1] }));
  return layers;
}

// The panel beside it.
function panel() {
  const { doc } = view;
  root.querySelector(".tb-scene").replaceChildren(...doc.scenes.map((n) => new Option(n, n, n === doc.scene_id, n === doc.scene_id)));
  root.querySelector(".tb-count").textContent = `${doc.scenes.indexOf(doc.scene_id) + 1} of ${doc.scenes.length}`;
  root.querySelector(".tb-missing").textContent = doc.missing || "Everything is known of this table.";
  root.querySelector(".tb-missing").classList.toggle("done", !doc.missing);
  root.querySelector(".tb-wide").textContent = doc.wide ? `The picture is ${doc.wide} wide.`
    : doc.may_measure ? "How wide is this picture on the table? Robots need metres." : "A scene without a picture is measured in the units of its set.";
  root.querySelector(".tb-measure").hidden = !doc.may_measure;
  root.querySelector("#tb-width").placeholder = doc.wide_cm ?? "";
  const marker = root.querySelector('[data-do="marker"]');
  marker.disabled = !doc.markers;
  root.querySelector(".tb-marker-why").textContent = doc.markers ? "" : "Finding printed markers needs more: pip install 'demospec[markers]'.";
  root.querySelector(".tb-names").replaceChildren(...doc.symbols.map((s) => new Option(s, s)));
  const list = root.querySelector(".tb-list");
  list.replaceChildren(...doc.objects.map((o, i) => {
    const name = html("input", { class: "plain-input", list: "tb-names", value: o.named ? o.symbol : "", placeholder: `name it (looks ${o.symbol.split(" ").at(-1)})`, maxlength: 60, autocomplete: "off", "aria-label": `Name of object ${i + 1}` });
    name.disabled = !doc.may_mark;
    name.onchange = () => name.value.trim() && change("objects", { id: o.id, symbol: name.value.trim() });
    const turn = html("input", { class: "plain-input tb-turn", type: "number", step: 15, value: o.heading_deg ?? "", placeholder: "–", "aria-label": `Direction that object ${i + 1} faces, degrees from right towards down` });
    turn.disabled = !doc.may_mark;
    turn.onchange = () => turn.value !== "" && change("objects", { id: o.id, heading_deg: Number(turn.value) });
    const gone = html("button", { type: "button", class: "plain-button small", "aria-label": `Take object ${i + 1} off the list` }, "×");
    gone.disabled = !doc.may_mark;
    gone.onclick = () => act("DELETE", `objects?${new URLSearchParams({ scene_id: doc.scene_id, id: o.id })}`);
    const row = html("div", { class: `tb-row${view.chosen === o.id ? " chosen" : ""}${o.named ? "" : " nameless"}` }, html("span", { class: "tb-key" }, String(i + 1)), name, turn, gone);
    row.onpointerenter = row.onfocusin = () => { if (view.chosen !== o.id) { view.chosen = o.id; paint(); } };
    return row;
  }));
  const may = doc.may_mark;
  root.querySelector(".tb-objects-why").textContent = may ? "" : "The set lists the objects of this scene.";
  for (const button of root.querySelectorAll("[data-mark]")) button.disabled = !may;
  root.querySelector('[data-do="find"]').disabled = !may || !doc.picture || doc.listed;
  root.querySelector('[data-do="find"]').title = !may ? "The set lists the objects of this scene." : doc.listed ? "Objects are marked already." : "";
  root.querySelector('[data-do="drop"]').disabled = doc.scenes.length < 2;
  for (const b of root.querySelectorAll('[role="radio"][data-tool]')) b.setAttribute("aria-checked", String(b.dataset.tool === view.tool));
  root.querySelector(".tb-how").textContent = {
    move: "Drag the circle (start) and the star (goal). Click an object to change its outline: drag its corners, or the whole.",
    ruler: "Click two places whose distance you know, such as the ends of a sheet of paper (29.7 cm), and say the length.",
    mark: "Write what it is, and draw a loop around it.",
  }[view.tool];
}

function build() {
  root.innerHTML = `
    <section class="tb-stage" aria-label="The table">
      <div class="scene-bar"><h2>Scene <select class="plain-input tb-scene" aria-label="Scene"></select> <span class="soft tb-count"></span></h2>
        <button type="button" class="plain-button" data-do="previous" aria-label="Previous scene">←</button>
        <button type="button" class="plain-button" data-do="next">Next scene</button>
        <label class="plain-button" tabindex="-1">Add a picture…<input id="picture-file" class="out-of-sight" type="file" accept="image/png,image/jpeg,image/webp"></label></div>
      <div class="tb-tools" role="radiogroup" aria-label="Tool">
        <button type="button" class="plain-button" role="radio" data-tool="move">Move</button>
        <button type="button" class="plain-button" role="radio" data-tool="ruler">Ruler</button>
        <button type="button" class="plain-button" role="radio" data-tool="mark" data-mark>Mark an object</button>
        <span class="tb-zoom"><button type="button" class="plain-button" data-do="in" aria-label="Zoom in">+</button>
          <button type="button" class="plain-button" data-do="out" aria-label="Zoom out">−</button>
          <button type="button" class="plain-button" data-do="all">Whole picture</button></span></div>
      <svg id="tb-svg" class="scene outlined tb-svg" role="application" tabindex="0" aria-label="The picture with start, goal and objects"></svg>
      <p class="soft tb-how"></p><p class="tb-said" role="status"></p>
    </section>
    <aside class="tb-panel">
      <p class="card tb-missing" aria-live="polite"></p>
      <section class="card"><h2>Scale</h2><p class="tb-wide"></p>
        <div class="tb-measure">
          <div class="tb-line"><label for="tb-width">Its width is</label><input id="tb-width" class="plain-input" type="number" min="0" step="any" inputmode="decimal"><span>cm</span>
            <button type="button" class="plain-button" data-do="width">Set</button></div>
          <div class="tb-line"><label for="tb-length">Between the two clicks</label><input id="tb-length" class="plain-input" type="number" min="0" step="any" inputmode="decimal"><span>cm</span>
            <button type="button" class="plain-button" data-do="ruler">Set</button></div>
          <div class="tb-line"><label for="tb-marker">Printed AprilTag of</label><input id="tb-marker" class="plain-input" type="number" min="0" step="any" inputmode="decimal"><span>cm</span>
            <button type="button" class="plain-button" data-do="marker">Find</button></div>
          <p class="soft tb-marker-why"></p></div></section>
      <section class="card"><h2>What stands here</h2>
        <div class="tb-line"><label for="object-word">It is a</label><input id="object-word" class="plain-input" list="tb-names" maxlength="60" autocomplete="off" placeholder="cup"><datalist id="tb-names" class="tb-names"></datalist>
          <button type="button" class="plain-button" data-tool="mark" data-mark>Mark</button></div>
        <div class="tb-list"></div><p class="soft tb-objects-why"></p>
        <button type="button" class="plain-button" data-do="find">Find objects automatically</button></section>
      <section class="card"><h2>This scene</h2>
        <div class="tb-line"><label for="tb-name">Name</label><input id="tb-name" class="plain-input" maxlength="60" autocomplete="off"><button type="button" class="plain-button" data-do="rename">Rename</button></div>
        <div class="tb-line"><button type="button" class="plain-button" data-do="undo">Undo <kbd>U</kbd></button><button type="button" class="plain-button" data-do="redo">Redo</button>
          <button type="button" class="plain-button" data-do="drop">Take the scene away</button></div></section>
      <a class="plain-button tb-on" href="/teach">Go on to teach</a>
    </aside>`;
  root.querySelector(".tb-scene").onchange = (e) => open(e.target.value).catch((error) => say(error.message, true));
  root.querySelector("#picture-file").onchange = (e) => { addPicture(e.target.files[0]); e.target.value = ""; };
  root.addEventListener("click", (e) => {
    const button = e.target.closest("[data-do], [data-tool]");
    if (!button) return;
    if (button.dataset.tool) return pick(button.dataset.tool);
    acts[button.dataset.do]();
  });
  root.querySelector("#object-word").onkeydown = (e) => { if (e.key === "Enter") pick("mark"); };
}

function pick(tool) {
  view.tool = tool;
  const word = root.querySelector("#object-word");
  if (tool === "mark" && !word.value.trim()) { word.focus(); say("Say first what the object is, for example cup.", true); }
  else say("");
  paint(); panel();
}

const step = (by) => { const { scenes, scene_id: here } = view.doc; return open(scenes[(scenes.indexOf(here) + by + scenes.length) % scenes.length]); };
const cm = (id) => { const value = Number(root.querySelector(id).value); return Number.isFinite(value) && value > 0 ? value : null; };

const acts = {
  previous: () => step(-1),
  next: () => step(1),
  in: () => zoom(1 / 1.4),
  out: () => zoom(1.4),
  all: () => { view.box = null; paint(); },
  width() {
    const width_cm = cm("#tb-width");
    if (width_cm === null) return say("Say how wide the picture is on the table, in cm.", true);
    change("scale", { width_cm }, "Measured.");
  },
  async ruler() {
    const length_cm = cm("#tb-length");
    if (view.ruler.length < 2) { pick("ruler"); return say("Click two places of the picture first.", true); }
    if (length_cm === null) return say("Say how long the line is, in cm.", true);
    if (await change("scale", { between: view.ruler, length_cm }, "Measured.")) { view.ruler = []; pick("move"); say("Measured."); }
  },
  async marker() {
    const size_cm = cm("#tb-marker");
    if (size_cm === null) return say("Say how large the tag's black square is, in cm.", true);
    say("Looking for the marker…");
    await act("POST", "marker", { scene_id: view.doc.scene_id, size_cm }, "Measured by the marker.");
  },
  async find() {
    say("Looking at the picture…");
    await act("POST", `objects/found?${new URLSearchParams({ scene_id: view.doc.scene_id })}`, undefined, "");
  },
  rename() { change("scene-name", { name: root.querySelector("#tb-name").value.trim() }, "Renamed."); },
  drop() {
    const { scene_id: scene, paths } = view.doc;
    act("DELETE", `scene?${new URLSearchParams({ scene_id: scene })}`, undefined, `${scene} was taken away${paths ? ` with ${paths} paths` : ""}; Undo brings it back.`);
  },
  undo: () => back("undo"),
  redo: () => back("redo"),
};

async function back(what) {
  try {
    const done = (await ask("POST", what))[what === "undo" ? "undone" : "redone"];
    await open(view.doc.scene_id).catch(() => open());
    say(done ? "" : `Nothing is left to ${what} in this tab.`, !done);
  } catch (error) { say(error.message, true); }
}

async function addPicture(file) {
  if (!file) return;
  if (file.size > MOST_BYTES) return say("That picture is larger than 12 MB.", true);
  const name = encodeURIComponent(file.name.replace(/\.[^.]*$/, "").slice(0, 40));
  try {
    const answer = await fetch(`/api/scenes?name=${name}`, { method: "POST", body: file, headers: { "Content-Type": "application/octet-stream" } });
    const text = await answer.text();
    if (answer.ok) { await open(JSON.parse(text).scene_id); return say(""); }
    let why = text;
    try { why = JSON.parse(text).detail; } catch { /* plain words of the guard */ }
    say(`That picture cannot be used: ${why}`, true);
  } catch { say("The picture did not reach the studio. Is it still running?", true); }
}

function zoom(by, at = null) {
  const [x, y, w, h] = view.box ?? whole(), all = whole();
  const wide = Math.min(all[2], Math.max(all[2] / 20, w * by)), high = wide * h / w;
  if (wide >= all[2]) { view.box = null; return paint(); }
  const [cx, cy] = at ?? [x + w / 2, y + h / 2];
  view.box = [cx - (cx - x) * wide / w, cy - (cy - y) * high / h, wide, high];
  paint();
}

// The hand on the picture.
const place = (e) => {
  const p = new DOMPoint(e.clientX, e.clientY).matrixTransform(root.querySelector("#tb-svg").getScreenCTM().inverse());
  return [+p.x.toPrecision(7), +p.y.toPrecision(7)];
};
const kept = ([x, y]) => { const [x0, y0, w, h] = whole(); return [Math.min(x0 + w, Math.max(x0, x)), Math.min(y0 + h, Math.max(y0, y))]; };

function listen() {
  const svg = root.querySelector("#tb-svg");
  svg.addEventListener("pointerdown", (e) => {
    if (e.button > 0 || !e.isPrimary) return;
    svg.setPointerCapture(e.pointerId);
    e.preventDefault(); svg.focus({ preventScroll: true });
    const at = place(e);
    if (view.tool === "mark") { view.loop = [at]; return paint(); }
    if (view.tool === "ruler") { view.ruler = view.ruler.length >= 2 ? [at] : [...view.ruler, at]; view.drag = { ruler: view.ruler.length - 1 }; return paint(); }
    const end = e.target.closest("[data-handle]")?.dataset.handle, corner = e.target.closest("[data-corner]"), object = e.target.closest("[data-object]")?.dataset.object;
    if (end) view.drag = { end, at: view.doc[end].slice(0, 2) };
    else if (object) {
      const item = view.doc.objects.find((o) => o.id === object), again = view.chosen === object;
      view.chosen = object;
      if (view.doc.may_mark && again) view.drag = { id: object, outline: item.outline.map((p) => [...p]), corner: corner ? Number(corner.dataset.corner) : null, from: at };
      panel();
    } else { view.chosen = null; view.drag = { pan: e, box: view.box }; panel(); }
    paint();
  });
  svg.addEventListener("pointermove", (e) => {
    const at = place(e), d = view.drag;
    if (view.loop) { const last = view.loop.at(-1), [, , w] = whole(); if (Math.hypot(at[0] - last[0], at[1] - last[1]) > w / 300) view.loop.push(at); return paint(); }
    if (!d) return;
    if (d.ruler !== undefined) view.ruler[d.ruler] = at;
    else if (d.end) d.at = kept(at);
    else if (d.corner !== null && d.corner !== undefined) d.outline[d.corner] = kept(at);
    else if (d.id) { d.outline = d.outline.map(([x, y]) => [x + at[0] - d.from[0], y + at[1] - d.from[1]]); d.from = at; }
    else if (d.box) { const scale = d.box[2] / svg.clientWidth; view.box = [d.box[0] - (e.clientX - d.pan.clientX) * scale, d.box[1] - (e.clientY - d.pan.clientY) * scale, d.box[2], d.box[3]]; }
    paint();
  });
  const done = () => {
    const { drag: d, loop } = view;
    view.drag = view.loop = null;
    if (loop) {
      const symbol = root.querySelector("#object-word").value.trim();
      if (loop.length < 4) say("Draw a loop around the object.", true);
      else if (!symbol) pick("mark");
      else act("POST", "objects", { scene_id: view.doc.scene_id, symbol, points: loop }).then((ok) => ok && pick("move"));
    } else if (d?.end) change("ends", { start: view.doc.start.slice(0, 2), goal: view.doc.goal.slice(0, 2), [d.end]: d.at });
    else if (d?.id) {
      const item = view.doc.objects.find((o) => o.id === d.id);
      if (JSON.stringify(item.outline) !== JSON.stringify(d.outline)) change("objects", { id: d.id, outline: d.outline.map(kept) });
    } else if (d?.ruler !== undefined && view.ruler.length === 2) { root.querySelector("#tb-length").focus(); say("How long is that line? Say it in cm."); }
    paint();
  };
  svg.addEventListener("pointerup", done);
  svg.addEventListener("pointercancel", () => { view.drag = view.loop = null; paint(); });
  svg.addEventListener("wheel", (e) => { if (!e.ctrlKey) return; e.preventDefault(); zoom(e.deltaY > 0 ? 1.15 : 1 / 1.15, place(e)); }, { passive: false });
  svg.addEventListener("keydown", (e) => {
    const end = e.target.dataset?.handle, by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[e.key];
    if (!end || !by) return;
    const pace = whole()[2] / 100 * (e.shiftKey ? 5 : 1), [x, y] = view.doc[end];
    change("ends", { start: view.doc.start.slice(0, 2), goal: view.doc.goal.slice(0, 2), [end]: kept([x + by[0] * pace, y + by[1] * pace]) });
    e.preventDefault();
  });
  document.addEventListener("keydown", (e) => {
    if (!ready() || e.altKey || e.target.closest?.("input, select, textarea")) return;
    const held = e.ctrlKey || e.metaKey, letter = e.key.toLowerCase();
    if ((held && letter === "z") || (!held && letter === "u")) { e.shiftKey ? acts.redo() : acts.undo(); e.preventDefault(); }
    if (e.key === "Escape") { view.ruler = []; view.loop = null; pick("move"); }
  });
}

// Another tab or program may have changed the table.
setInterval(async () => {
  if (!ready() || !view.doc || view.drag || view.loop || root.contains(document.activeElement?.closest("input"))) return;
  try { const now = await ask("GET", "set"); if (now.version !== view.doc.version) await open(view.doc.scene_id).catch(() => open()); } catch { /* the next one may come */ }
}, 3000);

build();
listen();
await open(asked.get("scene")).catch(() => open());
root.dataset.ready = "yes";
prepared();
