// Angles of the three joints.

import { makeInstrument } from "../instruments/instrument.js";
import { degrees } from "../instruments/units.js";

export const { place, title, mount } = makeInstrument({
  title: "Joint angles",
  unit: "°",
  digits: 1,
  range: [-90, 90],
  lines: ["swing", "boom", "stick"].map((label) => ({
    label,
    signals: [`joint_states/${label}.position`],
    value: degrees,
  })),
});
