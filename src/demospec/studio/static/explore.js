// Explore: all state of the tab is here; the server only answers questions about it.
import { SAID, chip, drawMap, drawSides, drawSmall, drawStage, percent } from "./explore-draw.js";
import { html, waitFor } from "./parts.js";
import { prepared, ready } from "./connection.js";

const root = await waitFor("#explore");
const state = { scene: null, model: null, type: null, control: [0, 0], moved: {}, added: [], removed: [] };
const view = { open: null, doc: null, steps: null, paths: null, selected: "control", stale: false };
const still = matchMedia("(prefers-reduced-motion: reduce)");

async function ask(what, body) {
  const answer = await fetch(`/explore/api/${what}`, {
    method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) });
  const found = await answer.json();
  if (!answer.ok) throw new Error(found.error || answer.statusText);
  return found;
}

// One question is under way at a time; while it is, only the latest state waits. While the hand
// moves, the way out of a rejection is left to follow; and maps that are shown are not asked for.
const REST_MS = 160;
let wanted = 0, answered = 0, moving = false, running = null, rest = 0;
function refresh(inMotion = false) {
  clearTimeout(rest);
  moving = inMotion;
  if (inMotion) rest = setTimeout(refresh, REST_MS);
  wanted += 1;
  running ||= askAll().finally(() => { running = null; });
  return running;
}

async function askAll() {
  while (answered !== wanted) {
    const now = wanted, quick = moving, asked = JSON.stringify(state);
    const late = setTimeout(() => { view.stale = true; paint(); }, 150);
    try {
      view.doc = merged(await ask("look", { ...state, moving: quick, has: view.doc.key }), view.doc);
      say("");
      Object.assign(root.dataset, { answered: asked, milliseconds: view.doc.milliseconds });
      if (!quick) root.dataset.settled = asked;
    } catch (error) { say(error.message, true); }
    clearTimeout(late);
    view.stale = false;
    answered = now;
    paint();
  }
}

// What an answer leaves out is as the page has it: a map is the same wherever the path leads.
function merged(found, known) {
  if (found.scene) return found;
  const kept = (verdicts, before) => verdicts.map((v, i) => ({ share: before[i].share, unknown: before[i].unknown, ...v }));
  const both = { ...known, ...found, verdicts: kept(found.verdicts, known.verdicts) };
  if (found.before) both.before = { ...known.before, verdicts: kept(found.before.verdicts, known.before.verdicts) };
  return both;
}

function changed(inMotion = false) { view.steps = view.paths = null; paint(); refresh(inMotion); }

function say(words, wrong = false) {
  const line = root.querySelector(".ex-said");
  line.textContent = words;
  line.classList.toggle("wrong", wrong);
}

// Where the page is, in its address: a link or a new tab opens the same view.
const asked = new URLSearchParams(location.search);
function remember() {
  const kept = new URLSearchParams(location.search);
  for (const name of ["scene", "model", "type"]) if (state[name]) kept.set(name, state[name]);
  kept.set("bend", state.control.map((v) => +v.toFixed(3)).join(","));
  history.replaceState(null, "", `?${kept}`);
}

async function openScene(scene, keep) {
  view.open = await ask("open", { scene, type: state.type });
  state.scene = view.open.scene.id;
  Object.assign(state, { control: view.open.control, moved: {}, added: [], removed: [] });
  if (!keep) {
    const named = view.open.models.find((m) => m.name === asked.get("model")) ?? view.open.models[0];
    state.model = named?.name ?? null;
    state.type = named?.types.includes(asked.get("type")) ? asked.get("type") : named?.types[0] ?? null;
    const bend = (asked.get("bend") ?? "").split(",").map(Number);
    if (bend.length === 2 && bend.every(Number.isFinite)) state.control = bend;
  }
  view.doc = { scene: view.open.scene, verdicts: [], small: [], map: null, why: null, before: null };
  view.steps = view.paths = null;
}

