// The crane: links as nested groups, one for each joint of the scene, moved by the joints' signals.

import { Group, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, Quaternion, Vector3 } from "../vendor/three.js";
import { COLOURS } from "./colours.js";
import { Log, isLog } from "./log.js";
import { merged } from "./merge.js";
import { parts } from "./shapes.js";

const [BASE, HEAD] = ["base_link", "head"];
const GLOW = 0.75; // share of the alarm's colour in a part that glows

// Draws a scene's links. `plain`: one material for everything, for a shadow or a ghost.
export class Crane {
  constructor(scene, plain = null) {
    this.root = new Group();
    this.links = new Map([[BASE, this.root]]);
    this.joints = scene.joints.map((joint) => this.#hang(joint));
    this.materials = new Map(); // link, or the log → its material
    for (const [name, visuals] of Object.entries(scene.links)) {
      if (name === HEAD) this.log = new Log(visuals, this.#material("log", plain));
      const steel = name === HEAD ? visuals.filter((visual) => !isLog(visual)) : visuals;
      if (steel.length > 0) this.#draw(name, steel, plain);
    }
    if (this.log) this.links.get(HEAD).add(this.log.root);
  }

  // Moves every joint; one that nobody tells follows its leader, or keeps its place. `straight`: as if no link bent.
  pose(signals, straight = false) {
    for (const joint of this.joints) {
      if (joint.signal) joint.position = this.#position(joint, signals);
      const ahead = joint.deflection && !straight ? signals.value(joint.deflection) : 0;
      move(joint, joint.position + (ahead || 0)); // rigid where nobody tells
    }
    this.log?.pose(signals);
    this.root.updateMatrixWorld(true);
  }

  // Whether anybody tells where a joint is.
  isKnown(signals) {
    return this.joints.some(({ signal }) => signal && Number.isFinite(signals.value(signal)));
  }

  // Where a point of a link is in the base frame, as last posed.
  place(link, xyz = [0, 0, 0]) {
    return this.links.get(link).localToWorld(new Vector3(...xyz));
  }

  position(name) {
    return this.joints.find((joint) => joint.name === name)?.position ?? NaN;
  }

  glow(link, on) {
    const material = this.materials.get(link);
    material?.color.setScalar(on ? 1 - GLOW : 1);
    material?.emissive.setHex(on ? COLOURS.alarm : 0).multiplyScalar(GLOW);
  }

  dispose() {
    this.root.traverse((part) => {
      part.geometry?.dispose();
      part.material?.dispose();
    });
  }

  #hang(joint) {
    const group = new Group();
    this.links.get(joint.parent).add(group);
    this.links.set(joint.child, group);
    const fixed = turned(joint.rpy);
    return { ...joint, group, fixed, along: new Vector3(...joint.axis), position: 0 };
  }

  // One mesh for a link, with a material of its own, so that it can glow alone.
  #draw(link, visuals, plain) {
    const drawn = visuals.flatMap((visual) => {
      const place = new Matrix4().compose(new Vector3(...visual.xyz), turned(visual.rpy), new Vector3(1, 1, 1));
      return parts(link, visual).map(([geometry, colour]) => [geometry.applyMatrix4(place), COLOURS[colour]]);
    });
    this.links.get(link).add(new Mesh(merged(drawn), this.#material(link, plain)));
  }

  #material(part, plain) {
    if (plain) return plain;
    const material = new MeshLambertMaterial({ vertexColors: true });
    this.materials.set(part, material);
    return material;
  }

  #position(joint, signals) {
    const told = signals.value(joint.signal);
    if (Number.isFinite(told)) return told;
    if (joint.mimic) return joint.mimic.multiplier * this.position(joint.mimic.joint) + joint.mimic.offset;
    // A hanging head of which nobody tells: plumb, as it is at rest.
    if (joint.name === "head_in_plane") return -this.position("boom") - this.position("stick");
    if (joint.name === "head_out_of_plane") return 0;
    return joint.position;
  }
}

// A material in one flat colour for a whole crane. A translucent one loses where it lies in another crane's faces.
export function plain(colour, opacity = 1) {
  const ghostly = opacity < 1;
  const behind = { polygonOffset: ghostly, polygonOffsetFactor: 1, polygonOffsetUnits: 4 };
  return new MeshBasicMaterial({ color: colour, opacity, transparent: ghostly, depthWrite: !ghostly, ...behind });
}

function move(joint, position) {
  const { group, along, fixed } = joint;
  group.position.set(...joint.xyz);
  group.quaternion.copy(fixed);
  if (joint.type === "prismatic") group.position.add(along.clone().applyQuaternion(fixed).multiplyScalar(position));
  else if (joint.signal) group.quaternion.multiply(new Quaternion().setFromAxisAngle(along, position));
}

// URDF's roll, pitch, yaw: about x, y and z of the parent, in this order.
function turned([roll, pitch, yaw]) {
  const about = (x, y, z, angle) => new Quaternion().setFromAxisAngle(new Vector3(x, y, z), angle);
  return about(0, 0, 1, yaw).multiply(about(0, 1, 0, pitch)).multiply(about(1, 0, 0, roll));
}
