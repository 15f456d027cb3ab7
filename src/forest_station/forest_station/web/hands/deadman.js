// Who holds the deadman, and why nobody does.
//
// It is held as long as one holder (the page's button, the key, a gamepad) holds it. What casts doubt on the hands (a lost
// pointer, a hidden page, a thread that hung) lets go for all of them: each has to be let go and pressed anew.

export const LONGEST_GAP_MS = 100; // between two looks at the hands; a page that hangs for longer has let go

export class Deadman {
  #holders = new Set();
  #down = new Set(); // what is physically pressed, whether or not it still counts
  why = ""; // why nobody holds it any more

  get held() {
    return this.#holders.size > 0;
  }

  // Something is pressed, and does not count.
  get doubted() {
    return !this.held && this.#down.size > 0;
  }

  get holders() {
    return [...this.#holders];
  }

  // Tells whether a holder is pressed; repeated as often as one likes. Only a press after a release holds.
  set(holder, pressed) {
    if (!pressed) {
      this.#down.delete(holder);
      if (this.#holders.delete(holder)) this.why = ""; // a release explains itself
    } else if (!this.#down.has(holder)) {
      this.#down.add(holder);
      this.#holders.add(holder);
    }
  }

  // Lets go for everybody.
  release(why) {
    if (this.held) this.why = why;
    this.#holders.clear();
  }
}

// Tells whether a page that last looked at its hands at `before` [ms] has hung since.
export function hung(before, now) {
  return now - before > LONGEST_GAP_MS;
}
