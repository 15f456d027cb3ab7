// Text over the picture: the painter tells where, the page writes it, sharp at every resolution.

import { placed } from "./placing.js";

const OVER = "#scene > :is(.views, .legend, .rate, #first_minute), #sticks :is(.stick, .hold)"; // may lie over the picture, too

export class Labels {
  constructor(element) {
    this.element = element;
    this.shown = new Map(); // key → its element
    this.resize();
  }

  // Remembers sizes and what is taken: to ask for it between two writes would lay the page out anew each time.
  resize() {
    this.size = { width: this.element.clientWidth, height: this.element.clientHeight };
    const { left: x, top: y } = this.element.getBoundingClientRect();
    this.taken = [...document.querySelectorAll(OVER)].map((part) => {
      const { left, top, right, bottom } = part.getBoundingClientRect();
      return [left - x, top - y, right - x, bottom - y];
    });
  }

  show(labels) {
    const shown = placed(labels.filter(({ ahead }) => ahead), this.size, this.taken);
    const seen = new Set(shown.map(({ key }) => key));
    for (const label of shown) this.#place(label);
    for (const [key, element] of this.shown) if (!seen.has(key)) this.#drop(key, element);
  }

  #place({ key, text, kind, x, y }) {
    const element = this.shown.get(key) ?? this.#make(key);
    if (element.className !== `label ${kind}`) element.className = `label ${kind}`;
    if (element.textContent !== text) element.textContent = text;
    const place = `translate(${x.toFixed(0)}px, ${y.toFixed(0)}px)`;
    if (element.style.transform !== place) element.style.transform = place;
  }

  #make(key) {
    const element = document.createElement("div");
    this.shown.set(key, element);
    this.element.append(element);
    return element;
  }

  #drop(key, element) {
    element.remove();
    this.shown.delete(key);
  }
}
