// Whether this tab and the studio hear each other. Until they do, and while they do not, the
// page's main part is inert: what a person did there would come late, or never.
const main = () => document.querySelector(".studio-main");
const body = document.body.dataset;
let linked = false, isPrepared = false, focused = null;
body.ready = "no";

const pause = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));

/** Whether the person may act; keys that are heard on the whole page must ask. */
export const ready = () => body.ready === "yes";

/** Said by a page's own script when it has begun to listen. */
export function prepared() { isPrepared = true; show(); }

/** Settles once the studio has heard of this tab: before, it drops what the tab sends. */
export async function handshake() { while (!window.did_handshake || !window.socket?.connected) await pause(20); }

function show() {
  const now = linked && isPrepared;
  if (now === ready()) return;
  // An inert element loses the focus; a person who was typing goes on where they were.
  if (!now) focused = main().contains(document.activeElement) ? document.activeElement : null;
  main().inert = !now;
  body.ready = now ? "yes" : "no";
  if (now && document.activeElement === document.body) focused?.focus({ preventScroll: true });
}

async function watch() {
  await handshake();
  // A tab that comes back to a studio that does not know it any more is loaded anew.
  window.socket.on("disconnect", () => { linked = false; show(); });
  window.socket.on("connect", () => { linked = true; show(); });
  linked = window.socket.connected;
  if (!main().hasAttribute("data-prepares")) isPrepared = true;
  show();
}
watch();
