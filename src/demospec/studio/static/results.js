// Results: downloads stay on the page, and the report comes once it is written.
import { prepared } from "./connection.js";
import { html, steps, waitFor } from "./parts.js";

const take = await waitFor("#take");
let choices = JSON.parse(take.dataset.choices);
const field = (name) => take.querySelector(`[name=${name}]`);
const said = take.querySelector(".re-said");
const planned = ["nav2", "moveit", "mcap"];

// Why a form cannot be had with what is chosen, or nothing.
function missing(form) {
  if (choices.missing[form]) return choices.missing[form];
  if (!planned.includes(form)) return "";
  return choices.missing_in[field("scene").value] ?? choices.missing_for[field("rules").value]?.[field("type").value] ?? "";
}

function show() {
  const reasons = new Map();
  for (const button of take.querySelectorAll("[data-form]")) {
    const why = missing(button.dataset.form);
    button.disabled = Boolean(why);
    button.title = why;
    if (why) reasons.set(why, [...(reasons.get(why) ?? []), button.textContent]);
  }
  look();
  take.querySelector("#take-why").replaceChildren(...[...reasons].map(([why, names]) => {
    return html("span", {}, `${names.join(", ")}: ${why}`);
  }));
}

// The ticks, for the scene and the person that are chosen.
async function look() {
  const query = new URLSearchParams({ scene_id: field("scene").value, type: field("type").value });
  const answer = await fetch(`/api/steps?${query}`);
  if (answer.ok) steps(document, (await answer.json()).steps, field("scene").value, field("type").value);
}

async function download(form) {
  const asked = new URLSearchParams({ form, of: take.dataset.of });
  for (const name of ["rules", "scene", "type"]) asked.set(name, field(name).value);
  said.textContent = "Making the file…";
  said.classList.remove("wrong");
  try {
    const answer = await fetch(`/results/download?${asked}`);
    if (!answer.ok) throw new Error(await answer.text());
    const name = /filename="([^"]+)"/.exec(answer.headers.get("content-disposition"))?.[1] ?? form;
    const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(await answer.blob()), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
    said.textContent = `${name} was downloaded.`;
  } catch (error) {
    said.textContent = `Nothing was downloaded. ${error.message}`;
    said.classList.add("wrong");
  }
}

// Types that the chosen rules know.
function types() {
  const known = choices.rules[field("rules").value] ?? [], before = field("type").value;
  field("type").replaceChildren(...known.map((t) => new Option(t, t, t === before, t === before)));
}

take.addEventListener("click", (e) => {
  const form = e.target.closest("[data-form]")?.dataset.form;
  if (form) download(form);
});
take.addEventListener("change", () => { types(); show(); });
// A link may say which scene and person.
const linked = new URLSearchParams(location.search);
if ([...field("scene").options].some((o) => o.value === linked.get("scene"))) field("scene").value = linked.get("scene");
function offer() {
  types();
  if ([...field("type").options].some((o) => o.value === linked.get("type"))) field("type").value = linked.get("type");
  show();
}
offer();
prepared();
// Rules are still being learned: the rest comes when they are.
if ("learning" in take.dataset) fetch("/results/choices").then(async (answer) => {
  choices = await answer.json();
  field("rules").replaceChildren(...Object.keys(choices.rules).map((n) => new Option(n)));
  delete take.dataset.learning;
  offer();
}).catch((error) => { said.textContent = error.message; });

const place = document.querySelector("#report");
if (place) {
  try {
    const answer = await fetch(`/results/report?of=${encodeURIComponent(place.dataset.of)}`);
    const text = await answer.text();
    if (!answer.ok) throw new Error(text);
    place.innerHTML = text; // the studio's own markup: whatever came from files is escaped in it
  } catch (error) {
    place.replaceChildren(html("p", { class: "re-said wrong" }, `The report cannot be shown. ${error.message}`));
  }
  place.ariaBusy = "false";
}