const choices = (names, chosen) => names.map((n) => new Option(n, n, n === chosen, n === chosen));

// The first thing that fits is chosen; one that does not says so.
function offer() {
  const box = root.querySelector("#ex-symbol"), before = box.value;
  box.replaceChildren(...view.open.symbols.map(({ name, fits }) => {
    const one = new Option(fits ? name : `${name} (no free place)`, name);
    one.disabled = !fits;
    return one;
  }));
  const free = view.open.symbols.filter((s) => s.fits).map((s) => s.name);
  box.value = free.includes(before) ? before : free.at(-1) ?? "";
  root.querySelector('[data-do="put"]').disabled = free.length === 0;
}

function build() {
  root.innerHTML = `
    <section class="ex-stage" aria-label="Scene">
      <div class="ex-bar">
        <label>Scene <span class="ex-pick"><button type="button" class="plain-button" data-do="previous" aria-label="Previous scene">‹</button>
          <select class="plain-input" id="ex-scene"></select>
          <button type="button" class="plain-button" data-do="next" aria-label="Next scene">›</button></span></label>
        <label>Judged by <select class="plain-input" id="ex-model"></select></label>
      </div>
      <svg id="ex-svg" class="ex-svg scene" role="group" aria-label="Scene with the path, its control point and the objects"></svg>
      <div class="ex-legend" aria-hidden="true">
        <span class="ex-ring-key"><i class="ring-least"></i>least and <i class="ring-most"></i>greatest distance that the answers allow</span>
        <span class="ex-ring-key"><b>?</b> not known</span><span><i class="place"></i>the place that decides</span>
      </div>
      <p class="soft ex-how">Drag the path, its round handle, or any object. Keyboard: Tab to a handle, arrow keys move it
        (Shift: five times as far), Delete takes an object away.</p>
    </section>
    <aside class="ex-panel">
      <div class="card ex-verdict" aria-live="polite"><p class="ex-word"></p><p class="ex-why soft"></p></div>
      <div class="ex-do">
        <button type="button" class="plain-button" data-do="repair">Repair <kbd>R</kbd></button>
        <button type="button" class="plain-button" data-do="sample">Solutions <kbd>S</kbd></button>
        <button type="button" class="plain-button" data-do="reset">Start over</button>
      </div>
      <p class="ex-said" role="status"></p>
      <div class="card ex-bend"><h2>Where may the path be bent to?</h2>
        <svg id="ex-map" role="img" aria-label="Map of the bend: where the path's handle makes it accepted, rejected, or not known"></svg>
        <p class="soft ex-shares"></p>
        <div class="ex-legend" aria-hidden="true"><span><i class="yes"></i>accepted</span><span><i class="no"></i>rejected</span><span class="ex-open-key"><i class="open"></i>not known</span>
          <span class="ex-doubt" hidden><i class="doubt"></i>10 % and 90 % sure</span></div></div>
      <div class="card"><h2>Who is asked</h2><div class="ex-sides" role="radiogroup" aria-label="Person"></div></div>
      <div class="card"><h2>What if one more stood there?</h2>
        <div class="ex-add"><select class="plain-input" id="ex-symbol" aria-label="What to put down"></select>
          <button type="button" class="plain-button" data-do="put">Put down</button></div>
        <div class="ex-before"></div></div>
    </aside>`;
  root.querySelector("#ex-scene").replaceChildren(...choices(view.open.scenes, state.scene));
  root.querySelector("#ex-model").replaceChildren(...choices(view.open.models.map((m) => m.name), state.model));
  offer();
  root.querySelector("#ex-scene").onchange = (e) => go(e.target.value);
  root.querySelector("#ex-model").onchange = (e) => {
    const model = view.open.models.find((m) => m.name === e.target.value);
    state.model = model.name;
    if (!model.types.includes(state.type)) state.type = model.types[0];
    changed();
  };
  root.addEventListener("click", (e) => {
    const button = e.target.closest("[data-do]");
    if (button) acts[button.dataset.do](button);
  });
}

