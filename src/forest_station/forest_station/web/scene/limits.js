// What holds the tip back, shown on the crane where it acts, and named. Codes: docs/reference/codes.md.

import { AXES, axisAtLimit, axisAtRate } from "./axes.js";

const [RATE, JOINT, SINGULARITY, FLOW, WALL, RELEASED, LOAD, OVERLOAD, LATE] = [1, 2, 3, 4, 5, 6, 7, 8, 9];
const CYLINDERS = { swing: ["platform"], boom: ["boom_barrel", "boom_rod"], stick: ["stick_barrel", "stick_rod"] };
const LINKS = { swing: "platform", boom: "boom", stick: "stick" };
const ASIDE = [0.8, 0, 0]; // [m] along a link, where its trouble is told

export class Limits {
  constructor(crane, walls) {
    this.crane = crane;
    this.walls = walls;
    this.live = true; // false: a replay, where nobody can do anything
    this.trouble = ""; // why the controller stands still, in its words
  }

  // Lights what acts; returns its labels. `tip`: a Vector3.
  pose(signals, tip) {
    const shown = { glowing: new Set(), wall: null, labels: [] };
    this.#limit(signals, tip, shown);
    this.#saturation(signals, shown);
    this.#standing(shown);
    for (const link of this.crane.materials.keys()) this.crane.glow(link, shown.glowing.has(link));
    this.walls.light(shown.wall, tip);
    return shown.labels;
  }

  #limit(signals, tip, shown) {
    const at = (link, xyz) => this.crane.place(link, xyz);
    const say = (text, place) => shown.labels.push({ key: "limit", text, at: place, kind: "limit" });
    const limit = signals.value("controller/status/limit");
    if (limit === RATE) {
      const axis = axisAtRate((name) => signals.value(name));
      if (axis) shown.glowing.add(LINKS[axis]);
      say(axis ? `${axis}: greatest speed` : "speed limit of a joint or valve", axis ? at(LINKS[axis]) : tip);
    }
    if (limit === JOINT) {
      const axis = axisAtLimit(this.crane.joints, (name) => signals.value(name));
      shown.glowing.add(LINKS[axis]);
      say(`${axis}: joint limit`, at(LINKS[axis]));
    }
    if (limit === SINGULARITY) say("singular pose", at("stick"));
    if (limit === FLOW) {
      shown.glowing.add("platform");
      say("pump flow: no more to give", at("platform"));
    }
    if (limit === WALL) {
      shown.wall = this.walls.nearest(tip)?.wall ?? null;
      say(shown.wall ? `wall: ${shown.wall.name}` : "wall", tip);
    }
    if (limit === LOAD) {
      const share = signals.value("tip/load/share");
      for (const part of [...CYLINDERS.boom, "log"]) shown.glowing.add(part); // the boom carries it, and weighs it
      say(Number.isFinite(share) ? `load: ${Math.round(100 * share)} % of what is allowed here` : "load: not weighed", tip);
    }
    if (limit === OVERLOAD) {
      shown.glowing.add("log");
      say("overload: let go of the deadman, then put the load down", tip);
    }
    if (limit === LATE) say("late link: slower", tip);
    if (limit === RELEASED) {
      // Of the live crane the line at the top tells it, with what to do.
      if (!this.live) shown.labels.push({ key: "limit", text: "the deadman is released", at: tip, kind: "calm" });
    }
  }

  #saturation(signals, shown) {
    for (const axis of AXES) {
      if (signals.value(`valve_driver/status/${axis}_saturated`) !== 1) continue;
      const links = CYLINDERS[axis].filter((link) => this.crane.links.has(link));
      for (const link of links) shown.glowing.add(link);
      const at = this.crane.place(links[0] ?? LINKS[axis]);
      shown.labels.push({ key: `${axis}_saturated`, text: `${axis}: valve fully open`, at, kind: "limit" });
    }
  }

  // The joint that the controller's trouble is about: an overload, a runaway, a sensor.
  #standing(shown) {
    const axis = AXES.find((name) => new RegExp(`\\b${name}\\b`).test(this.trouble));
    if (!axis) return;
    shown.glowing.add(LINKS[axis]);
    const text = this.trouble.split(";")[0];
    shown.labels.push({ key: "trouble", text, at: this.crane.place(LINKS[axis], ASIDE), kind: "limit" });
  }
}
