// The log in the head, as long and as thick as its mass makes it. Where nobody tells its mass it is as weighed.

import { Mesh, Quaternion, Vector3 } from "../vendor/three.js";
import { COLOURS } from "./colours.js";
import { merged } from "./merge.js";
import { log } from "./shapes.js";

const DENSITY = 850; // [kg/m³], LENGTH [m], THINNEST [m]: as in the URDF
const [LENGTH, THINNEST] = [4, 0.05];
const NOTICED = 30; // [kg] of a load that is weighed: less may be the head's own
const GRIPPED = 1.3; // radii of the head's ball under its middle: amid the jaws
const LYING = new Quaternion().setFromAxisAngle(new Vector3(0, 1, 0), Math.PI / 2); // along the head's x

// Whether a head's visual is the log that the machine's file has put there.
export const isLog = ({ shape }) => shape === "cylinder";

export class Log {
  // `visuals`: of the head, with the log that the machine's file tells, or without.
  constructor(visuals, material) {
    this.told = visuals.find(isLog)?.size;
    const drawn = log([1, 1]).map(([geometry, colour]) => [geometry, COLOURS[colour]]);
    this.root = new Mesh(merged(drawn), material);
    this.root.position.set(...place(visuals));
    this.root.quaternion.copy(LYING);
  }

  pose(signals) {
    const [radius, length] = this.#size(signals);
    this.root.visible = length > 0;
    if (length > 0) this.root.scale.set(radius, radius, length);
  }

  #size(signals) {
    const mass = signals.first("ground_truth/load/mass", "tip/load/mass");
    if (!Number.isFinite(mass)) return this.told ?? [0, 0];
    if (mass < NOTICED) return [0, 0];
    const length = signals.value("ground_truth/load/length") || LENGTH;
    return [Math.max(THINNEST, Math.sqrt(mass / (Math.PI * length * DENSITY))), length];
  }
}

function place(visuals) {
  const file = visuals.find(isLog);
  if (file) return file.xyz;
  const ball = visuals.find(({ shape }) => shape === "sphere");
  return ball ? [ball.xyz[0], ball.xyz[1], ball.xyz[2] - GRIPPED * ball.size[0]] : [0, 0, 0];
}
