// Drawing on the Teach page: a stroke is collected here and sent once, on release.
import { handshake, prepared, ready } from "./connection.js";
import { steps } from "./parts.js";

const NS = "http://www.w3.org/2000/svg";
const MOST_BYTES = 12 * 1024 * 1024; // as the server has it
const REACH = 0.1; // of the picture's width: how near a stroke must begin and end
const $ = (id) => document.getElementById(id);
const tab = sessionStorage.demospecTab || (sessionStorage.demospecTab = "tab-" + Math.random().toString(36).slice(2, 12));
let stroke = null, control = null, said = "";

const pen = () => $("pen");
const info = () => JSON.parse($("stage").dataset.scene || "null");
const send = (name, value) => emitEvent(name, value);
const near = (p, q) => Math.hypot(p[0] - q[0], p[1] - q[1]) <= REACH * info().width;

// The line under the scene: what is under the pointer, else what to do next. What went wrong
// stays for a while.
let heldUntil = 0;
function tell(words) { if (performance.now() >= heldUntil) write(words || $("stage").dataset.hint || "", false); }
function warn(words) {
  heldUntil = performance.now() + 5000;
  write(words, true);
  setTimeout(() => tell(""), 5050);
}
function write(words, held) {
  const line = $("hint");
  if (!line || words === said) return;
  said = words; line.textContent = words; line.classList.toggle("held", held);
}
// Milliseconds as seconds, no two alike: a browser may report two points of one moment.
function rising(times) {
  let last = -1;
  return times.map((s) => { last = Math.max(Math.round(s * 1000), last + 1); return last / 1000; });
}
function place(e) {
  const p = new DOMPoint(e.clientX, e.clientY).matrixTransform(pen().getScreenCTM().inverse());
  return [Math.round(p.x * 100) / 100, Math.round(p.y * 100) / 100];
}
function show(points, name) {
  let line = pen().querySelector("." + name);
  if (!line) { line = pen().appendChild(document.createElementNS(NS, "polyline")); line.setAttribute("class", name); }
  line.setAttribute("points", points.map((p) => p.join(",")).join(" "));
}
function clear(name) { pen()?.querySelectorAll("." + name).forEach((e) => e.remove()); }

function begin(e) {
  if (e.button > 0 || !e.isPrimary) return;
  const scene = info();
  if (!scene) return;
  pen().setPointerCapture(e.pointerId);
  const p = place(e);
  const began = near(p, scene.start);
  stroke = { points: [began ? scene.start : p], t: [0], from: e.timeStamp, began };
  cancelCurve();
  e.preventDefault(); pen().focus({ preventScroll: true });
}
function move(e) {
  if (!stroke) return hover(e);
  for (const one of e.getCoalescedEvents?.().length ? e.getCoalescedEvents() : [e]) {
    const p = place(one), last = stroke.points[stroke.points.length - 1];
    if (Math.hypot(p[0] - last[0], p[1] - last[1]) < info().width / 300) continue;
    if (stroke.points.length < 4900) { stroke.points.push(p); stroke.t.push(Math.max(0, one.timeStamp - stroke.from) / 1000); }
  }
  if (stroke.began) show(stroke.points, "drawing");
}
function end(e) {
  if (!stroke) return;
  const done = stroke, scene = info(); stroke = null;
  clear("drawing");
  const last = done.points[done.points.length - 1];
  if (done.points.length < 3) { const id = pathAt(e); if (id) send("teach_pick", id); return; }
  if (!done.began) return warn("Begin at the circle: that is where the motion starts.");
  if (!near(last, scene.goal)) return warn("End at the star: that is where the motion must arrive.");
  // The stroke ends at the goal itself; its last point is where the hand let go.
  done.points[done.points.length - 1] = scene.goal;
  send("teach_stroke", { scene: scene.id, points: done.points, t: rising(done.t) });
}
function under(e, what) { return document.elementsFromPoint(e.clientX, e.clientY).map((x) => x.closest(what)).find(Boolean); }
function pathAt(e) { return under(e, ".path")?.dataset.id; }
function hover(e) {
  document.querySelectorAll("#stage .hovered").forEach((x) => x.classList.remove("hovered"));
  const found = under(e, "#stage .path[data-id]") || under(e, "#stage .object");
  if (!found) return tell("");
  found.classList.add("hovered");
  tell(found.querySelector("title")?.textContent || "");
}

// By keyboard: the arrow keys move the control point of a curve, Enter draws it.
function curve() {
  const s = info(), c = control, out = [];
  for (let i = 0; i <= 48; i++) {
    const u = i / 48, a = (1 - u) * (1 - u), b = 2 * u * (1 - u), d = u * u;
    out.push([0, 1].map((k) => Math.round((a * s.start[k] + b * c[k] + d * s.goal[k]) * 100) / 100));
  }
  return out;
}
function cancelCurve() { control = null; clear("curve"); clear("handle"); }
function bend(dx, dy) {
  const s = info();
  control ||= [(s.start[0] + s.goal[0]) / 2, (s.start[1] + s.goal[1]) / 2];
  control = [control[0] + dx, control[1] + dy];
  show(curve(), "curve");
  tell("Arrow keys bend the path, Enter draws it, Escape drops it.");
}
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

