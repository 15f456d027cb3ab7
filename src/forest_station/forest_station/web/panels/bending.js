// By how much the links are ahead of their joints, of machines whose links bend.

import { makeInstrument } from "../instruments/instrument.js";
import { degrees } from "../instruments/units.js";

export const { place, title, mount } = makeInstrument({
  title: "Bending",
  unit: "°",
  digits: 2,
  range: [-0.5, 0.5],
  lines: [
    ["column", "swing"],
    ["boom", "boom"],
    ["stick", "stick"],
  ].map(([label, axis]) => ({ label, signals: [`ground_truth/deflections/${axis}`], value: degrees })),
});
