// An instrument: a panel with the newest values of some lines, and a chart of their last minute.
//
// One file in web/panels makes one: docs/how-to/add-an-instrument.md.

import { Chart } from "./chart.js";

// Returns what a panel exports. A definition has
//   title; unit: as it is read; digits: behind the point;
//   range: [least, most] that the chart shows at least;
//   lines: list of {label, signals, value or minute, colour, dashed}: see lines.js;
//   band: {signals, edges(...values): [low, high]}: a shaded range, as a deadband; may be left out;
//   height [px] and place may be left out.
// Several definitions make a panel of several charts, with the title and the place of the first.
export function makeInstrument(...definitions) {
  const [{ title, place = "right" }] = definitions;
  const mount = (element, station) =>
    element.append(...definitions.map((definition) => new Chart(station, definition).element));
  return { place, title, mount };
}
