// The list of bags on the station.

import { fetchJson } from "./bag.js";

// Emits "change" when the list was read.
class Bags extends EventTarget {
  constructor(station) {
    super();
    this.entries = []; // {name, bytes, modified, seconds}, newest first
    this.trouble = "";
    let recorded = null;
    station.on("recording", ({ active }) => {
      if (recorded !== null && active !== recorded) this.read();
      recorded = active;
    });
    station.on("open", () => this.read()); // whatever was missed while the connection was lost
  }

  async read() {
    try {
      this.entries = await fetchJson("/bags.json");
      this.trouble = "";
    } catch (error) {
      this.trouble = error.message;
    }
    this.dispatchEvent(new Event("change"));
  }
}

const all = new WeakMap();

// The bags of a station's page: the same list for every panel.
export function bagsOf(station) {
  if (!all.has(station)) all.set(station, new Bags(station));
  return all.get(station);
}
