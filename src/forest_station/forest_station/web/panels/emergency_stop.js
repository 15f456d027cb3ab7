// The emergency stop: always in sight, for everybody who has the page open.

import { make, makeButton, setText } from "../elements.js";
import { isTyping } from "../hands/keyboard.js";
import { STOP_KEYS } from "../hands/keys.js";

export const place = "top";
export const title = "";

export function mount(element, station) {
  const view = {
    stop: makeButton("EMERGENCY STOP", ({ detail }) => detail === 0 && stop(), "stop"), // a pointer has acted already
    reset: Object.assign(makeButton("Reset", () => reset(station, view)), { hidden: true }),
    state: make("p", { role: "status" }),
    sources: make("ul", { className: "sources" }),
  };
  view.stop.setAttribute("aria-keyshortcuts", STOP_KEYS.join(" "));
  view.stop.title = "Esc, or the space bar";
  element.append(view.stop, make("div", { className: "state" }, view.state, view.sources, view.reset));
  let wanted = false; // until a server has confirmed it

  async function stop() {
    wanted = true;
    const { ok, text } = await station.ask("emergency_stop");
    if (ok) wanted = false;
    else setText(view.state, `Emergency stop not confirmed: ${text}`);
  }

  view.stop.addEventListener("pointerdown", stop); // its click comes only with the release
  listenToKeys(stop);
  station.on("open", () => wanted && stop());
  station.on("emergency_stop", (message) => show(element, view, message));
  station.on("seat", ({ you_drive: drives }) => (view.reset.disabled = !drives));
}

function show(element, view, { active, sources }) {
  element.classList.toggle("active", active);
  setText(view.state, active ? "STOPPED: nothing moves until it is reset." : "");
  view.sources.replaceChildren(
    ...(active ? sources : []).map(({ name, state }) => make("li", { className: state }, `${name}: ${state}`)),
  );
  view.reset.hidden = !active;
}

async function reset(station, view) {
  const { ok, text } = await station.ask("reset_emergency_stop");
  if (!ok) setText(view.state, text);
}

// Before any other element hears them: a focused button takes the space bar for a click.
function listenToKeys(stop) {
  const act = (event) => {
    if (!STOP_KEYS.includes(event.code) || (event.code === "Space" && isTyping(event))) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (event.type === "keydown" && !event.repeat) stop();
  };
  window.addEventListener("keydown", act, true);
  window.addEventListener("keyup", act, true);
}
