// Demonstrations: every path as a small picture; filters, bulk changes, people, history.
import { prepared, ready } from "./connection.js";
import { importing } from "./import.js";
import { html, waitFor } from "./parts.js";
import { ask, figure, tab, teachAt } from "./thumbs.js";

const root = await waitFor("#demonstrations");
const asked = new URLSearchParams(location.search);
const chosen = new Set();
let doc = null;
const FILTERS = ["type", "verdict", "scene_id", "contradicting", "page"];
const field = (name) => root.querySelector(`[name=${name}]`);

function say(words, wrong = false) {
  const line = root.querySelector(".rv-said");
  line.textContent = words;
  line.classList.toggle("wrong", wrong);
}

async function load() {
  const query = new URLSearchParams(FILTERS.filter((n) => asked.get(n)).map((n) => [n, asked.get(n)]));
  doc = await ask("GET", `gallery?${query}${query.size ? "&" : ""}wait=false`);
  if (doc.learning) setTimeout(() => load().catch((error) => say(error.message, true)), 1000);
  history.replaceState(null, "", query.size ? `?${query}` : location.pathname);
  paint();
}

const options = (names, all) => [new Option(all, ""), ...names.map((n) => new Option(n === "me" ? "you" : n, n))];

function paint() {
  field("type").replaceChildren(...options(doc.types, "everybody"));
  field("scene_id").replaceChildren(...options(doc.scene_ids, "all scenes"));
  field("give").replaceChildren(...doc.types.map((n) => new Option(n === "me" ? "you" : n, n)), new Option("somebody else…", ""));
  for (const name of ["merge", "into"]) { const was = field(name).value; field(name).replaceChildren(...doc.scene_ids.map((n) => new Option(n))); if (doc.scene_ids.includes(was)) field(name).value = was; }
  field("rename").replaceChildren(...doc.types.map((n) => new Option(n === "me" ? "you" : n, n)));
  for (const name of ["type", "verdict", "scene_id"]) field(name).value = asked.get(name) ?? "";
  field("contradicting").checked = asked.get("contradicting") === "true";
  root.querySelector(".dm-count").textContent = doc.count === doc.all ? `${doc.all} ${doc.all === 1 ? "path" : "paths"}` : `${doc.count} of ${doc.all} paths`;
  root.querySelector(".dm-grid").replaceChildren(...doc.demonstrations.map((d) => {
    const box = html("input", { type: "checkbox", "aria-label": `Choose ${d.name}` });
    box.checked = chosen.has(d.demo_id);
    box.onchange = () => { box.checked ? chosen.add(d.demo_id) : chosen.delete(d.demo_id); marked(); };
    return figure(doc.scenes[d.scene_id], d, html("div", { class: "dm-under" }, html("label", {}, box, " choose"), html("a", { href: teachAt(d) }, "open")));
  }));
  if (!doc.demonstrations.length) root.querySelector(".dm-grid").replaceChildren(html("p", { class: "soft" }, doc.learning ? "Learning from the labels…" : doc.all ? "No path passes these filters." : "Nothing was drawn yet: begin under Teach, or drop recordings here."));
  root.querySelector(".dm-page").textContent = `page ${doc.page + 1} of ${doc.pages}`;
  root.querySelector('[data-do="before"]').disabled = doc.page === 0;
  root.querySelector('[data-do="after"]').disabled = doc.page + 1 >= doc.pages;
  marked();
}

function marked() {
  root.querySelector(".dm-chosen").textContent = chosen.size ? `${chosen.size} chosen` : "Choose paths to change them together.";
  for (const b of root.querySelectorAll("[data-bulk]")) b.disabled = chosen.size === 0;
}

async function change(body, words) {
  try {
    const { changed } = await ask("POST", "change", { demo_ids: [...chosen], ...body });
    chosen.clear();
    await load(); await past();
    say(`${changed} ${changed === 1 ? "path" : "paths"} ${words}. Undo takes it back.`);
  } catch (error) { say(error.message, true); }
}

const acts = {
  before: () => { asked.set("page", doc.page - 1); load(); },
  after: () => { asked.set("page", doc.page + 1); load(); },
  all: () => { for (const d of doc.demonstrations) chosen.add(d.demo_id); paint(); },
  none: () => { chosen.clear(); paint(); },
  accept: () => change({ valid: true }, "accepted"),
  reject: () => change({ valid: false }, "rejected"),
  unsay: () => change({ valid: null }, "without a verdict"),
  give: () => {
    const name = field("give").value || field("somebody").value.trim();
    if (!name) { field("somebody").hidden = false; field("somebody").focus(); return say("Say who it is.", true); }
    change({ type: name }, `given to ${name === "me" ? "you" : name}`);
  },
  remove: () => change({ delete: true }, "deleted"),
  async rename() {
    try {
      const { changed } = await ask("POST", "person", { type: field("rename").value, name: field("name").value });
      field("name").value = "";
      asked.delete("type");
      await load(); await past();
      say(`${changed} paths have another name. Undo takes it back.`);
    } catch (error) { say(error.message, true); }
  },
  async scene(words, method, path, body) {
    try {
      await ask(method, path, body);
      asked.delete("scene_id");
      await load(); await past();
      say(`${words} Undo takes it back.`);
    } catch (error) { say(error.message, true); }
  },
  "rename-scene": () => acts.scene("The scene has another name.", "PUT", "scene-name", { scene_id: field("merge").value, name: field("scene-name").value.trim() }).then(() => { field("scene-name").value = ""; }),
  "merge-scene": () => acts.scene(`The paths of ${field("merge").value} are now in ${field("into").value}.`, "POST", "scene-merge", { scene_id: field("merge").value, into: field("into").value }),
  "drop-scene": () => acts.scene(`The scene ${field("merge").value} is gone, with its paths.`, "DELETE", `scene?${new URLSearchParams({ scene_id: field("merge").value })}`),
  undo: () => back("undo"),
  redo: () => back("redo"),
};

