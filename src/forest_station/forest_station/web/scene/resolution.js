// How fine and how often the painter draws: as fine as leaves enough pictures a second, and with a rest after each,
// so that a processor that draws pixels has time for everything else.

const [FINEST, COARSEST, STEP] = [1, 0.4, 0.1];
const [SLOW_MS, FAST_MS] = [45, 18]; // of a picture: coarser beyond the one, finer below the other
const PATIENCE = 12; // pictures between two changes
const REST = 0.5; // of a picture's own time
const WEIGHT = 0.2; // of the newest picture in the mean

export class Resolution {
  constructor() {
    this.share = FINEST;
    this.rate = 0; // pictures drawn a second
    this.mean = NaN; // [ms] of a picture
    this.since = 0;
    this.times = [];
  }

  // Time to wait before the next picture [ms].
  rest() {
    return Number.isFinite(this.mean) ? Math.min(100, REST * this.mean) : 0;
  }

  // Counts a picture; true if the next shall have another resolution.
  drawn(began, ended) {
    this.times = [...this.times.filter((time) => time > ended - 1000), ended];
    this.rate = this.times.length;
    const took = ended - began;
    this.mean = Number.isFinite(this.mean) ? this.mean + WEIGHT * (took - this.mean) : took;
    if (++this.since < PATIENCE) return false;
    const wanted = this.mean > SLOW_MS ? -STEP : this.mean < FAST_MS ? STEP : 0;
    const share = Math.min(FINEST, Math.max(COARSEST, this.share + wanted));
    if (share === this.share) return false;
    this.share = share;
    this.since = 0;
    return true;
  }
}
