// The first minute: a square to drive along, and what to do next, in one sentence at a time.

import { make, makeButton, setText } from "../elements.js";
import { SIDE, after, begun, isDone, result, side, squareAt, way } from "../exercise/square.js";
import { handsOf } from "../hands/hands.js";

export const place = "left";
export const title = "First minute";

const TIP = ["tip/pose/x", "tip/pose/y", "tip/pose/z"];

export function mount(element, station) {
  keepInSight(element.parentElement);
  new FirstMinute(element, station, handsOf(station));
}

class FirstMinute {
  constructor(element, station, hands) {
    this.station = station;
    this.hands = hands;
    this.attempt = null;
    this.seat = { driver: null, you_drive: false, deadman: { state: "waiting" } };
    this.stopped = false;
    this.text = make("p", { role: "status" });
    this.button = makeButton("Mark a square", () => (this.attempt && !isDone(this.attempt) ? this.#end() : this.#begin()));
    element.append(this.text, this.button);
    station.on("seat", (seat) => {
      this.seat = seat;
      this.#show();
    });
    station.on("emergency_stop", ({ active }) => {
      this.stopped = active;
      this.#show();
    });
    station.on("frame", ({ time }) => this.#follow(time));
    hands.addEventListener("change", () => this.#show());
    this.#show();
  }

  #tip() {
    return TIP.map((name) => this.station.value(name));
  }

  #begin() {
    const tip = this.#tip();
    if (!tip.every(Number.isFinite)) return setText(this.text, "Nobody tells where the tip is: is the crane running?");
    this.attempt = begun(squareAt(tip));
    this.#draw();
  }

  #end() {
    this.attempt = null;
    this.#draw();
  }

  #follow(time) {
    if (!this.attempt || isDone(this.attempt)) return;
    const before = this.attempt.side;
    this.attempt = after(this.attempt, this.#tip(), time);
    if (this.attempt.side !== before) this.#draw();
    else this.#show();
  }

  #draw() {
    const shown = this.attempt && { corners: this.attempt.corners, side: side(this.attempt), size: SIDE };
    this.station.emit("exercise", shown && !isDone(this.attempt) ? shown : null);
    this.#show();
  }

  #show() {
    const done = this.attempt && isDone(this.attempt);
    setText(this.button, done ? "Mark another square" : this.attempt ? "Take the square away" : "Mark a square");
    setText(this.text, this.#sentence());
  }

  #sentence() {
    if (this.stopped) return "Stopped: press Reset, at the top.";
    if (!this.attempt) {
      return "Mark a square at the tip of the crane, and drive along it with the left stick. The space bar stops everything.";
    }
    if (isDone(this.attempt)) {
      const { rms, most, seconds } = result(this.attempt);
      return `Done in ${seconds.toFixed(0)} s: ${cm(rms)} beside the square on average, ${cm(most)} at most.`;
    }
    if (!this.seat.you_drive) {
      return this.seat.driver === null ? "Nobody drives: take the seat, at the top." : "Somebody else drives: ask for control, at the top.";
    }
    return this.#instruction();
  }

  #instruction() {
    const number = `Side ${this.attempt.side + 1} of 4`;
    if (!this.hands.deadman.held || this.seat.deadman.state === "waiting") {
      if (this.attempt.since === null) return "With the sticks at rest, hold the left Shift key, or HOLD TO DRIVE with a finger.";
      return `${number} waits: let go of everything, then hold the left Shift key again.`;
    }
    const [word, key, metres] = way(this.attempt, this.#tip());
    return `${number}: keep Shift held, and push the left stick ${word}, or press ${key}: ${metres.toFixed(1)} m to go.`;
  }
}

// On a narrow screen the drawer hides the crane: what is read while driving lies over the scene there.
function keepInSight(section) {
  const [scene, home] = [document.getElementById("scene"), section.parentElement];
  const narrow = matchMedia("(width < 60rem)");
  const put = () => (narrow.matches ? scene : home).append(section);
  narrow.addEventListener("change", put);
  put();
}

function cm(metres) {
  return `${(100 * metres).toFixed(1)} cm`;
}