function key(e) {
  const target = e.target, type = target.tagName;
  if (!ready() || /^(INPUT|SELECT|TEXTAREA)$/.test(type)) return;
  if (target === pen() && ARROWS[e.key]) {
    const step = info().width * (e.shiftKey ? 0.08 : 0.02);
    bend(ARROWS[e.key][0] * step, ARROWS[e.key][1] * step);
    return e.preventDefault();
  }
  if (control && e.key === "Enter" && target === pen()) {
    const points = curve(); cancelCurve();
    send("teach_stroke", { scene: info().id, points, t: null });
    return e.preventDefault();
  }
  if (e.key === "Escape") { cancelCurve(); stroke = null; clear("drawing"); return; }
  const letter = e.key.toLowerCase(), held = e.ctrlKey || e.metaKey;
  let what = null;
  if (held && letter === "z") what = e.shiftKey ? "redo" : "undo";
  else if (held && letter === "y") what = "redo";
  else if (held || e.altKey) return;
  else if (letter === "a") what = "accept";
  else if (letter === "r") what = "reject";
  else if (letter === "u") what = e.shiftKey ? "redo" : "undo";
  else if (letter === "n") what = "next";
  else if (letter === "q") what = "ask";
  else if (e.key === "Delete") what = "delete";
  else if (e.key === " " && !/^(BUTTON|A|SUMMARY)$/.test(type)) { replay(); return e.preventDefault(); }
  if (what) { send("teach_key", what); e.preventDefault(); }
}

// Replay: a dot runs along the chosen path, in two seconds at speed 1.
let running = 0;
function replay() {
  const line = document.querySelector("#stage .path.chosen") || document.querySelector("#stage .question-path");
  if (!line) return warn("Choose a path first: click it.");
  const points = line.getAttribute("points").trim().split(/\s+/).map((p) => p.split(",").map(Number));
  const length = [0];
  for (let i = 1; i < points.length; i++) length.push(length[i - 1] + Math.hypot(points[i][0] - points[i - 1][0], points[i][1] - points[i - 1][1]));
  const speed = Number($("speed")?.value || 1), total = length[length.length - 1], lasts = 2000 / speed, mine = ++running;
  clear("runner");
  const dot = pen().appendChild(document.createElementNS(NS, "circle"));
  dot.setAttribute("class", "runner"); dot.setAttribute("r", info().width / 60);
  const began = performance.now();
  const step = (now) => {
    if (mine !== running) return;
    const at = Math.min(1, (now - began) / lasts) * total;
    let i = 1; while (i < length.length - 1 && length[i] < at) i++;
    const u = length[i] > length[i - 1] ? (at - length[i - 1]) / (length[i] - length[i - 1]) : 1;
    dot.setAttribute("cx", points[i - 1][0] + u * (points[i][0] - points[i - 1][0]));
    dot.setAttribute("cy", points[i - 1][1] + u * (points[i][1] - points[i - 1][1]));
    if (at < total) requestAnimationFrame(step); else setTimeout(() => mine === running && clear("runner"), 400);
  };
  requestAnimationFrame(step);
}

async function addPicture(file) {
  if (!file) return;
  if (file.size > MOST_BYTES) return warn("That picture is larger than 12 MB.");
  const name = encodeURIComponent(file.name.replace(/\.[^.]*$/, "").slice(0, 40));
  try {
    const answer = await fetch("/api/scenes?name=" + name, { method: "POST", body: file, headers: { "Content-Type": "application/octet-stream" } });
    const text = await answer.text();
    if (answer.ok) return location.assign("/table?scene=" + encodeURIComponent(JSON.parse(text).scene_id));
    let why = text;
    try { why = JSON.parse(text).detail; } catch { /* plain words of the guard */ }
    warn("That picture cannot be used: " + why);
  } catch { warn("The picture did not reach the studio. Is it still running?"); }
}

// Words that are being typed belong to the person until they are sent (`change`).
const typed = new Set();
function remember(state, fields) {
  sessionStorage.demospecTeach = JSON.stringify(state);
  // A link or a new tab opens the same view.
  const kept = new URLSearchParams({ scene: state.scene, type: state.type });
  if (state.chosen) kept.set("path", state.chosen);
  history.replaceState(null, "", "?" + kept);
  for (const [id, value] of Object.entries(fields)) if (!typed.has(id)) $(id).value = value;
  prepared(); // the studio has answered this tab's greeting
}

async function start() {
  await handshake();
  // On the stage, which stays: the pen is made anew where a picture has another size.
  const stage = $("stage");
  stage.addEventListener("pointerdown", begin); stage.addEventListener("pointermove", move);
  stage.addEventListener("pointerup", end); stage.addEventListener("pointercancel", () => { stroke = null; clear("drawing"); });
  stage.addEventListener("focusout", cancelCurve);
  document.addEventListener("keydown", key);
  document.addEventListener("input", (e) => typed.add(e.target.id));
  document.addEventListener("change", (e) => typed.delete(e.target.id));
  // A new person begins where somebody says so, not where words are typed.
  const add = () => {
    const name = $("type-field").value.trim();
    if (!name) return warn("Say first who it is.");
    $("type-field").value = ""; typed.delete("type-field"); $("new-person").open = false;
    send("teach_type", name);
  };
  $("add-person").addEventListener("click", add);
  $("type-field").addEventListener("keydown", (e) => { if (e.key === "Enter") add(); });
  $("replay").addEventListener("click", replay);
  $("picture-file").addEventListener("change", (e) => { addPicture(e.target.files[0]); e.target.value = ""; });
  window.teachRemember = remember;
  window.teachTell = warn;
  window.teachSteps = (all, scene, type) => steps(document, all, scene, type);
  new MutationObserver(() => { heldUntil = 0; tell(""); }).observe(stage, { attributeFilter: ["data-hint"] });
  tell("");
  let kept = {};
  try { kept = JSON.parse(sessionStorage.demospecTeach || "{}"); } catch { kept = {}; }
  const linked = new URLSearchParams(location.search);
  for (const [name, key] of [["scene", "scene"], ["type", "type"], ["path", "chosen"]]) if (linked.get(name)) kept[key] = linked.get(name);
  if (linked.get("scene") && !linked.get("path")) kept.chosen = null;
  send("teach_hello", { tab, ...kept });
}
start();
