// How far the tip is from where its commanded velocity would have taken it within the last second.
//
// The controller publishes no commanded place: its command is a velocity, after every limit. Over one second the sum of
// that velocity is a place to compare with. In the joint scheme there is no command of the tip, and no value here.

import { makeInstrument } from "../instruments/instrument.js";
import { pathError } from "../instruments/lines.js";
import { millimetres } from "../instruments/units.js";

const WINDOW_S = 1;
const SIGNALS = ["tip/pose", "tip/twist_command"].flatMap((topic) => ["x", "y", "z"].map((axis) => `${topic}/${axis}`));

export const { place, title, mount } = makeInstrument({
  title: "Tip error",
  unit: "mm",
  digits: 1,
  range: [0, 20],
  lines: [
    {
      label: "off within 1 s",
      signals: SIGNALS,
      minute: (times, ...columns) => pathError(WINDOW_S, times, ...columns).map(millimetres),
    },
  ],
});
