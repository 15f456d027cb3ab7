// Takes work off a page that is about to be late, before its deadman has to go: the charts first, then pictures.

import { messageLineOf } from "./message_line.js";

export const [EVERYTHING, NO_CHARTS, FEW_PICTURES, FEWEST_PICTURES] = [0, 1, 2, 3];

const LATE_MS = 50; // between two looks at the hands, which come every 20 ms; after 100 ms the deadman goes
const [OFTEN, WITHIN_MS] = [2, 2000]; // late looks within, that are no accident
const SHOWS_MS = 1000; // until what was taken off has shown its worth
const [CALM_MS, LONGEST_CALM_MS] = [8000, 120_000]; // without a late look, before something comes back
const TOLD_MS = 8000; // for which a change is to be read
const TEXTS = [
  "",
  "This computer is busy: the charts rest until it has time.",
  "This computer is busy: charts rest, and the picture is coarser.",
  "This computer is busy: charts rest, and the picture is coarse and slow.",
];

export class Relief {
  level = EVERYTHING;
  #late = []; // when looks were late [ms]
  #changed = -Infinity;
  #calm = CALM_MS; // longer after each return that was too early
  #returned = false; // the last change gave something back

  // Hears how long [ms] the page did not look at its hands, at `now` [ms]; tells whether the level has changed.
  look(gap, now) {
    const before = this.level;
    if (gap > LATE_MS) this.#late = [...this.#late.filter((time) => now - time < WITHIN_MS), now];
    const last = this.#late.at(-1) ?? -Infinity;
    if (gap > LATE_MS && this.#late.length >= OFTEN && now - this.#changed > SHOWS_MS) this.#takeOff(now);
    else if (this.level > EVERYTHING && now - Math.max(last, this.#changed) > this.#calm) this.#giveBack(now);
    return this.level !== before;
  }

  #takeOff(now) {
    if (this.level === FEWEST_PICTURES) return;
    if (this.#returned && now - this.#changed < this.#calm) this.#calm = Math.min(LONGEST_CALM_MS, 2 * this.#calm);
    this.#set(this.level + 1, now, false);
  }

  #giveBack(now) {
    this.#set(this.level - 1, now, true);
    if (this.level === EVERYTHING) this.#late = [];
  }

  #set(level, now, returned) {
    this.level = level;
    this.#changed = now;
    this.#returned = returned;
  }
}

// Watches over the hands of a page, and emits "relief" of its station with the level when that changes.
export function relieve(station, hands) {
  const relief = new Relief();
  const line = messageLineOf(station);
  let told;
  hands.addEventListener("look", ({ detail: gap }) => {
    if (document.hidden || !hands.drives) return; // who does not drive may be late
    if (!relief.look(gap, performance.now())) return;
    document.body.dataset.relief = relief.level;
    line.say("load", TEXTS[relief.level], "calm");
    clearTimeout(told);
    told = setTimeout(() => line.say("load", ""), TOLD_MS); // the dimmed charts go on telling
    station.emit("relief", relief.level);
  });
}
