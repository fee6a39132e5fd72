// Recordings of other programs: dropped, tried, looked at, taken in.
import { html } from "./parts.js";
import { ask, figure, tab } from "./thumbs.js";

const PIECE = 4 << 20;
const SAYS = ["auto", "none", "folder", "file", "always:"];
/** Field of the wizard → [label, what it means, choices (none: free text)]. */
const FIELDS = {
  x: ["x", "column"], y: ["y", "column"], z: ["z", "column, where there is one"],
  time: ["Time", "column, or none"], time_unit: ["Unit of time", "", ["", "s", "ms", "us", "ns"]],
  units: ["Unit", "of x and y", ["", "px", "m", "cm", "mm"]],
  metres_per_unit: ["One pixel is", "mm on the table"],
  plane: ["Plane", "of 3-D points", ["", "xy", "zx", "yz", "xz"]],
  valid: ["Verdict", "column, folder, always:accepted or none"],
  type: ["Whose", "column, folder, always:NAME or none"],
  scene: ["Scene", "column, folder or none"],
  demonstration: ["Paths told apart by", "column"],
  path: ["Path", "topic, array or feature"],
  format: ["Format", "", ["", "tables", "json", "lerobot", "hdf5", "ros", "label-studio", "cvat", "demospec"]],
};

/** Every file of a drop, folders opened, as [path, File]. */
async function filesOf(transfer) {
  const entries = [...transfer.items].map((i) => i.webkitGetAsEntry?.()).filter(Boolean);
  if (!entries.length) return [...transfer.files].map((f) => [f.name, f]);
  const found = [];
  const open = async (entry) => {
    if (entry.isFile) return found.push([entry.fullPath.slice(1), await new Promise((yes, no) => entry.file(yes, no))]);
    const reader = entry.createReader();
    for (;;) {
      const some = await new Promise((yes, no) => reader.readEntries(yes, no));
      if (!some.length) return;
      for (const e of some) await open(e);
    }
  };
  for (const e of entries) await open(e);
  return found;
}

