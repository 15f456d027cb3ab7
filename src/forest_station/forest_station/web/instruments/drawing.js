// When charts are drawn: one after the other, for the hands look in between; then all rest, in proportion to the time that
// the drawing took. So a busy page draws them less often, and all that changes meanwhile is painted at once.

const PERIOD_MS = 50; // between the beginnings of two rounds at least
const REST = 4; // of a round's drawing

// Draws charts in rounds, by a clock {now(): [ms], pause(milliseconds): a promise}.
export class Rounds {
  #charts = [];
  #runs = false;

  constructor(clock) {
    this.clock = clock;
  }

  add(chart) {
    this.#charts.push(chart);
    if (!this.#runs) this.#round();
  }

  async #round() {
    this.#runs = true;
    const { clock } = this;
    const begun = clock.now();
    let took = 0;
    for (const chart of [...this.#charts]) {
      const before = clock.now();
      if (!this.#drew(chart)) continue;
      took += clock.now() - before;
      await clock.pause(0);
    }
    await clock.pause(Math.max(PERIOD_MS - (clock.now() - begun), REST * took));
    this.#round();
  }

  // A chart that fails leaves the others alone.
  #drew(chart) {
    try {
      return chart.drawNew();
    } catch (error) {
      this.#charts.splice(this.#charts.indexOf(chart), 1);
      reportError(error);
      return false;
    }
  }
}

// A timer of 0 ms that follows others waits for 4 ms, and a page has twenty charts; a message does not.
function pause(milliseconds) {
  if (milliseconds > 0) return new Promise((resolve) => setTimeout(resolve, milliseconds));
  return new Promise((resolve) => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => {
      port1.close();
      resolve();
    };
    port2.postMessage(null);
  });
}

const rounds = new Rounds({ now: () => performance.now(), pause });

// Has a chart drawn from now on: its `drawNew()` tells whether it had anything to draw.
export const drawn = (chart) => rounds.add(chart);
