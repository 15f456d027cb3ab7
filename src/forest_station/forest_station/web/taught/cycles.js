// The cycles of the station, and the one that is chosen.

import { fetchJson } from "../replay/bag.js";

// Emits "change" when the list or the chosen cycle was read, and "told" with the newest `taught_work`.
class Cycles extends EventTarget {
  constructor(station) {
    super();
    this.station = station;
    this.told = { there: false, phase: "", cycle: "", segment: "", text: "" };
    this.entries = []; // {name, own}
    this.name = ""; // of the chosen one
    this.cycle = null; // what its page tells
    this.trouble = "";
    station.on("taught_work", (told) => this.#hear(told));
    station.on("open", () => this.read()); // whatever was missed while the connection was lost
    station.on("parameters", () => this.read()); // the walls may be others
  }

  choose(name) {
    this.name = name;
    return this.read();
  }

  // Reads the list and the chosen cycle; a later call counts more than one whose answer comes late.
  async read() {
    const reading = (this.reading = Symbol("reading"));
    const found = this.told.there ? await this.#fetched() : { entries: [], cycle: null, trouble: "" };
    if (this.reading !== reading) return;
    Object.assign(this, found);
    this.station.emit("taught", this.cycle && { line: this.cycle.line, ends: this.cycle.segments.filter(({ end }) => end) });
    this.dispatchEvent(new Event("change"));
  }

  // Asks the server; then the cycles are read again.
  async ask(what, args) {
    const answer = await this.station.ask(what, args);
    await this.read();
    return answer;
  }

  #hear(told) {
    this.told = told;
    if (told.cycle && !["idle", "finished"].includes(told.phase)) this.name = told.cycle;
    this.dispatchEvent(new Event("told"));
    this.read();
  }

  async #fetched() {
    try {
      const entries = await fetchJson("/cycles.json");
      const known = entries.some(({ name }) => name === this.name);
      return { entries, cycle: known ? await fetchJson(`/cycles/${this.name}.json`) : null, trouble: "" };
    } catch (error) {
      return { entries: this.entries, cycle: null, trouble: error.message };
    }
  }
}

const all = new WeakMap();

// The cycles of a station's page: the same ones for every panel.
export function cyclesOf(station) {
  if (!all.has(station)) all.set(station, new Cycles(station));
  return all.get(station);
}
