// Hydraulic power of the supply, and its energy over the minute that the chart shows.

import { makeInstrument } from "../instruments/instrument.js";
import { integral } from "../instruments/lines.js";
import { kilowatts } from "../instruments/units.js";

const SIGNALS = ["hydraulics/supply/pressure", "hydraulics/supply/flow"];
const power = (pressure, flow) => kilowatts(pressure * flow);

export const { place, title, mount } = makeInstrument(
  {
    title: "Power and energy",
    unit: "kW",
    digits: 1,
    range: [0, 10],
    lines: [{ label: "hydraulic power", signals: SIGNALS, value: power }],
  },
  {
    title: "Energy",
    unit: "kJ",
    digits: 0,
    range: [0, 50],
    height: 72,
    lines: [
      {
        label: "energy of the minute",
        signals: SIGNALS,
        minute: (times, pressures, flows) => integral(times, flows.map((flow, i) => power(pressures[i], flow))),
      },
    ],
  },
);
