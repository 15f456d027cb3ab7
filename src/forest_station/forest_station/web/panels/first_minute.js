// The first minute: a square to drive along, and what to do next, in one sentence at a time.

import { make, makeButton, setText } from "../elements.js";
import { SIDE, after, begun, isDone, result, side, squareAt, way } from "../exercise/square.js";
import { resultText, wayText } from "../exercise/words.js";
import { handsOf } from "../hands/hands.js";
import { deadmanOrder, deadmanState } from "../hands/why.js";

export const place = "left";
export const title = "First minute";

const FINGERS = matchMedia("(pointer: coarse)").matches;
const STOP = FINGERS ? "The red button" : "The space bar";
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
    this.best = NaN; // least mean distance of the attempts before this one [m]
    this.seat = { driver: null, you_drive: false, deadman: { state: "waiting", cause: "" } };
    this.stopped = false;
    this.text = make("p", { role: "status" });
    this.begins = makeButton("Mark a square", () => this.#begin());
    this.ends = makeButton("Take the square away", () => this.#end());
    element.append(this.text, this.begins, this.ends);
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
    station.on("replay", () => this.#end()); // it is the live crane's
    for (const kind of ["open", "close"]) station.on(kind, () => this.#show());
    this.#show();
  }

  #tip() {
    return TIP.map((name) => this.station.value(name));
  }

  #begin() {
    const tip = this.#tip();
    if (!tip.every(Number.isFinite)) return setText(this.text, "Nobody tells where the tip is: is the crane running?");
    if (this.attempt && isDone(this.attempt)) this.best = Math.min(this.best || Infinity, result(this.attempt).mean);
    this.#end(); // a square that is done may still be there
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

  // A square that is done stays, for its driver to see where the tip went.
  #draw() {
    const { attempt } = this;
    const next = attempt && !isDone(attempt) ? side(attempt) : null;
    this.station.emit("exercise", attempt && { corners: attempt.corners, side: next, size: SIDE });
    this.#show();
  }

  #show() {
    const done = this.attempt && isDone(this.attempt);
    setText(this.begins, done ? "Mark another square" : "Mark a square");
    this.begins.hidden = Boolean(this.attempt) && !done;
    this.ends.hidden = !this.attempt;
    setText(this.text, this.#sentence());
  }

  #sentence() {
    if (!this.station.connected) return "Without a connection nothing can be driven.";
    if (this.stopped) return "Stopped: Reset, at the top, ends that.";
    if (!this.attempt) {
      return `Mark a square at the crane's tip, and drive along it. ${STOP} stops everything.`;
    }
    if (isDone(this.attempt)) {
      return resultText(result(this.attempt), this.best);
    }
    if (!this.seat.you_drive) {
      return this.seat.driver === null ? "Nobody drives: take the seat, at the top." : "Somebody else drives: ask for control, at the top.";
    }
    return this.#instruction();
  }

  #instruction() {
    const number = `Edge ${this.attempt.side + 1} of 4`;
    const { deadman, deflected, grip } = this.hands;
    const here = { held: deadman.held, doubted: deadman.doubted, deflected, grip };
    if (deadmanState(this.seat, here).state !== "held") return `${number} waits. ${deadmanOrder(this.seat, here)}`.trim();
    return `${number}: ${wayText(way(this.attempt, this.#tip()), FINGERS)}`;
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
