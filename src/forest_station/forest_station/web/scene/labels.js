// Text over the picture: the painter tells where, the page writes it, sharp at every resolution.

const EDGE = 24; // [px] that a label's middle keeps from top and bottom
const [LETTER, ENDS] = [4.5, 12]; // [px] half a letter, half of what is around them: nobody measures a label

export class Labels {
  constructor(element) {
    this.element = element;
    this.shown = new Map(); // key → its element
    this.resize();
  }

  // Remembers the size: to ask for it between two writes would lay the page out anew each time.
  resize() {
    this.width = this.element.clientWidth;
    this.height = this.element.clientHeight;
  }

  show(labels) {
    const seen = new Set();
    for (const label of labels) {
      if (!label.ahead) continue;
      seen.add(label.key);
      this.#place(label);
    }
    for (const [key, element] of this.shown) if (!seen.has(key)) this.#drop(key, element);
  }

  #place({ key, text, kind, x, y }) {
    const element = this.shown.get(key) ?? this.#make(key);
    if (element.className !== `label ${kind}`) element.className = `label ${kind}`;
    if (element.textContent !== text) element.textContent = text;
    const half = LETTER * text.length + ENDS;
    const across = Math.min(this.width - half, Math.max(half, x));
    const down = Math.min(this.height - EDGE, Math.max(EDGE, y));
    element.style.transform = `translate(${across.toFixed(0)}px, ${down.toFixed(0)}px)`;
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
