// How far the links bend: the crane's line as it would be if they were rigid, and how far that is from the tip.

import { Group, Vector3 } from "../vendor/three.js";
import { COLOURS } from "./colours.js";
import { Polyline } from "./polyline.js";

const LINE = ["boom", "stick", "tip"]; // frames at the ends of the links
const AMID = 0.35; // share of the boom at which the figure stands
const SEEN = 0.005; // [m] at the tip, from which on it is worth a figure

export class Bending {
  constructor(crane) {
    this.crane = crane;
    this.root = new Group();
    this.line = new Polyline(LINE.length, {
      color: COLOURS.rigid, linewidth: 1.5, dashed: true, dashSize: 0.1, gapSize: 0.08, depthTest: false, transparent: true,
    });
    this.line.line.renderOrder = 1; // it lies within the links
    this.root.add(this.line.line);
  }

  // Draws the line, and leaves the crane as it is, bent; returns the label.
  pose(signals) {
    this.crane.pose(signals, true);
    const rigid = LINE.map((link) => this.crane.place(link));
    this.crane.pose(signals);
    const way = rigid.at(-1).distanceTo(this.crane.place("tip"));
    this.line.set(way > SEEN ? rigid.map((point) => point.toArray()) : []);
    if (way <= SEEN) return [];
    const amid = new Vector3().lerpVectors(rigid[0], rigid[1], AMID);
    return [{ key: "bending", text: `bent by ${(100 * way).toFixed(0)} cm`, at: amid, kind: "rigid" }];
  }
}
