// Text over the picture: the painter tells where, the page writes it, sharp at every resolution.

const EDGE = [48, 24]; // [px] that a label's middle keeps from the sides, from top and bottom

export class Labels {
  constructor(element) {
    this.element = element;
    this.shown = new Map(); // key → its element
    this.resize();
  }

  // Remembers the size: to ask for it between two writes would lay the page out anew each time.
  resize() {
    this.right = this.element.clientWidth - EDGE[0];
    this.bottom = this.element.clientHeight - EDGE[1];
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
    const inside = [Math.min(this.right, Math.max(EDGE[0], x)), Math.min(this.bottom, Math.max(EDGE[1], y))];
    element.style.transform = `translate(${inside[0].toFixed(0)}px, ${inside[1].toFixed(0)}px)`;
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