async function go(scene) {
  try { await openScene(scene, true); } catch (error) { say(error.message, true); return; }
  root.querySelector("#ex-scene").value = state.scene;
  view.selected = "control";
  offer();
  changed();
}

const step = (by) => {
  const names = view.open.scenes, at = names.indexOf(state.scene) + by;
  return go(names[(at + names.length) % names.length]);
};

const acts = {
  previous: () => step(-1),
  next: () => step(1),
  reset: () => go(state.scene),
  type: (button) => { state.type = button.dataset.type; changed(); },
  async repair() {
    try {
      const found = await ask("repair", state);
      view.paths = null;
      const gone = finely(found.steps);
      for (let i = still.matches ? gone.length : 1; i <= gone.length; i++) {
        view.steps = gone.slice(0, i);
        state.control = gone[i - 1];
        paint();
        if (i < gone.length) await new Promise((done) => setTimeout(done, Math.min(120, 1500 / gone.length)));
      }
      state.control = found.control;
      view.steps = gone;
      await refresh();
      const judge = found.true_valid === null ? "Not checked against a known rule."
        : `The rule that made the labels ${found.true_valid ? "accepts" : "rejects"} it.`;
      say(!found.holds ? "No repair found: nothing near enough is accepted."
        : found.control_moved === 0 ? "Nothing to repair: the path is accepted as it is."
        : `Repaired: the path moves at most ${found.words}. ${judge}`);
    } catch (error) { say(error.message, true); }
  },
  async sample() {
    try {
      const found = await ask("sample", state);
      view.steps = null;
      view.paths = found.paths;
      paint();
      const judged = found.paths.filter((p) => p.true_valid !== null);
      const kept = judged.filter((p) => p.true_valid).length;
      say(found.paths.length === 0 ? "The model accepts no path here."
        : `${found.paths.length} solutions from ${found.modes} separate ${found.modes === 1 ? "region" : "regions"}. `
        + (judged.length ? `The rule that made the labels accepts ${kept} of them.` : "Not checked against a known rule."));
    } catch (error) { say(error.message, true); }
  },
  async put() {
    try {
      state.added.push(await ask("put", { ...state, symbol: root.querySelector("#ex-symbol").value }));
      changed();
    } catch (error) { say(error.message, true); }
  },
  takeBack() { state.added = []; changed(); },
};

// A repair of one or two long steps is shown with the way in between.
function finely(steps) {
  const parts = Math.max(1, Math.ceil(9 / Math.max(1, steps.length - 1)));
  const way = [steps[0]];
  for (let i = 1; i < steps.length; i++) {
    for (let k = 1; k <= parts; k++) way.push([0, 1].map((c) => steps[i - 1][c] + (k / parts) * (steps[i][c] - steps[i - 1][c])));
  }
  return way;
}

function paint() {
  if (!view.doc) return;
  const { doc } = view;
  root.classList.toggle("stale", view.stale);
  drawStage(root.querySelector("#ex-svg"), doc, state, view);
  if (state.model) drawMap(root.querySelector("#ex-map"), doc, state, view);
  drawSides(root.querySelector(".ex-sides"), doc, state);
  root.querySelector(".ex-doubt").hidden = !doc.map?.sure;
  root.querySelector(".ex-open-key").hidden = !doc.map || doc.map.open === null;
  for (const key of root.querySelectorAll(".ex-ring-key")) key.hidden = !doc.rings;
  const one = doc.verdicts.find((v) => v.type === state.type);
  if (one) {
    root.querySelector(".ex-word").replaceChildren(chip(one.verdict, SAID[one.verdict].word),
      doc.certain ? ` by ${state.type}` : ` by ${state.type}, valid with probability ${percent(one.p_valid)}`);
    root.querySelector(".ex-why").textContent = doc.why.sentence.replace(/\.$/, doc.why.counterfactual_follows ? " …" : ".");
    root.querySelector(".ex-verdict").setAttribute("aria-busy", String(moving));
    const open = doc.map?.open === null ? "" : `, not known of ${percent(doc.map.unknown)}`;
    root.querySelector(".ex-shares").textContent = doc.map ? `${state.type} accepts ${percent(doc.map.share)} of all bends${open}.` : "";
  }
  root.dataset.verdict = one ? one.verdict : "";
  if (one) remember();
  paintBefore(root.querySelector(".ex-before"), doc);
}

