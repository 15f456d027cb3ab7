// Flow of the supply and into the axes that have a meter.

import { makeInstrument } from "../instruments/instrument.js";
import { litresPerMinute } from "../instruments/units.js";

const line = (label, signal, colour) => ({ label, signals: [signal], value: litresPerMinute, colour });

export const { place, title, mount } = makeInstrument({
  title: "Flows",
  unit: "l/min",
  digits: 1,
  range: [-10, 40],
  lines: [
    line("supply", "hydraulics/supply/flow", "#f4f7f5"),
    line("into swing 1", "hydraulics/flows/swing_1"),
    line("into stick 1", "hydraulics/flows/stick_1"),
  ],
});
