// Who drives, whether the deadman is held, and why nothing moves. Who looks on asks for control; the driver hands over.

import { make, makeButton, setText } from "../elements.js";
import { adviceOf } from "../hands/advice.js";
import { deadmanState, driverText, isHint } from "../hands/why.js";
import { momentOf } from "../replay/link.js";
import { messageLineOf } from "../message_line.js";

export const place = "top";
export const title = "";

const ANSWER_MS = 4000; // for which an answer is to be read

export function mount(element, station) {
  const view = {
    driver: make("strong", { className: "driver" }),
    deadman: make("span", { className: "deadman" }),
    buttons: make("span", { className: "buttons" }),
  };
  view.driver.setAttribute("role", "status");
  element.append(view.driver, view.deadman, view.buttons);
  new Seat(station, adviceOf(station), view).paint();
}

class Seat {
  constructor(station, advice, view) {
    this.line = messageLineOf(station);
    Object.assign(this, { station, advice, view, driver: undefined, isNew: true });
    station.on("seat", (seat) => this.#hear(seat));
    station.on("close", () => (this.driver = undefined));
    advice.addEventListener("change", () => this.paint());
  }

  paint() {
    const { view, advice } = this;
    const { seat, said } = advice;
    const deadman = deadmanState(seat, advice.here);
    setText(view.driver, driverText(seat));
    view.driver.dataset.drives = Boolean(seat?.you_drive);
    setText(view.deadman, deadman.text);
    view.deadman.dataset.state = deadman.state;
    const hint = isHint(said.text);
    this.line.say("drive", hint ? "" : said.text);
    this.line.say("hint", hint ? said.text : "", "calm");
    this.#offer(seat ? this.#choices(seat) : []);
  }

  #hear(seat) {
    if (this.driver !== seat.driver) this.line.say("answer", "");
    this.driver = seat.driver;
    const looks = momentOf(location.hash) !== null; // who opens a moment of a bag wants to look
    if (this.isNew && seat.driver === null && !looks) this.#ask("take_seat"); // who opens the page wants to drive
    this.isNew = false;
  }

  // What this page can do about the seat.
  #choices(seat) {
    if (seat.you_drive) {
      const heirs = seat.asking.map((to) => ({ text: `Hand over to ${to}`, what: "leave_seat", args: { to }, urgent: true }));
      return [...heirs, { text: "Leave the seat", what: "leave_seat" }];
    }
    if (seat.asking.includes(this.advice.you)) return [];
    return [{ text: seat.driver === null ? "Take the seat" : "Ask for control", what: "take_seat", urgent: true }];
  }

  #offer(choices) {
    const key = JSON.stringify(choices);
    if (this.offered === key) return; // a button that is replaced while it is pressed hears no click
    this.offered = key;
    const button = ({ text, what, args, urgent }) =>
      makeButton(text, () => this.#ask(what, args), urgent ? "urgent" : "");
    this.view.buttons.replaceChildren(...choices.map(button));
  }

  async #ask(what, args) {
    const { text } = await this.station.ask(what, args);
    this.line.say("answer", text);
    setTimeout(() => this.line.say("answer", ""), ANSWER_MS);
  }
}
