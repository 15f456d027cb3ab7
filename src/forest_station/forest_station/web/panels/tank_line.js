// Pressure that the returning oil builds up before the tank's filter, of machines with a tank line.

import { makeInstrument } from "../instruments/instrument.js";
import { bar } from "../instruments/units.js";

export const { place, title, mount } = makeInstrument({
  title: "Tank line",
  unit: "bar",
  digits: 1,
  range: [0, 10],
  lines: [{ label: "before the filter", signals: ["ground_truth/tank_line/pressure"], value: bar }],
});
