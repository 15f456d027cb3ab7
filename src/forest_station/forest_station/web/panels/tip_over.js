// How far the vehicle is from tipping over, of machines with a chassis: the least of its four sides.

import { makeInstrument } from "../instruments/instrument.js";
import { percent } from "../instruments/units.js";

const SIDES = ["ahead", "left", "behind", "right"];

export const { place, title, mount } = makeInstrument({
  title: "Tip-over margin",
  unit: "%",
  range: [0, 100],
  lines: [
    {
      label: "least",
      signals: SIDES.map((side) => `ground_truth/tip_over/${side}`),
      value: (...margins) => percent(Math.min(...margins)),
    },
  ],
});
