// The second bag of a replay, laid over the first and shown later by an offset.

import { RATE } from "./bag.js";

export class Ghost {
  constructor(bag) {
    this.bag = bag;
    this.offset = 0; // [s]
  }

  // Aligns it with another bag by their first messages of a topic, or by their starts: as `forest-bag compare --align`.
  align(other, topic) {
    this.offset = (other.first[topic] ?? 0) - (this.bag.first[topic] ?? 0);
  }

  // Has its frames fetched that are due in `seconds`, from a frame of the other bag on.
  prepare(frame, seconds) {
    this.bag.prepare(this.#own(frame), seconds);
  }

  // What is drawn at a frame of the other bag; null while that is on its way, or where there is none.
  at(frame) {
    const values = this.bag.frame(this.#own(frame));
    return values && { signals: this.bag.signals, values, scene: this.bag.scene };
  }

  // How far its tip is from that of another bag [m]; NaN if one is unknown.
  tipDistance(other, frame) {
    const [own, values] = [this.bag.frame(this.#own(frame)), other.frame(frame)];
    const apart = ["x", "y", "z"].map((axis) => this.bag.value(own, `tip/pose/${axis}`) - other.value(values, `tip/pose/${axis}`));
    return Math.hypot(...apart);
  }

  #own(frame) {
    return frame - Math.round(this.offset * RATE);
  }
}
