// The one line at the top: of all that have something to say, the most important speaks.

const RANKS = ["stop", "answer", "drive", "hint"]; // the most important first

// Emits "change".
class MessageLine extends EventTarget {
  #said = new Map(); // by rank

  // Says a text, or "" for nothing any more. `tone`: "bad", "warn" or "calm".
  say(rank, text, tone = "warn") {
    const said = this.#said.get(rank);
    if (said?.text === text && said.tone === tone) return;
    this.#said.set(rank, { text, tone });
    this.dispatchEvent(new Event("change"));
  }

  // What is to be read: {text, tone}.
  get shown() {
    const speaking = RANKS.find((rank) => this.#said.get(rank)?.text);
    return speaking ? this.#said.get(speaking) : { text: "", tone: "calm" };
  }
}

const all = new WeakMap();

// The line of a station's page: the same one for every panel.
export function messageLineOf(station) {
  if (!all.has(station)) all.set(station, new MessageLine());
  return all.get(station);
}
