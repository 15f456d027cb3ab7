// How far a hanging head swings out of the plumb line, as a figure beside it.

import { Vector3 } from "../vendor/three.js";

const DOWN = new Vector3(0, 0, -1);

// The label of the sway [deg]; none where nothing hangs, or nobody tells its angles.
export function sway(crane, signals) {
  const joints = crane.joints.filter(({ name }) => name.startsWith("head_"));
  if (joints.length === 0 || !joints.every(({ signal }) => Number.isFinite(signals.value(signal)))) return [];
  const top = crane.place("head");
  const below = crane.place("head", [0, 0, -1]);
  const angle = (below.clone().sub(top).angleTo(DOWN) * 180) / Math.PI;
  return [{ key: "sway", text: `sway ${angle.toFixed(0)}°`, at: below, kind: "figure" }];
}
