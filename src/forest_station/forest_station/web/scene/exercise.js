// The square that a newcomer drives along: all of it, and the side that comes next.

import { Group, Vector3 } from "../vendor/three.js";
import { Polyline } from "./polyline.js";
import { COLOURS } from "./colours.js";

export class Exercise {
  constructor() {
    this.root = new Group();
    this.outline = new Polyline(5, { color: COLOURS.exercise, linewidth: 2, dashed: true, dashSize: 0.06, gapSize: 0.06 });
    this.next = new Polyline(2, { color: COLOURS.exercise, linewidth: 6 });
    this.root.add(this.outline.line, this.next.line);
    this.show(null);
  }

  // Shows corners and the side to drive, each a list of points; null: nothing, or no side any more.
  show(exercise) {
    this.goal = exercise?.side?.[1];
    this.outline.set(exercise ? [...exercise.corners, exercise.corners[0]] : []);
    this.next.set(exercise?.side ?? []);
  }

  labels() {
    return this.goal ? [{ key: "goal", text: "drive here", at: new Vector3(...this.goal), kind: "goal" }] : [];
  }
}
