// The pressed keys, ramped; the deadman's key.

import { CENTRED } from "./joy.js";
import { DEADMAN_KEY, FASTER_KEY, KEYS, OTHER_SHIFT, SLOWER_KEY, nextSpeed, rampedAxes, wantedAxes } from "./keys.js";

const WRITES = "input:not([type=button], [type=checkbox], [type=radio], [type=range]), textarea, select, [contenteditable]";

// Whether a key goes into a text, and so is no command.
export const isTyping = (event) => Boolean(event.target.closest?.(WRITES));

export class Keyboard {
  #pressed = new Set();
  #axes = CENTRED;
  speed = 1; // of `SPEEDS`

  constructor(changed) {
    window.addEventListener("keydown", (event) => this.#down(event, changed));
    window.addEventListener("keyup", (event) => this.#up(event, changed));
  }

  get holdsDeadman() {
    return this.#pressed.has(DEADMAN_KEY);
  }

  // Forgets what is pressed: the keys' releases may have gone elsewhere.
  clear() {
    this.#pressed.clear();
  }

  // The deflections `dt` seconds later.
  step(dt) {
    this.#axes = rampedAxes(this.#axes, wantedAxes(this.#pressed, this.speed), dt);
    return this.#axes;
  }

  #down(event, changed) {
    if (event.code === OTHER_SHIFT) this.#pressed.delete(DEADMAN_KEY); // Windows hides the release of one of two
    const { code, repeat, ctrlKey, altKey, metaKey } = event;
    const sets = code === SLOWER_KEY || code === FASTER_KEY;
    if (isTyping(event) || ctrlKey || altKey || metaKey || !(KEYS[code] || code === DEADMAN_KEY || sets)) return;
    event.preventDefault(); // arrows would scroll
    if (repeat) return;
    if (sets) this.speed = nextSpeed(this.speed, code);
    else this.#pressed.add(code);
    changed();
  }

  #up(event, changed) {
    const shiftIsUp = !event.shiftKey && this.#pressed.delete(DEADMAN_KEY); // its own release may have been lost
    if (this.#pressed.delete(event.code) || shiftIsUp) changed();
  }
}
