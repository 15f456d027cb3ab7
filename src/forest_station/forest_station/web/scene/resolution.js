// How fine and how often the painter draws: as fine as a picture's time allows, and with a rest after each, so that a
// processor that draws pixels has time for everything else.

const [FINEST, COARSEST] = [1, 0.4];
// With a page that is about to be late, by its level of relief: the finest share, and the least time between two pictures.
const RELIEF = [[FINEST, 0], [FINEST, 0], [COARSEST, 200], [0.3, 500]];
const SOFTWARE = /swiftshader|llvmpipe|software|basic render/i; // names of renderers without a graphics processor
const SOFTWARE_SHARE = 0.6; // to begin with
const SOFTWARE_PERIOD_MS = 66; // of their pictures at least
const WANTED_MS = 33; // of a picture
const PATIENCE = 8; // pictures between two changes
const WORTH = 0.12; // change of share below which nothing changes
const REST = 1; // of a picture's own time
const LONGEST_REST_MS = 80;
const WEIGHT = 0.25; // of the newest picture in the mean

export class Resolution {
  constructor() {
    this.share = FINEST;
    this.period = 0; // [ms] of pictures at least
    this.rate = 0; // pictures drawn in the last second
    this.mean = NaN; // [ms] of a picture
    this.since = 0;
    this.times = [];
    this.relief = 0; // level: relief.js
  }

  // Takes a level of relief; true if the next picture shall have another resolution.
  relieve(level) {
    this.relief = level;
    return this.#change(0);
  }

  begin(gl) {
    const names = gl.getExtension("WEBGL_debug_renderer_info");
    const name = gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
    if (!SOFTWARE.test(name)) return;
    this.share = SOFTWARE_SHARE;
    this.period = SOFTWARE_PERIOD_MS;
  }

  // Time to wait before the next picture [ms].
  rest() {
    const took = this.mean || 0;
    return Math.max(Math.max(this.period, RELIEF[this.relief][1]) - took, Math.min(LONGEST_REST_MS, REST * took));
  }

  // Counts a picture; true if the next shall have another resolution.
  drawn(began, ended) {
    this.times = [...this.times.filter((time) => time > ended - 1000), ended];
    this.rate = this.times.length;
    if (++this.since === 1) return false; // the first of a size makes buffers, and programs
    const took = ended - began;
    this.mean = this.since === 2 ? took : this.mean + WEIGHT * (took - this.mean);
    return this.since >= PATIENCE && this.#change(WORTH);
  }

  #change(worth) {
    const [finest] = RELIEF[this.relief];
    const wanted = this.mean > 0 ? this.share * Math.sqrt(WANTED_MS / this.mean) : this.share;
    const share = Math.min(finest, Math.max(COARSEST, wanted));
    if (share === this.share || Math.abs(share - this.share) < worth * this.share) return false;
    this.share = share;
    this.since = 0;
    return true;
  }
}
