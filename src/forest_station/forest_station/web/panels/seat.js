// Who drives, whether the deadman is held, and why nothing moves. Who looks on asks for control; the driver hands over.

import { make, makeButton, setText } from "../elements.js";
import { handsOf } from "../hands/hands.js";
import { deadmanState, driverText, isStanding, lostText, standingCause, whyText } from "../hands/why.js";
import { momentOf } from "../replay/link.js";
import { messageLineOf } from "../message_line.js";
import { axisAtLimit } from "../scene/axes.js";

export const place = "top";
export const title = "";

const PERIOD_MS = 200; // the controller's status comes with the frames
const ANSWER_MS = 4000; // for which an answer is to be read

export function mount(element, station) {
  const view = {
    driver: make("strong", { className: "driver" }),
    deadman: make("span", { className: "deadman" }),
    buttons: make("span", { className: "buttons" }),
  };
  view.driver.setAttribute("role", "status");
  element.append(view.driver, view.deadman, view.buttons);
  const seat = new Seat(station, handsOf(station), view);
  setInterval(() => seat.paint(), PERIOD_MS);
  seat.paint();
}

class Seat {
  constructor(station, hands, view) {
    this.line = messageLineOf(station);
    Object.assign(this, { station, hands, view, you: null, seat: null, stopped: false, isNew: true, parts: [], logged: null, lost: "" });
    const hear = (kind, act) =>
      station.on(kind, (detail) => {
        act(detail);
        this.paint();
      });
    hear("welcome", ({ you }) => (this.you = you));
    hear("seat", (seat) => this.#hear(seat));
    hear("emergency_stop", ({ active }) => (this.stopped = active));
    hear("diagnostics", ({ parts }) => (this.parts = parts));
    hear("log", ({ text }) => isStanding(text) && (this.logged = { text, at: performance.now() }));
    hear("close", (reason) => {
      if (this.seat || reason) this.lost = lostText(reason);
      this.seat = null;
    });
    hands.addEventListener("change", () => this.paint());
  }

  paint() {
    const { seat, view } = this;
    const { held, doubted, why } = this.hands.deadman;
    const { deflected, grip, lateness } = this.hands;
    const deadman = deadmanState(seat, { held, doubted });
    setText(view.driver, driverText(seat));
    view.driver.dataset.drives = Boolean(seat?.you_drive);
    setText(view.deadman, deadman.text);
    view.deadman.dataset.state = deadman.state;
    const now = performance.now();
    const cause = standingCause(this.parts, this.logged, now);
    const here = { held, doubted, why, deflected, grip, often: lateness.isOften(now), you: this.you, lost: this.lost };
    const said = whyText(seat, here, this.stopped, this.#status(), cause);
    const isHint = said.startsWith("Hold "); // nothing is in the way
    this.line.say("drive", isHint ? "" : said);
    this.line.say("hint", isHint ? said : "", "calm");
    this.#offer(seat ? this.#choices(seat) : []);
  }

  #hear(seat) {
    if (this.seat?.driver !== seat.driver) this.line.say("answer", "");
    this.seat = seat;
    const looks = momentOf(location.hash) !== null; // who opens a moment of a bag wants to look
    if (this.isNew && seat.driver === null && !looks) this.#ask("take_seat"); // who opens the page wants to drive
    this.isNew = false;
  }

  #status() {
    const value = (label) => this.station.value(`controller/status/${label}`);
    const joints = this.station.scene?.joints;
    const axis = joints ? axisAtLimit(joints, (name) => this.station.value(name)) : "";
    return { armed: value("armed"), factor: value("factor"), limit: value("limit"), axis };
  }

  // What this page can do about the seat.
  #choices(seat) {
    if (seat.you_drive) {
      const heirs = seat.asking.map((to) => ({ text: `Hand over to ${to}`, what: "leave_seat", args: { to }, urgent: true }));
      return [...heirs, { text: "Leave the seat", what: "leave_seat" }];
    }
    if (seat.asking.includes(this.you)) return [];
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
