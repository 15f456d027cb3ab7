// Whether the charts of a page stand still: all of them, so that they can be compared.

const all = new WeakMap();

// Emits "change".
class Pause extends EventTarget {
  paused = false;

  toggle() {
    this.paused = !this.paused;
    this.dispatchEvent(new Event("change"));
  }
}

export function pauseOf(station) {
  if (!all.has(station)) all.set(station, new Pause());
  return all.get(station);
}
