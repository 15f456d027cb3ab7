// How far out the load that hangs may go: an arc on the ground before the crane, as its load chart tells.

import { Group, Vector3 } from "../vendor/three.js";
import { COLOURS } from "./colours.js";
import { Polyline } from "./polyline.js";

const STEPS = 40;
const SPAN = 0.7; // [rad] to each side
const ABOVE = 0.02; // [m] over the ground
const SHOWN = 0.3; // share of what is allowed: less is in nobody's way
const NEAR = 0.9; // share from which a person is warned: forest_control.limits.load_moment

export class LoadLimit {
  // `capacity`: points of reach [m] and load [kg], or none.
  constructor({ capacity, ground }) {
    Object.assign(this, { capacity, height: ground + ABOVE });
    this.root = new Group();
    this.arc = new Polyline(STEPS + 1, { color: COLOURS.wall, linewidth: 4 });
    this.root.add(this.arc.line);
  }

  // Draws the arc before the crane at a swing angle [rad]; returns its label.
  pose(signals, swing) {
    const [mass, share] = ["mass", "share"].map((label) => signals.value(`tip/load/${label}`));
    const reach = share >= SHOWN ? farthest(this.capacity, mass) : null;
    const at = (angle) => [reach * Math.cos(angle), reach * Math.sin(angle), this.height];
    this.arc.set(reach === null ? [] : Array.from({ length: STEPS + 1 }, (_, i) => at(swing + SPAN * ((2 * i) / STEPS - 1))));
    this.arc.line.material.color.setHex(share >= NEAR ? COLOURS.alarm : COLOURS.wall);
    if (reach === null) return [];
    return [{ key: "load", text: `${mass.toFixed(0)} kg: up to ${reach.toFixed(1)} m`, at: new Vector3(...at(swing)), kind: "load" }];
  }
}

// The greatest reach [m] at which a load chart allows a mass; null where all of the reach is allowed, or nobody knows.
export function farthest(capacity, mass) {
  if (!capacity.length || !(mass > capacity.at(-1)[1])) return null;
  if (mass >= capacity[0][1]) return capacity[0][0];
  const next = capacity.findIndex(([, load]) => load < mass);
  const [[near, more], [far, less]] = [capacity[next - 1], capacity[next]];
  return near + ((far - near) * (more - mass)) / (more - less);
}