async function back(what) {
  try {
    const done = (await ask("POST", what))[what === "undo" ? "undone" : "redone"];
    await load(); await past();
    say(done ? "" : `Nothing is left to ${what} in this tab.`, !done);
  } catch (error) { say(error.message, true); }
}

async function past() {
  const { history: all } = await ask("GET", `history?${new URLSearchParams({ actor: tab })}`);
  const when = new Intl.DateTimeFormat(undefined, { dateStyle: "short", timeStyle: "short" });
  root.querySelector(".dm-history").replaceChildren(...all.map((e) => html("li", { class: e.undone ? "undone" : null }, html("time", {}, when.format(e.at * 1000)), ` ${e.who} ${e.what}${e.undone ? " (undone)" : ""}`)));
}

root.innerHTML = `
  <form class="dm-filters">
    <label>Whose <select class="plain-input" name="type"></select></label>
    <label>Verdict <select class="plain-input" name="verdict"><option value="">all</option><option>accepted</option><option>rejected</option><option>unsaid</option></select></label>
    <label>Scene <select class="plain-input" name="scene_id"></select></label>
    <label class="dm-check"><input type="checkbox" name="contradicting"> contradicting others</label>
    <span class="dm-count" aria-live="polite"></span></form>
  <div class="dm-list"><div class="dm-bulk"><span class="dm-chosen"></span>
    <button type="button" class="plain-button small" data-do="all">Choose this page</button><button type="button" class="plain-button small" data-do="none" data-bulk>Choose none</button>
    <button type="button" class="plain-button small" data-do="accept" data-bulk>Accept</button><button type="button" class="plain-button small" data-do="reject" data-bulk>Reject</button>
    <button type="button" class="plain-button small" data-do="unsay" data-bulk>No verdict</button><button type="button" class="plain-button small" data-do="remove" data-bulk>Delete</button>
    <span class="dm-give"><button type="button" class="plain-button small" data-do="give" data-bulk>Give to</button><select class="plain-input" name="give" aria-label="Give the chosen paths to"></select><input class="plain-input" name="somebody" aria-label="Who?" placeholder="who?" maxlength="60" hidden></span>
    <button type="button" class="plain-button small" data-do="undo">Undo <kbd>U</kbd></button><button type="button" class="plain-button small" data-do="redo">Redo</button></div>
  <p class="rv-said" role="status"></p>
  <div class="dm-grid"></div>
  <div class="dm-pages"><button type="button" class="plain-button small" data-do="before">← Earlier</button><span class="dm-page"></span><button type="button" class="plain-button small" data-do="after">Later →</button></div></div>
  <div class="dm-below"><section class="card dm-import"></section><section class="card"><h2>People</h2><p class="soft">Another name for all paths of a person. The name of somebody who is there already makes two people one.</p>
    <div class="tb-line"><select class="plain-input" name="rename" aria-label="Person"></select><span>is now</span><input class="plain-input" name="name" aria-label="New name" maxlength="60" autocomplete="off"><button type="button" class="plain-button" data-do="rename">Rename</button></div></section>
    <section class="card"><h2>Scenes</h2><p class="soft">Another name, or two pictures of the same table in one: the paths of the first go to the second.</p>
    <div class="tb-line"><select class="plain-input" name="merge" aria-label="Scene"></select><span>is now</span><input class="plain-input" name="scene-name" aria-label="New name of the scene" maxlength="60" autocomplete="off"><button type="button" class="plain-button" data-do="rename-scene">Rename</button></div>
    <div class="tb-line"><span>its paths go to</span><select class="plain-input" name="into" aria-label="Scene that gets the paths"></select><button type="button" class="plain-button" data-do="merge-scene">Merge</button><button type="button" class="plain-button" data-do="drop-scene">Delete with its paths</button></div></section>
    <section class="card"><h2>What happened</h2><ol class="dm-history"></ol></section></div>`;
root.querySelector(".dm-filters").addEventListener("submit", (e) => e.preventDefault());
root.querySelector(".dm-filters").addEventListener("change", (e) => {
  const { name } = e.target;
  asked.set(name, name === "contradicting" ? String(e.target.checked) : e.target.value);
  if (!asked.get(name) || asked.get(name) === "false") asked.delete(name);
  asked.delete("page");
  load().catch((error) => say(error.message, true));
});
field("give").addEventListener("change", () => { field("somebody").hidden = field("give").value !== ""; });
root.addEventListener("click", (e) => { const b = e.target.closest("[data-do]"); if (b) acts[b.dataset.do](); });
document.addEventListener("keydown", (e) => {
  if (!ready() || e.altKey || e.target.closest?.("input:not([type=checkbox]), select")) return;
  const held = e.ctrlKey || e.metaKey, letter = e.key.toLowerCase();
  if ((held && letter === "z") || (!held && letter === "u")) { e.shiftKey ? acts.redo() : acts.undo(); e.preventDefault(); }
});
importing(root.querySelector(".dm-import"), async (count) => { await load(); await past(); say(`${count} ${count === 1 ? "path was" : "paths were"} taken in. Undo takes them back.`); });
try { await load(); await past(); } catch (error) { say(error.message, true); }
prepared();
setInterval(async () => {
  if (!ready()) return;
  try { if ((await ask("GET", "set")).version !== doc?.version) { await load(); await past(); } } catch { /* the next one may come */ }
}, 3000);
