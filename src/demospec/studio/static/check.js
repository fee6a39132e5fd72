// Check: everybody side by side, contradictions with both paths, unsaid paths one by one, labels
// that look wrong.
import { prepared, ready } from "./connection.js";
import { html, steps, waitFor } from "./parts.js";
import { WORDS, ask, figure, teachAt } from "./thumbs.js";

const root = await waitFor("#check");
const asked = new URLSearchParams(location.search);
const view = { doc: null, at: { doubts: 0, unsaid: 0, wrong: 0 }, audit: false };
const button = (words, act, look = "") => { const b = html("button", { type: "button", class: `plain-button ${look}` }, words); b.onclick = act; return b; };
const shown = (id) => view.doc.demonstrations[id];
const pictured = (id, ...more) => { const d = shown(id); return figure(view.doc.scenes[d.scene_id], d, ...more); };

function say(words, wrong = false) {
  const line = root.querySelector(".rv-said");
  line.textContent = words;
  line.classList.toggle("wrong", wrong);
}

async function load() {
  const query = new URLSearchParams({ scene_id: asked.get("scene") ?? "", type: asked.get("type") ?? "", audit: view.audit, wait: false });
  view.doc = await ask("GET", `check?${query}`);
  if (view.doc.learning) setTimeout(() => load().catch((error) => say(error.message, true)), 1000);
  steps(document, view.doc.steps, asked.get("scene"), asked.get("type"));
  paint();
}

async function act(path, body, words) {
  try { await ask("POST", path, body); await load(); say(words); people(); } catch (error) { say(error.message, true); }
}
const judge = (id, valid) => act("change", { demo_ids: [id], valid }, `${shown(id)?.name ?? id} is ${WORDS[valid]}.`);

// One at a time, with how many there are and the way to the others.
function oneOf(kind, all, draw) {
  const box = root.querySelector(`.rv-${kind} .rv-body`);
  const at = view.at[kind] = Math.min(view.at[kind], Math.max(all.length - 1, 0));
  if (!all.length) return null;
  const go = (by) => () => { view.at[kind] = (at + by + all.length) % all.length; paint(); };
  const which = html("div", { class: "rv-which" }, html("span", {}, `${at + 1} of ${all.length}`));
  if (all.length > 1) which.append(button("← Previous", go(-1), "small"), button("Next →", go(1), "small"));
  box.replaceChildren(which, ...draw(all[at]));
  return all[at];
}

function paint() {
  const { doc } = view;
  const empty = (kind, words) => root.querySelector(`.rv-${kind} .rv-body`).replaceChildren(html("p", { class: "soft" }, words));
  if (!oneOf("doubts", doc.doubts, (d) => [
    html("p", { class: "rv-words" }, d.words),
    html("div", { class: "rv-pair" }, ...[...d.accepted, ...d.rejected].slice(0, 6).map((id) => pictured(id, html("a", { href: teachAt(shown(id)) }, "open")))),
    html("div", { class: "rv-do" }, ...d.accepted.map((id) => button(`Reject ${shown(id).name}`, () => judge(id, false))),
      ...(d.rejected.length === 1 ? [button(`Accept ${shown(d.rejected[0]).name}`, () => judge(d.rejected[0], true))] : []),
      button(d.accepted.length + d.rejected.length === 1 ? "It is right" : d.accepted.length + d.rejected.length === 2 ? "Both are right" : "All are right", () => act("keep", { demo_ids: d.rejected.length ? d.rejected : d.accepted }, "Kept: it will not be asked again."))),
  ])) empty("doubts", doc.learning ? "Learning from the labels…" : "No contradiction is open.");
  if (!oneOf("unsaid", doc.unsaid.filter((id) => shown(id)), (id) => [
    html("div", { class: "rv-one" }, pictured(id)),
    html("div", { class: "rv-do" }, button("Accept", () => judge(id, true), "accept"), button("Reject", () => judge(id, false), "reject"), html("a", { href: teachAt(shown(id)) }, "open in Teach")),
  ])) empty("unsaid", "Every path is accepted or rejected.");
  if (!doc.audited) {
    root.querySelector(".rv-wrong .rv-body").replaceChildren(html("p", { class: "soft" }, "Looks for labels that the others make unlikely, as demospec audit does."),
      button("Look", async () => { view.audit = true; say("Looking…"); try { await load(); say(""); } catch (error) { say(error.message, true); } }));
  } else if (!oneOf("wrong", doc.wrong.filter((w) => shown(w.demo_id)), (w) => [
    html("div", { class: "rv-one" }, pictured(w.demo_id)), html("p", { class: "rv-words" }, `${shown(w.demo_id).name}: ${w.why}`),
    html("div", { class: "rv-do" }, button(`${shown(w.demo_id).valid ? "Reject" : "Accept"} it instead`, () => judge(w.demo_id, !shown(w.demo_id).valid)), html("a", { href: teachAt(shown(w.demo_id)) }, "open in Teach")),
  ])) empty("wrong", "No label looks wrong.");
}

// Everybody side by side.
async function people() {
  const box = root.querySelector(".rv-people .rv-body");
  try {
    const { people: all, learning } = await ask("GET", "people?wait=false");
    if (learning) return setTimeout(people, 1000);
    if (!all.length) return box.replaceChildren(html("p", { class: "soft" }, "Nobody has accepted or rejected a path yet."));
    const marks = { good: "✓", mixed: "!", bad: "✕", unknown: "?" };
    box.replaceChildren(html("div", { class: "rv-table report", tabindex: 0, role: "group", "aria-label": "People, scrolls sideways" }, html("table", {},
      html("thead", {}, html("tr", {}, ...["person", "table", "cares about", "how sure", "next"].map((w) => html("th", { scope: "col" }, w)))),
      html("tbody", {}, ...all.map((p) => {
        const drawn = html("td", { class: "rv-picture" });
        if (p.picture) drawn.innerHTML = p.picture; // the studio's own drawing
        const name = p.name === "me" ? "you" : p.name, next = p.facts.find(([heading]) => heading.startsWith("Show next"));
        return html("tr", {}, html("th", { scope: "row" }, name), drawn, html("td", { class: "rv-sentence" }, p.sentence),
          html("td", {}, html("ul", { class: "lights" }, ...p.lights.map((l) => html("li", { class: `light ${l.state}` }, html("span", { class: "lamp", "aria-hidden": "true" }, marks[l.state]), html("span", {}, html("b", {}, l.name), ` ${l.words}`))))),
          html("td", {}, html("a", { href: `/teach?${new URLSearchParams({ type: p.name })}` }, !next ? "teach" : next[1].startsWith("a path") ? `show ${next[1].replace(/\.$/, "")}` : "show the path that tells most")));
      })))));
  } catch (error) { box.replaceChildren(html("p", { class: "rv-said wrong" }, error.message)); }
}

root.innerHTML = `
  <p class="rv-said" role="status"></p>
  <section class="card rv-doubts"><h2>Contradictions</h2><div class="rv-body" aria-live="polite"></div></section>
  <section class="card rv-unsaid"><h2>Paths without a verdict</h2><div class="rv-body"></div></section>
  <section class="card rv-wrong"><h2>Labels that look wrong</h2><div class="rv-body"></div></section>
  <section class="card rv-people"><h2>People side by side</h2><div class="rv-body"><p class="soft">Learning…</p></div></section>`;
try { await load(); } catch (error) { say(error.message, true); }
prepared();
people();
setInterval(async () => {
  if (!ready()) return;
  try { if ((await ask("GET", "set")).version !== view.doc?.version) { await load(); people(); } } catch { /* the next one may come */ }
}, 3000);
