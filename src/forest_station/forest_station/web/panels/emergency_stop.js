// The emergency stop: always in sight, for everybody who has the page open.

import { make, makeButton } from "../elements.js";
import { handsOf } from "../hands/hands.js";
import { isTyping } from "../hands/keyboard.js";
import { STOP_KEYS } from "../hands/keys.js";
import { messageLineOf } from "../message_line.js";

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
    this.drives = false;
    this.button = makeButton("EMERGENCY STOP", ({ detail }) => detail === 0 && this.stop(), "stop");
    this.button.addEventListener("pointerdown", () => this.stop()); // its click comes only with the release
    this.button.setAttribute("aria-keyshortcuts", STOP_KEYS.join(" "));
    this.button.append(make("small", {}, make("kbd", {}, "Esc"), make("kbd", {}, "space")));
    this.line = messageLineOf(station);
    this.resetButton = makeButton("Reset", () => this.reset(), "reset");
    element.append(this.button, this.resetButton);
    listenToKeys(() => this.stop());
    station.on("open", () => this.wanted && this.stop());
    station.on("close", () => (this.resetButton.disabled = true));
    station.on("emergency_stop", (message) => this.#hear(message));
    station.on("seat", ({ you_drive: drives }) => {
      this.resetButton.disabled = !drives;
      this.drives = drives;
      this.#show();
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
    this.#tell(ok ? "" : `Not reset: ${text}`);
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
    const parts = sources.map(({ name, state }) => `${name}: ${state}`).join(", ");
    const rest = `Nothing moves until it is reset${this.drives ? "" : " by who drives"}. ${parts}`;
    this.line.say("stop", active ? `STOPPED. ${this.note || rest}` : this.note, "bad");
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
