// An arrow at the tip: the commanded velocity.

import { ArrowHelper, Vector3 } from "../vendor/three.js";
import { COLOURS } from "./colours.js";

const LENGTH = 2.5; // [m] of arrow per m/s
const STILL = 5e-3; // [m/s]

export class Wish {
  constructor() {
    this.root = new ArrowHelper(new Vector3(1, 0, 0), new Vector3(), 1, COLOURS.wish);
    this.root.line.material.depthTest = false;
    this.root.cone.material.depthTest = false;
    this.root.renderOrder = 1;
  }

  pose(tip, command) {
    const speed = command ? Math.hypot(...command) : 0;
    this.root.visible = speed > STILL;
    if (!this.root.visible) return;
    this.root.position.copy(tip);
    this.root.setDirection(new Vector3(...command).normalize());
    const length = Math.max(0.25, LENGTH * speed);
    this.root.setLength(length, Math.min(0.3, 0.5 * length), Math.min(0.2, 0.3 * length));
  }
}
