// Everything that is drawn of one scene, and how it follows the signals.

import { DirectionalLight, Fog, HemisphereLight, Scene, Vector3 } from "../vendor/three.js";
import { Bending } from "./bending.js";
import { COLOURS } from "./colours.js";
import { Crane, plain } from "./crane.js";
import { Exercise } from "./exercise.js";
import { Hoses } from "./hoses.js";
import { Limits } from "./limits.js";
import { LoadLimit } from "./load_limit.js";
import { Reach } from "./reach.js";
import { Shadow } from "./shadow.js";
import { Signals } from "./signals.js";
import { Surroundings } from "./surroundings.js";
import { sway } from "./sway.js";
import { Taught } from "./taught.js";
import { Trail } from "./trail.js";
import { Walls } from "./walls.js";
import { Wish } from "./wish.js";
import { WorkArea } from "./work_area.js";

const LIGHT = new Vector3(0.4, -0.75, 1);
const COMMAND = "tip/twist_command";
const GHOSTLY = 0.45; // opacity
const LONGEST_S = 0.2; // between two pictures that count as one motion, for what runs by itself

export class Picture {
  constructor(scene) {
    this.scene = scene;
    this.root = new Scene();
    this.root.fog = new Fog(COLOURS.horizon, 25, 100);
    this.crane = new Crane(scene);
    this.shadow = new Shadow(scene, LIGHT);
    this.walls = new Walls(scene.walls, scene.slow_zone);
    this.limits = new Limits(this.crane, this.walls);
    this.bending = new Bending(this.crane);
    this.loadLimit = new LoadLimit(scene);
    this.hoses = new Hoses(scene.hoses, this.crane);
    this.area = new WorkArea(scene.work_area, scene.ground);
    this.reach = new Reach(scene.ground);
    this.trail = new Trail();
    this.wish = new Wish();
    this.exercise = new Exercise();
    this.taught = new Taught();
    this.ghost = null;
    const moving = [this.crane, this.bending, this.loadLimit, this.shadow, this.hoses, this.reach, this.trail, this.wish];
    const parts = [...moving, this.walls, this.area, this.exercise, this.taught];
    this.root.add(...lights(), new Surroundings(scene, LIGHT).root, ...parts.map(({ root }) => root));
    this.pose(new Signals());
  }

  // Follows a frame; drawn or not, for the trail has every one.
  push(signals) {
    this.crane.pose(signals);
    if (!this.crane.isKnown(signals)) return; // a bag may begin with other topics
    this.trail.push(signals.time, this.#tip(signals).toArray(), signals.point(COMMAND));
  }

  // Makes everything ready for drawing; returns the labels.
  pose(signals) {
    const seconds = Math.min(LONGEST_S, Math.max(0, signals.time - this.time || 0));
    this.time = signals.time;
    const known = this.crane.isKnown(signals); // where nobody tells a joint, no crane is better than a wrong one
    for (const { root } of [this.crane, this.bending, this.shadow, this.hoses, this.reach]) root.visible = known;
    const bending = this.bending.pose(signals);
    this.shadow.pose(signals);
    this.hoses.pose(signals, seconds);
    this.area.pose(this.crane.position("swing"));
    this.trail.draw();
    const tip = this.tip();
    this.wish.pose(tip, signals.point(COMMAND));
    const ofCrane = known ? [...this.reach.pose(tip), ...sway(this.crane, signals), ...bending] : [];
    const ofLoad = this.loadLimit.pose(signals, this.crane.position("swing"));
    const said = [...ofCrane, ...ofLoad, ...this.exercise.labels(), ...this.taught.labels()];
    return [...said, ...this.limits.pose(signals, tip)];
  }

  // The drawn tip in the base frame [m].
  tip() {
    return this.crane.place("tip");
  }

  // A second, translucent crane: of a scene, or of this one, at the signals of another bag; null: none.
  showGhost(ghost) {
    const scene = ghost?.scene ?? this.scene;
    if (this.ghost && (!ghost || this.ghost.scene !== scene)) {
      this.root.remove(this.ghost.crane.root);
      this.ghost.crane.dispose();
      this.ghost = null;
    }
    if (!ghost) return;
    if (!this.ghost) {
      this.ghost = { scene, crane: new Crane(scene, plain(COLOURS.ghost, GHOSTLY)) };
      this.root.add(this.ghost.crane.root);
    }
    this.ghost.crane.pose(ghost.signals);
  }

  dispose() {
    this.root.traverse((part) => {
      part.geometry?.dispose();
      part.material?.dispose();
    });
  }

  // As measured; by the joints where nobody tells it.
  #tip(signals) {
    const told = signals.point("tip/pose");
    return told ? new Vector3(...told) : this.tip();
  }
}

function lights() {
  const sun = new DirectionalLight(0xfff2dd, 2.4);
  sun.position.copy(LIGHT);
  return [sun, new HemisphereLight(0xdfe9f0, 0x77716a, 2.3)];
}
