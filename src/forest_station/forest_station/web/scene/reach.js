// The reach as lines with figures: from the swing axis to the tip, and from the ground up to it.

import { Group, Vector3 } from "../vendor/three.js";
import { Polyline } from "./polyline.js";
import { COLOURS } from "./colours.js";

const LOW = 0.25; // share of the height at which its figure stands: the sway's is above it

export class Reach {
  constructor(ground) {
    this.ground = ground;
    this.root = new Group();
    const look = { color: COLOURS.area, linewidth: 1.5, dashed: true, dashSize: 0.12, gapSize: 0.1 };
    this.across = new Polyline(2, look);
    this.upright = new Polyline(2, look);
    this.root.add(this.across.line, this.upright.line);
  }

  // Draws the lines to a tip; returns their labels.
  pose(tip) {
    const { x, y, z } = tip;
    const foot = [x, y, this.ground];
    this.across.set([[0, 0, this.ground], foot]);
    this.upright.set([foot, [x, y, z]]);
    return [
      label("reach", `reach ${Math.hypot(x, y).toFixed(2)} m`, new Vector3(0.5 * x, 0.5 * y, this.ground)),
      label("height", `height ${(z - this.ground).toFixed(2)} m`, new Vector3(x, y, this.ground + LOW * (z - this.ground))),
    ];
  }
}

function label(key, text, at) {
  return { key, text, at, kind: "figure" };
}
