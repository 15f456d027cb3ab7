// The first minute: a square to drive along, and what to do next, in one sentence at a time.

import { make, makeButton, setText } from "../elements.js";
import { SIDE, after, begun, isDone, result, side, squareAt } from "../exercise/square.js";
import { exerciseText } from "../exercise/words.js";
import { adviceOf } from "../hands/advice.js";
import { handsOf } from "../hands/hands.js";
import { movesTip } from "../hands/moves.js";

export const place = "left";
export const title = "First minute";

const FINGERS = matchMedia("(pointer: coarse)").matches;
const TIP = ["tip/pose/x", "tip/pose/y", "tip/pose/z"];

export function mount(element, station) {
  keepInSight(element.parentElement);
  new FirstMinute(element, station);
}

class FirstMinute {
  constructor(element, station) {
    Object.assign(this, { station, hands: handsOf(station), advice: adviceOf(station) });
    this.attempt = null;
    this.best = NaN; // least mean distance of the attempts before this one [m]
    this.movesTip = true;
    this.text = make("p", { role: "status" });
    this.begins = makeButton("Mark a square", () => this.#begin());
    this.ends = makeButton("Take the square away", () => this.#end());
    element.append(this.text, make("div", { className: "acts" }, this.begins, this.ends));
    station.on("frame", ({ time }) => this.#follow(time));
    station.on("replay", () => this.#end()); // it is the live crane's
    station.on("parameters", ({ nodes: { controller = {} } }) => {
      this.movesTip = movesTip(controller.scheme?.value, controller.axis_frame?.value);
    });
    this.advice.addEventListener("change", () => this.#show());
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
    this.attempt = after(this.attempt, this.#tip(), time, this.hands.deflected);
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
    const { attempt, best, movesTip: moves, advice } = this;
    const { seat, stopped, said } = advice;
    const done = attempt && isDone(attempt);
    setText(this.begins, done ? "Mark another square" : "Mark a square");
    this.begins.hidden = (Boolean(attempt) && !done) || !this.station.live;
    this.ends.hidden = !attempt;
    const tip = this.#tip();
    const replays = !this.station.live;
    setText(this.text, exerciseText({ attempt, tip, best, advice: said, stopped, seat, fingers: FINGERS, movesTip: moves, replays }));
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
