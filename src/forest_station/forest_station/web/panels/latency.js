// How long a stick takes to reach the valves: half of the network's round trip, and the server's own figure.

import { make, setText } from "../elements.js";
import { handsOf } from "../hands/hands.js";

export const place = "left";
export const title = "Latency";

const PERIOD_MS = 500;

export function mount(element, station) {
  const total = make("output", { className: "figure" });
  const parts = make("span");
  element.append(total, make("span", {}, " from stick to valve voltage"), make("br"), parts);
  let server = NaN;
  let roundTrips = [];
  handsOf(station).addEventListener("latency", ({ detail }) => roundTrips.push(detail));
  station.on("latency", ({ server_ms: milliseconds }) => (server = milliseconds ?? NaN));
  setInterval(() => {
    const way = median(roundTrips) / 2;
    roundTrips = [];
    setText(total, `${text(way + server)} ms`);
    setText(parts, `${text(way)} ms on the way to the server, ${text(server)} ms from there`);
    if (Number.isNaN(way)) server = NaN; // nobody drives from here
  }, PERIOD_MS);
}

function median(values) {
  return values.length ? values.sort((a, b) => a - b)[values.length >> 1] : NaN;
}

const text = (milliseconds) => (Number.isFinite(milliseconds) ? milliseconds.toFixed(milliseconds < 10 ? 1 : 0) : "–");