/** The card that brings recordings; `taken` is called once they are in the set. */
export function importing(root, taken) {
  let batch = null, doc = null, busy = false;
  root.innerHTML = `
    <h2>Bring recordings</h2>
    <p class="soft">Drop CSV, Parquet, MCAP or ROS bags, LeRobot, HDF5, JSON or a demospec set anywhere on this page: files, a folder, or a zip. Nothing is taken in before you have seen how it is read; your files are only read.</p>
    <div class="rv-do"><label class="plain-button" tabindex="-1">Choose files…<input class="out-of-sight im-files" type="file" multiple></label>
      <label class="plain-button" tabindex="-1">Choose a folder…<input class="out-of-sight im-folder" type="file" webkitdirectory></label></div>
    <p class="im-said" role="status"></p><progress class="im-bar" max="1" aria-label="Reading" hidden></progress>
    <div class="im-found" hidden>
      <p class="im-what"></p><dl class="im-read"></dl><div class="dm-grid im-paths"></div>
      <details class="im-how"><summary>Read it differently</summary><div class="im-fields"></div>
        <datalist id="im-columns"></datalist>
        <label class="dm-check"><input type="checkbox" name="drop_missing"> Leave out missing points</label>
        <div class="rv-do"><button type="button" class="plain-button" data-im="look">Read it like this</button></div></details>
      <label class="im-onto">Where they go <select class="plain-input" name="onto"></select></label>
      <details><summary>Every decision</summary><ul class="im-notes"></ul></details>
      <div class="rv-do"><button type="button" class="plain-button primary" data-im="take"></button><button type="button" class="plain-button" data-im="leave">Leave them</button></div></div>`;
  const one = (s) => root.querySelector(s), field = (n) => root.querySelector(`[name="${n}"]`);
  one(".im-fields").replaceChildren(...Object.entries(FIELDS).map(([name, [label, hint, choices]]) => {
    const input = choices ? html("select", { class: "plain-input", name }) : html("input", { class: "plain-input", name, list: name === "metres_per_unit" ? null : "im-columns", autocomplete: "off", inputmode: name === "metres_per_unit" ? "decimal" : null });
    if (choices) input.append(...choices.map((c) => new Option(c || "as it says", c)));
    return html("label", {}, html("span", {}, label), input, html("small", { class: "soft" }, hint));
  }));
  const say = (words, wrong = false) => { one(".im-said").textContent = words; one(".im-said").classList.toggle("wrong", wrong); };
  const bar = (share) => { one(".im-bar").hidden = share === null; if (share) one(".im-bar").value = share; else one(".im-bar").removeAttribute("value"); };

  function how() {
    const said = {}, columns = {};
    for (const name of Object.keys(FIELDS)) {
      const value = field(name).value.trim();
      if (!value) continue;
      if (["x", "y", "z"].includes(name)) columns[name] = value;
      else said[name] = name === "metres_per_unit" ? Number(value.replace(",", ".")) / 1000 : value;
    }
    if (Object.keys(columns).length) said.columns = columns;
    if (field("drop_missing").checked) said.drop_missing = true;
    return said;
  }

  async function during(words, work) {
    if (busy) return;
    busy = true;
    for (const b of root.querySelectorAll("[data-im]")) b.disabled = true;
    say(words); bar(0);
    const watch = setInterval(async () => {
      if (batch === null) return;
      try { const p = await ask("GET", `import/progress?${new URLSearchParams({ batch })}`); if (p.what) { say(`${words} ${p.what} ${Math.round(100 * p.share)} %`); bar(p.share); } } catch { /* it ends with an answer */ }
    }, 700);
    try { await work(); } catch (error) { say(error.message, true); } finally {
      clearInterval(watch); bar(null); busy = false;
      for (const b of root.querySelectorAll("[data-im]")) b.disabled = false;
      if (doc) one('[data-im="take"]').disabled = Boolean(doc.problem);
    }
  }

  async function send(files) {
    if (!files.length) return;
    await during("Sending…", async () => {
      batch = null; doc = null;
      for (const name of Object.keys(FIELDS)) field(name).value = "";
      field("drop_missing").checked = false;
      const begun = (await ask("POST", "import")).batch, all = files.reduce((n, [, f]) => n + f.size, 0) || 1;
      let sent = 0;
      for (const [name, file] of files) for (let at = 0; at === 0 || at < file.size; at += PIECE) {
        const piece = file.slice(at, at + PIECE);
        const answer = await fetch(`/api/import/file?${new URLSearchParams({ batch: begun, name, offset: at, actor: tab })}`, { method: "POST", body: piece, headers: { "Content-Type": "application/octet-stream" } });
        if (!answer.ok) throw new Error((await answer.json()).detail ?? "not taken");
        bar((sent += piece.size) / all);
      }
      batch = begun;
    });
    if (batch !== null) await look();
  }

  const look = () => during("Reading…", async () => {
    doc = null;
    try { doc = await ask("POST", "import/look", { batch, how: how(), onto: field("onto").value }); } catch (error) {
      one(".im-found").hidden = false; one(".im-how").open = true; one(".im-what").textContent = "It cannot be read like this yet: say how below.";
      one('[data-im="take"]').hidden = true;
      throw error;
    }
    show();
  });

  function show() {
    const r = doc.read, row = (term, words) => words && [html("dt", {}, term), html("dd", {}, words)];
    one(".im-found").hidden = false;
    const paths = `${doc.count} ${doc.count === 1 ? "path" : "paths"}`;
    one(".im-what").textContent = `${doc.source} (${doc.format}): ${paths} in ${doc.scene_ids.length} ${doc.scene_ids.length === 1 ? "scene" : "scenes"}.`;
    const people = doc.types.length ? doc.types.join(", ") : "nobody is named";
    one(".im-read").replaceChildren(...[
      r && row("Columns", r.columns.map((c) => `${c.meaning} from ${c.column || "(no name)"}${c.unit ? ` (${c.unit})` : ""}`).join(" · ")),
      r?.not_read.length && row("Not read", r.not_read.slice(0, 20).join(", ")),
      row("Lengths", `${doc.units}${r ? `, ${r.frame.how}` : ""}${doc.metres_per_unit && doc.units === "px" ? `; one pixel is ${+(1000 * doc.metres_per_unit).toPrecision(4)} mm` : ""}`),
      r && row("Frame", `${r.frame.name ?? "not named"}, y ${r.frame.y}`),
      r?.time && row("Time", `${r.time.unit} from ${r.time.column}`),
      row("Verdicts", r ? `${r.labelled.accepted} accepted, ${r.labelled.rejected} rejected, ${r.labelled.not_judged} not said` : `${doc.judged} of ${doc.count} said`),
      row("Whose", people),
      r && row("Objects", r.objects.objects ? `${r.objects.objects} in ${r.objects.matched} scenes` : "none listed: mark them under Table"),
      doc.changes.length && row("In this session", doc.changes.join("; ")),
    ].filter(Boolean).flat());
    one(".im-paths").replaceChildren(...doc.demonstrations.map((d) => figure(doc.scenes[d.scene_id], d)));
    one(".im-notes").replaceChildren(...doc.notes.map((n) => html("li", {}, n)));
    const names = r ? [...r.columns.flatMap((c) => c.column.split(", ")), ...r.not_read] : [];
    root.querySelector("#im-columns").replaceChildren(...[...new Set([...names, ...SAYS])].filter(Boolean).map((n) => new Option(n)));
    const was = field("onto").value;
    field("onto").replaceChildren(new Option(doc.scene_ids.length === 1 ? "a new scene" : `${doc.scene_ids.length} new scenes`, ""), ...doc.existing.map((n) => new Option(`the scene ${n}`, n)));
    field("onto").value = was;
    one('[data-im="take"]').hidden = false;
    one('[data-im="take"]').textContent = `Take in ${paths}`;
    say(doc.problem, Boolean(doc.problem));
  }

  const acts = {
    look,
    take: () => during("Taking in…", async () => {
      const done = await ask("POST", "import/take", { batch, how: how(), onto: field("onto").value });
      acts.leave();
      await taken(done.taken);
    }),
    leave() { batch = null; doc = null; one(".im-found").hidden = true; say(""); },
  };
  root.addEventListener("click", (e) => { const b = e.target.closest("[data-im]"); if (b) acts[b.dataset.im](); });
  field("onto").addEventListener("change", look);
  for (const input of [one(".im-files"), one(".im-folder")]) input.addEventListener("change", () => {
    const files = [...input.files].map((f) => [f.webkitRelativePath || f.name, f]);
    input.value = "";
    send(files);
  });
  document.addEventListener("dragover", (e) => { if (e.dataTransfer?.types.includes("Files")) { e.preventDefault(); root.classList.add("im-over"); } });
  document.addEventListener("dragleave", (e) => { if (!e.relatedTarget) root.classList.remove("im-over"); });
  document.addEventListener("drop", async (e) => {
    if (!e.dataTransfer?.types.includes("Files")) return;
    e.preventDefault();
    root.classList.remove("im-over");
    root.scrollIntoView({ block: "nearest" });
    send(await filesOf(e.dataTransfer));
  });
}
