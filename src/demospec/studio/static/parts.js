// What several pages share: elements, and the way with its ticks.
const NS = "http://www.w3.org/2000/svg";

/** An SVG element; strings become text. */
export function node(name, attributes = {}, ...children) {
  const made = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) if (value !== null) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

/** An HTML element; strings become text. */
export function html(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) if (value !== null) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

export async function waitFor(selector) {
  for (;;) {
    const found = document.querySelector(selector);
    if (found) return found;
    await new Promise((done) => setTimeout(done, 30));
  }
}

/** Ticks of the steps, and what is missing, in the page's header. */
export function steps(root, all, scene, type) {
  const place = root.querySelector("#steps");
  if (!place) return;
  const here = place.dataset.active, kept = new URLSearchParams();
  if (scene) kept.set("scene", scene);
  if (type) kept.set("type", type);
  const query = kept.size ? `?${kept}` : "";
  place.replaceChildren(...all.map((s, i) => {
    const link = html("a", { href: `/${s.key}${query}`, class: s.missing ? "step" : "step done", "aria-current": s.key === here ? "step" : null },
      html("span", { class: "step-mark", "aria-hidden": "true" }, s.missing ? String(i + 1) : "✓"), s.name,
      html("span", { class: "out-of-sight" }, s.missing ? `, missing: ${s.missing}` : ", done"));
    if (s.missing) link.title = s.missing;
    return html("li", {}, link);
  }));
  const mine = all.find((s) => s.key === here);
  const next = all.find((s) => s.missing);
  const words = mine?.missing || (next && next !== mine ? `Next, ${next.name}: ${next.missing}` : "");
  root.querySelector("#steps-missing")?.replaceChildren(words);
}
