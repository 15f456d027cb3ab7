// How far a hanging head swings out of the plumb line: in the crane's plane, and across it.

import { makeInstrument } from "../instruments/instrument.js";
import { degrees } from "../instruments/units.js";

const LINKS = ["boom", "stick"].map((axis) => `ground_truth/joint_states/${axis}.position`);

export const { place, title, mount } = makeInstrument({
  title: "Sway",
  unit: "°",
  digits: 1,
  range: [-10, 10],
  lines: [
    {
      label: "in the plane",
      signals: ["ground_truth/head/head_in_plane.position", ...LINKS],
      value: (head, boom, stick) => degrees(head + boom + stick),
    },
    { label: "across", signals: ["ground_truth/head/head_out_of_plane.position"], value: degrees },
  ],
});