// What one more object changes, for everybody.
function paintBefore(box, doc) {
  if (!doc.before) {
    box.replaceChildren(html("p", { class: "soft" }, "Puts one more object near the path, in the picture and in the list, and compares."));
    return;
  }
  box.innerHTML = `<div class="ex-pair"><figure><svg></svg><figcaption>before</figcaption></figure>
    <figure><svg></svg><figcaption>after</figcaption></figure></div>
    <table><thead><tr><th>person</th><th>before</th><th>after</th><th>change</th></tr></thead><tbody></tbody></table>
    <p class="soft">Share of all paths here that are accepted; ✓ ✕ ? this path.</p>
    <button type="button" class="plain-button" data-do="takeBack">Take it away again</button>`;
  const at = doc.small.findIndex((m) => m.type === state.type);
  const [first, second] = box.querySelectorAll("svg");
  drawSmall(first, doc.before.scene, doc.before.small[at], state.control, doc.before.verdicts[at].verdict);
  drawSmall(second, doc.scene, doc.small[at], state.control, doc.verdicts[at].verdict);
  for (const [now, then] of doc.verdicts.map((v, i) => [v, doc.before.verdicts[i]])) {
    const row = box.querySelector("tbody").insertRow(), by = 100 * (now.share - then.share);
    const mark = (v) => `${percent(v.share)} ${SAID[v.verdict].mark}`;
    const change = Math.abs(by) < 0.05 ? "none" : `${by > 0 ? "+" : "−"}${Math.abs(by).toFixed(1)} %`;
    for (const text of [now.type, mark(then), mark(now), change]) row.insertCell().textContent = text;
  }
}

// Moving a handle, by pointer or by keyboard.
const within = (v, low, high) => Math.min(high, Math.max(low, v));

function moveTo(handle, x, y) {
  const { bounds, size } = view.doc.scene;
  const [x0, y0, x1, y1] = handle === "control" || !size ? bounds : [0, 0, ...size];
  const place = [+within(x, x0, x1).toPrecision(7), +within(y, y0, y1).toPrecision(7)];
  if (handle === "control") state.control = place;
  else {
    const item = view.doc.scene.objects.find((o) => o.id === handle);
    if (!item) return;
    if (item.added !== null) Object.assign(state.added[item.added], { x: place[0], y: place[1] });
    else state.moved[handle] = place;
  }
  view.selected = handle;
  changed(true);
}

export function placeOf(handle) {
  if (handle === "control") return state.control;
  const item = view.doc.scene.objects.find((o) => o.id === handle);
  if (item && item.added !== null && state.added[item.added]) return [state.added[item.added].x, state.added[item.added].y];
  return state.moved[handle] ?? item?.center ?? [0, 0];
}

// How far along the curve the point nearest to a place is, in [0.1, 0.9].
function along([x, y]) {
  const { start, goal } = view.doc.scene, c = state.control;
  let best = [Infinity, 0.5];
  for (let u = 0.1; u <= 0.9; u += 0.02) {
    const p = [0, 1].map((k) => (1 - u) ** 2 * start[k] + 2 * u * (1 - u) * c[k] + u * u * goal[k]);
    best = [best, [Math.hypot(p[0] - x, p[1] - y), u]].sort((a, b) => a[0] - b[0])[0];
  }
  return best[1];
}

