// How fine and how often the painter draws: as fine as a picture's time allows, and with a rest after each, so that
// whoever draws pixels has time for everything else.

const [FINEST, COARSEST] = [1, 0.3];
const SOFTWARE = /swiftshader|llvmpipe|software|basic render/i; // names of renderers without a graphics processor
const SOFTWARE_SHARE = 0.6; // of the resolution, to begin with
const WANTED_MS = 33; // of a picture
const PATIENCE = 8; // pictures between two changes
const WORTH = 0.12; // change of share below which nothing changes
// Of a picture's own time. A busy computer takes longer for a picture, and so gets a longer rest. The processor that
// draws pixels is the one that drives: three quarters of the time are for hands and nodes.
const [REST, SOFTWARE_REST] = [1, 3];
const [LONGEST_REST_MS, LONGEST_SOFTWARE_REST_MS] = [80, 1000];
const WEIGHT = 0.25; // of the newest picture in the mean

// Whether the processor draws the pixels of this browser.
export function drawsBySoftware() {
  const gl = new OffscreenCanvas(1, 1).getContext("webgl2");
  const names = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = gl?.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER) ?? "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return SOFTWARE.test(name);
}

export class Resolution {
  // `software`: the processor draws.
  constructor(software) {
    this.share = software ? SOFTWARE_SHARE : FINEST;
    [this.restful, this.longest] = software ? [SOFTWARE_REST, LONGEST_SOFTWARE_REST_MS] : [REST, LONGEST_REST_MS];
    this.rate = 0; // pictures drawn in the last second
    this.mean = NaN; // [ms] of a picture
    this.since = 0;
    this.times = [];
  }

  // Time to wait before the next picture [ms].
  rest() {
    return Math.min(this.longest, this.restful * (this.mean || 0));
  }

  // Counts a picture; true if the next shall have another resolution.
  drawn(began, ended) {
    this.times = [...this.times.filter((time) => time > ended - 1000), ended];
    this.rate = this.times.length;
    if (++this.since === 1) return false; // the first of a size makes buffers, and programs
    const took = ended - began;
    this.mean = this.since === 2 ? took : this.mean + WEIGHT * (took - this.mean);
    return this.since >= PATIENCE && this.#change();
  }

  #change() {
    const share = Math.min(FINEST, Math.max(COARSEST, this.share * Math.sqrt(WANTED_MS / this.mean)));
    if (Math.abs(share - this.share) < WORTH * this.share) return false;
    this.share = share;
    this.since = 0;
    return true;
  }
}
