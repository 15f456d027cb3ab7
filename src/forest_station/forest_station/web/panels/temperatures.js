// Temperature of the oil.

import { makeInstrument } from "../instruments/instrument.js";
import { celsius } from "../instruments/units.js";

export const { place, title, mount } = makeInstrument({
  title: "Oil temperatures",
  unit: "°C",
  digits: 1,
  range: [0, 80],
  lines: ["tank", "pump", "motor"].map((label) => ({
    label,
    signals: [`hydraulics/auxiliary/${label}_temperature`],
    value: celsius,
  })),
});
