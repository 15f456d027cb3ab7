// The first minute: a square to drive along, and what to do next, in one sentence at a time.

import { make, makeButton, setText } from "../elements.js";
import { after, begun, isDone, result, side, squareAt, way } from "../exercise/square.js";
import { handsOf } from "../hands/hands.js";

export const place = "left";
export const title = "First minute";

const TIP = ["tip/pose/x", "tip/pose/y", "tip/pose/z"];

export function mount(element, station) {
  new FirstMinute(element, station, handsOf(station));
}

class FirstMinute {
  constructor(element, station, hands) {
    this.station = station;
    this.hands = hands;
    this.attempt = null;
    this.drives = false;
    this.text = make("p", { role: "status" });
    this.button = makeButton("Mark a square", () => (this.attempt ? this.#end() : this.#begin()));
    element.append(this.text, this.button);
    station.on("seat", ({ you_drive: drives }) => {
      this.drives = drives;
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
  }

  #draw() {
    const shown = this.attempt && { corners: this.attempt.corners, side: side(this.attempt) };
    this.station.emit("exercise", shown && !isDone(this.attempt) ? shown : null);
    this.#show();
  }

  #show() {
    setText(this.button, this.attempt ? "Take the square away" : "Mark a square");
    setText(this.text, this.#sentence());
  }

  #sentence() {
    if (!this.attempt) return "Mark a square at the tip of the crane, and drive along it with the left stick.";
    if (isDone(this.attempt)) {
      const { rms, most, seconds } = result(this.attempt);
      return `Done in ${seconds.toFixed(0)} s: ${cm(rms)} beside the square on average, ${cm(most)} at most.`;
    }
    if (!this.drives) return "Somebody else drives: ask for control, at the top.";
    if (!this.hands.deadman.held) return "With the sticks at rest, hold the left Shift key, or HOLD TO DRIVE with a finger.";
    const [word, key] = way(this.attempt);
    return `Side ${this.attempt.side + 1} of 4: keep holding, and push the left stick ${word}, or press ${key}.`;
  }
}

function cm(metres) {
  return `${(100 * metres).toFixed(1)} cm`;
}
