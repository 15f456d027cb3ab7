// The newest value of every signal, as the painter knows them.

export class Signals {
  constructor(names = []) {
    this.columns = new Map(names.map((name, column) => [name, column]));
    this.values = new Float32Array(0);
    this.time = NaN;
  }

  show(time, values) {
    this.time = time;
    this.values = values;
  }

  // The newest value [SI]; NaN if it is unknown.
  value(name) {
    return this.values[this.columns.get(name)] ?? NaN;
  }

  // The first of several signals that is known; NaN if none is.
  first(...names) {
    for (const name of names) {
      const value = this.value(name);
      if (Number.isFinite(value)) return value;
    }
    return NaN;
  }

  // x, y, z of a topic with these labels; null if one is unknown.
  point(topic) {
    const xyz = ["x", "y", "z"].map((label) => this.value(`${topic}/${label}`));
    return xyz.every(Number.isFinite) ? xyz : null;
  }
}
