// How far the pressure compensators of the valves are open, of machines that have them.

import { makeInstrument } from "../instruments/instrument.js";
import { percent } from "../instruments/units.js";

export const { place, title, mount } = makeInstrument({
  title: "Compensators",
  unit: "%",
  range: [0, 100],
  lines: ["swing", "boom", "stick"].map((label) => ({
    label,
    signals: [`ground_truth/compensators/${label}`],
    value: percent,
  })),
});
