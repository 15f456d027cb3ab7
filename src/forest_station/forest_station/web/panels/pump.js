// Displacement of the pump, and the speed of the engine that drives it, of machines that model them.

import { makeInstrument } from "../instruments/instrument.js";
import { percent, revolutionsPerMinute } from "../instruments/units.js";

export const { place, title, mount } = makeInstrument(
  {
    title: "Pump",
    unit: "%",
    range: [0, 100],
    lines: [{ label: "displacement", signals: ["ground_truth/pump/displacement"], value: percent }],
  },
  {
    title: "Engine",
    unit: "rpm",
    range: [1000, 2500],
    lines: [{ label: "engine", signals: ["ground_truth/pump/speed"], value: revolutionsPerMinute }],
  },
);
