// The newest minute of every signal.

const HISTORY_S = 60;
const FRAME_HZ = 30;

// A ring of frames. Its times rise: a frame from before the newest one, as of a replay that goes back, begins anew.
export class History {
  constructor(columns, length = HISTORY_S * FRAME_HZ) {
    this.columns = columns;
    this.length = length;
    this.times = new Float64Array(length).fill(NaN);
    this.rows = new Float32Array(length * columns).fill(NaN);
    this.count = 0;
  }

  push({ time, values }) {
    if (values.length !== this.columns) return; // of the signals before a change
    if (time < this.newestTime) this.count = 0;
    if (time === this.newestTime) this.count--;
    const row = this.count++ % this.length;
    this.times[row] = time;
    this.rows.set(values, row * this.columns);
  }

  get newestTime() {
    return this.count === 0 ? NaN : this.times[(this.count - 1) % this.length];
  }

  newest(column) {
    if (column === undefined || this.count === 0) return NaN;
    return this.rows[((this.count - 1) % this.length) * this.columns + column];
  }

  // Times [s] and values of one column, oldest first.
  series(column) {
    const kept = Math.min(this.count, this.length);
    const times = new Float64Array(kept);
    const values = new Float32Array(kept);
    for (let i = 0; i < kept; i++) {
      const row = (this.count - kept + i) % this.length;
      times[i] = this.times[row];
      values[i] = this.rows[row * this.columns + column];
    }
    return { times, values };
  }
}
