// Hands that came too late, whoever found out: the page that hung, or the server that did not hear them in time.

const [OFTEN, LATELY_MS] = [2, 60_000]; // times within, of a computer that needs more than another press

export const TOO_LATE = "sticks and keys came too late: this computer or the network is too busy"; // as operator/deadman.py says
export const ADVICE = "Close programs, shrink the window, or click pictures/s to stop them.";

// Whether a cause is lateness, in the server's words or the page's.
export const isLateness = (cause) => cause.toLowerCase().startsWith(TOO_LATE);

export class Lateness {
  #times = [];

  // Counts one at a time [ms].
  count(now) {
    this.#times = [...this.#times.filter((time) => now - time < LATELY_MS), now];
  }

  isOften(now) {
    return this.#times.filter((time) => now - time < LATELY_MS).length >= OFTEN;
  }
}
