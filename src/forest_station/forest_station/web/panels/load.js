// Mass of the log in the simulated head.

import { makeInstrument } from "../instruments/instrument.js";

export const { place, title, mount } = makeInstrument({
  title: "Load",
  unit: "kg",
  range: [0, 500],
  lines: [{ label: "log", signals: ["ground_truth/load/mass"], value: (mass) => mass }],
});
