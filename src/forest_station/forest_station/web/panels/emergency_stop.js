// The emergency stop: always in sight, for everybody who has the page open.

import { make, makeButton, setText } from "../elements.js";
import { handsOf } from "../hands/hands.js";
import { isTyping } from "../hands/keyboard.js";
import { STOP_KEYS } from "../hands/keys.js";

export const place = "top";
export const title = "";

export function mount(element, station) {
  new EmergencyStop(element, station, handsOf(station));
}

class EmergencyStop {
  constructor(element, station, hands) {
    Object.assign(this, { element, station, hands });
    this.wanted = false; // until a server has confirmed it
    this.told = { active: false, sources: [] };
    this.note = ""; // what became of a request, until the next news
    this.button = makeButton("EMERGENCY STOP", ({ detail }) => detail === 0 && this.stop(), "stop");
    this.button.addEventListener("pointerdown", () => this.stop()); // its click comes only with the release
    this.button.setAttribute("aria-keyshortcuts", STOP_KEYS.join(" "));
    this.button.append(make("small", {}, make("kbd", {}, "Esc"), make("kbd", {}, "space")));
    this.state = make("p", { role: "status" });
    this.sources = make("ul");
    this.resetButton = makeButton("Reset", () => this.reset());
    element.append(this.button, make("div", { className: "state" }, this.state, this.sources, this.resetButton));
    listenToKeys(() => this.stop());
    station.on("open", () => {
      this.#show();
      if (this.wanted) this.stop();
    });
    station.on("close", () => {
      this.resetButton.disabled = true;
      this.#show();
    });
    station.on("emergency_stop", (message) => this.#hear(message));
    station.on("seat", ({ you_drive: drives }) => {
      this.resetButton.disabled = !drives;
      setText(this.resetButton, drives ? "Reset" : "Reset: take the seat");
    });
    this.#show();
  }

  async stop() {
    this.wanted = true;
    this.hands.release("the emergency stop was pressed");
    this.#tell("Emergency stop sent, not yet confirmed.");
    const { ok, text } = await this.station.ask("emergency_stop");
    if (ok) this.wanted = false;
    this.#tell(ok ? "" : `Emergency stop not confirmed: ${text}`);
  }

  async reset() {
    const { held, doubted } = this.hands.deadman;
    if (held || doubted) return this.#tell("Not reset: let go of the deadman first.");
    const { ok, text } = await this.station.ask("reset_emergency_stop");
    this.#tell(ok ? "" : text);
  }

  #hear(told) {
    this.told = told;
    if (!this.wanted) this.note = "";
    this.#show();
  }

  #tell(note) {
    this.note = note;
    this.#show();
  }

  #show() {
    const { active, sources } = this.told;
    this.element.classList.toggle("active", active);
    const link = this.station.connected ? "" : "Not connected: a stop is sent once there is a connection.";
    setText(this.state, this.note || link || (active ? "STOPPED: nothing moves until it is reset." : ""));
    this.sources.replaceChildren(
      ...(active ? sources : []).map(({ name, state }) => make("li", { className: state }, `${name}: ${state}`)),
    );
    this.resetButton.hidden = !active;
  }
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
