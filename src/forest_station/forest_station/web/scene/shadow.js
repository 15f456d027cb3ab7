// The crane's shadow: the crane once more, pressed flat onto the ground in one dark colour. It costs a fraction
// of a shadow map, and tells how high the tip is.

import { Group, Matrix4 } from "../vendor/three.js";
import { COLOURS } from "./colours.js";
import { Crane, plain } from "./crane.js";

const ABOVE = 0.006; // [m] over the ground
const THIN = 1e-3; // of the height that is left: parts keep their order

export class Shadow {
  // `light`: direction from which light comes.
  constructor(scene, light) {
    this.root = new Group();
    this.crane = new Crane(scene, plain(COLOURS.shadow));
    this.root.add(this.crane.root);
    this.root.matrixAutoUpdate = false;
    const [a, b, up] = [light.x / light.z, light.y / light.z, scene.ground + ABOVE];
    // A point (x, y, z) falls to where the light's ray through it meets the ground.
    this.root.matrix = new Matrix4().set(1, 0, -a, a * up, 0, 1, -b, b * up, 0, 0, THIN, up * (1 - THIN), 0, 0, 0, 1);
  }

  pose(signals) {
    this.crane.pose(signals);
    this.root.updateMatrixWorld(true);
  }
}
