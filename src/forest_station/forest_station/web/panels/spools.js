// Voltage of each valve and where its spool is; in the shaded deadband nothing flows.

import { makeInstrument } from "../instruments/instrument.js";

const volts = (value) => value;

function ofAxis(axis) {
  return {
    title: "Spools",
    unit: "V",
    digits: 2,
    range: [-10, 10],
    lines: [
      { label: `${axis} valve`, signals: [`valve_voltages/${axis}`], value: volts },
      { label: "spool", signals: [`hydraulics/auxiliary/${axis}_spool`], value: volts, dashed: true },
    ],
    band: {
      signals: [`valve_driver/status/${axis}_backward_deadband`, `valve_driver/status/${axis}_forward_deadband`],
      edges: (backward, forward) => [-backward, forward],
    },
  };
}

export const { place, title, mount } = makeInstrument(...["swing", "boom", "stick"].map(ofAxis));
