// The emergency stop: always in sight, for everybody who has the page open.

import { make, makeButton } from "../elements.js";
import { adviceOf } from "../hands/advice.js";
import { handsOf } from "../hands/hands.js";
import { isTyping } from "../hands/keyboard.js";
import { STOP_KEYS } from "../hands/keys.js";
import { refusalText, stopText } from "../hands/stop_words.js";
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
    this.blamed = false; // whether the note blames hands that are not at rest: it ends when they are
    this.drives = false;
    this.advice = adviceOf(station);
    this.button = makeButton("EMERGENCY STOP", ({ detail }) => detail === 0 && this.stop(), "stop");
    this.button.addEventListener("pointerdown", () => this.stop()); // its click comes only with the release
    this.space = make("kbd", {}, "space");
    this.button.append(make("small", {}, make("kbd", {}, "Esc"), this.space));
    for (const kind of ["focusin", "focusout"]) document.addEventListener(kind, ({ relatedTarget, target }) => {
      this.#showKeys(kind === "focusin" ? target : relatedTarget);
    });
    this.#showKeys(null);
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
    this.advice.addEventListener("change", () => this.#lookAtHands());
    this.#show();
  }

  // Where a text is typed the space bar writes: the button crosses it out.
  #showKeys(focused) {
    const writes = focused !== null && isTyping({ target: focused });
    this.space.toggleAttribute("data-off", writes);
    const keys = STOP_KEYS.filter((key) => !(writes && key === "Space"));
    this.button.setAttribute("aria-keyshortcuts", keys.join(" "));
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
    if (held || doubted) return this.#refuse(`let go of ${this.hands.grip} first.`);
    const { ok, text } = await this.station.ask("reset_emergency_stop");
    return ok ? this.#tell("") : this.#refuse(text);
  }

  #refuse(why) {
    this.#tell(refusalText(why), !this.#atRest());
  }

  #atRest() {
    const { held, doubted } = this.hands.deadman;
    return !held && !doubted && !this.hands.deflected;
  }

  #lookAtHands() {
    if (this.blamed && this.#atRest()) this.#tell("");
    else this.#show();
  }

  #hear(told) {
    if (this.told.active && !told.active) this.hands.forget();
    this.told = told;
    if (!this.wanted) this.note = "";
    this.#show();
  }

  #tell(note, blamed = false) {
    Object.assign(this, { note, blamed });
    this.#show();
  }

  #show() {
    const { active } = this.told;
    this.element.classList.toggle("active", active);
    const { note, drives, advice } = this;
    this.line.say("stop", stopText(this.told, { note, drives, order: advice.said.order }), "bad");
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
