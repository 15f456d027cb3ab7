// Text over the picture: the painter tells where, the page writes it, sharp at every resolution.

export class Labels {
  constructor(element) {
    this.element = element;
    this.shown = new Map(); // key → its element
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
    element.className = `label ${kind}`;
    if (element.textContent !== text) element.textContent = text;
    const [right, bottom] = [this.element.clientWidth - 40, this.element.clientHeight - 20];
    const inside = [Math.min(right, Math.max(40, x)), Math.min(bottom, Math.max(20, y))];
    element.style.transform = `translate(${inside[0].toFixed(1)}px, ${inside[1].toFixed(1)}px)`;
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
