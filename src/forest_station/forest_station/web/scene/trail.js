// Where the tip is and went in the last seconds, and where it was asked to go.

import { Group, Mesh, MeshBasicMaterial, SphereGeometry } from "../vendor/three.js";
import { COLOURS } from "./colours.js";
import { Polyline } from "./polyline.js";

const LENGTH_S = 20;
const MOST = 640; // 20 s at 30 a second, and some
const STEP = 0.04; // [m] between two points: each costs as much as the side of a beam
const GAP_S = 0.5; // without a wish the wished path begins anew, at the tip
const STILL = 1e-4; // [m/s]
const RADIUS = 0.045; // [m] of the mark at the tip

export class Trail {
  constructor() {
    this.root = new Group();
    this.lines = {
      wish: new Polyline(MOST, { color: COLOURS.wish, linewidth: 2.5 }),
      tip: new Polyline(MOST, { color: COLOURS.tip, linewidth: 2.5 }),
    };
    const seenThroughTheStick = { depthTest: false, transparent: true }; // from above the tip lies behind it
    this.mark = new Mesh(new SphereGeometry(RADIUS, 12, 8), new MeshBasicMaterial({ color: COLOURS.tip, ...seenThroughTheStick }));
    this.mark.renderOrder = 1;
    this.root.add(this.lines.wish.line, this.lines.tip.line, this.mark);
    this.clear();
  }

  clear() {
    this.points = { wish: [], tip: [] };
    this.wished = null;
    this.time = NaN;
    this.wishTime = NaN;
  }

  // Adds a frame: its time [s], the tip [m], the commanded velocity [m/s] or null.
  push(time, tip, command) {
    if (!(time >= this.time && time - this.time < LENGTH_S)) this.clear(); // the first frame, or a jump in a replay
    const seconds = time - this.time || 0;
    this.time = time;
    this.#add("tip", time, tip);
    this.#wish(time, seconds, tip, command);
  }

  draw() {
    for (const [name, line] of Object.entries(this.lines)) line.set(this.points[name].map(({ xyz }) => xyz));
    const newest = this.points.tip.at(-1);
    this.mark.visible = Boolean(newest);
    if (newest) this.mark.position.set(...newest.xyz);
  }

  // The wished path is the commanded velocity, added up from where the tip stood when the command began.
  #wish(time, seconds, tip, command) {
    if (!command || Math.hypot(...command) < STILL) {
      if (time - this.wishTime > GAP_S) this.wished = null;
      return;
    }
    this.wishTime = time;
    if (!this.wished) this.points.wish = [];
    this.wished = (this.wished ?? tip).map((value, i) => value + command[i] * seconds);
    this.#add("wish", time, this.wished);
  }

  // The newest point moves on until it is far enough from the one before it.
  #add(name, time, xyz) {
    const points = this.points[name];
    const before = points.at(-2);
    if (before && Math.hypot(...xyz.map((value, i) => value - before.xyz[i])) < STEP) points.pop();
    points.push({ time, xyz });
    while (points.length > MOST || points[0].time < time - LENGTH_S) points.shift();
  }
}
