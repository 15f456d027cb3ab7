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

  // Times [s] and values of one column, oldest first: of every `stride`th frame, always the same ones, and the newest.
  series(column, stride = 1) {
    const oldest = Math.max(0, this.count - this.length);
    const numbers = [];
    for (let i = Math.ceil(oldest / stride) * stride; i < this.count - 1; i += stride) numbers.push(i % this.length);
    if (this.count > 0) numbers.push((this.count - 1) % this.length);
    const pick = (place) => numbers.map(place);
    return {
      times: Float64Array.from(pick((row) => this.times[row])),
      values: Float32Array.from(pick((row) => this.rows[row * this.columns + column])),
    };
  }
}