function listen() {
  const svg = root.querySelector("#ex-svg"), map = root.querySelector("#ex-map");
  const at = (e, box) => {
    const p = new DOMPoint(e.clientX, e.clientY).matrixTransform(box.getScreenCTM().inverse());
    return [p.x, p.y];
  };
  let held = null;
  svg.addEventListener("pointerdown", (e) => {
    const handle = e.target.closest("[data-handle]")?.dataset.handle ?? (e.target.closest("[data-grip]") ? "path" : null);
    const path = e.target.closest("[data-control]")?.dataset.control;
    if (path) { state.control = JSON.parse(path); return changed(); }
    if (!handle || e.button > 0) return;
    const [x, y] = at(e, svg);
    if (handle === "path") {
      const u = along([x, y]); // a point of the curve moves by 2u(1 - u) of what its handle does
      held = { handle: "control", x, y, from: [...state.control], by: 1 / (2 * u * (1 - u)) };
    } else {
      held = { handle, x, y, from: placeOf(handle), by: handle === "control" ? 2 : 1 };
    }
    svg.setPointerCapture(e.pointerId);
    view.selected = held.handle;
    paint();
    svg.querySelector(`[data-handle="${CSS.escape(held.handle)}"]`)?.focus({ preventScroll: true });
    e.preventDefault();
  });
  const over = (e) => { const [x, y] = at(e, map); moveTo("control", x, y); };
  let onMap = false;
  map.addEventListener("pointerdown", (e) => { if (e.button > 0 || !state.model) return; onMap = true; map.setPointerCapture(e.pointerId); over(e); e.preventDefault(); });
  map.addEventListener("pointermove", (e) => { if (onMap) over(e); });
  svg.addEventListener("pointermove", (e) => {
    if (!held) return;
    const [x, y] = at(e, svg);
    moveTo(held.handle, held.from[0] + held.by * (x - held.x), held.from[1] + held.by * (y - held.y));
  });
  for (const box of [svg, map]) for (const end of ["pointerup", "pointercancel"]) box.addEventListener(end, () => {
    if ((held || onMap) && moving) refresh();
    held = null; onMap = false;
  });
  svg.addEventListener("keydown", (e) => {
    const handle = e.target.closest("[data-handle]")?.dataset.handle;
    const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[e.key];
    if (!handle) return;
    if (by) {
      const [x0, , x1] = view.doc.scene.bounds, pace = ((x1 - x0) / 140) * (e.shiftKey ? 5 : 1);
      const [x, y] = placeOf(handle);
      moveTo(handle, x + by[0] * pace, y + by[1] * pace);
      e.preventDefault();
    } else if ((e.key === "Delete" || e.key === "Backspace") && handle !== "control") {
      const item = view.doc.scene.objects.find((o) => o.id === handle);
      if (item && item.added !== null) state.added.splice(item.added, 1);
      else { delete state.moved[handle]; state.removed.push(handle); }
      view.selected = "control";
      e.preventDefault();
      changed();
    }
  });
  document.addEventListener("keydown", (e) => {
    if (!ready() || e.ctrlKey || e.metaKey || e.altKey || e.target.closest?.("input, select, textarea")) return;
    if (e.key === "r" || e.key === "R") acts.repair();
    if (e.key === "s" || e.key === "S") acts.sample();
  });
}

try {
  await openScene(asked.get("scene"), false).catch(() => openScene(null, false));
  build();
  listen();
  if (state.model) await refresh();
  else { root.classList.add("none"); say("Nothing is understood yet. Accept or reject a path or two under Teach, or start the studio with --model."); }
  paint();
  root.dataset.ready = "yes";
} catch (error) {
  root.innerHTML = '<p class="ex-said wrong"></p>';
  root.querySelector("p").textContent = error.message;
  root.dataset.ready = "failed";
}
prepared();
