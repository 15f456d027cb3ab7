// Ground, sky, carrier, bunk and trees: for the eye only, the crane neither feels nor avoids them.

import {
  BackSide, BoxGeometry, CircleGeometry, Color, ConeGeometry, CylinderGeometry, Float32BufferAttribute, GridHelper, Group,
  Mesh, MeshBasicMaterial, SphereGeometry,
} from "../vendor/three.js";
import { COLOURS } from "./colours.js";
import { merged } from "./merge.js";

const FAR = 120; // [m] radius of ground and sky
const GRID = 24; // [m] of the grid of metres
// Tiers of a spruce: radius, foot and height as shares of the tree's.
const TIERS = [[1, 0.12, 0.5], [0.8, 0.34, 0.4], [0.58, 0.54, 0.32], [0.36, 0.74, 0.26]];
const BACKDROP = 2; // drawn after what stands before it: hidden pixels cost nothing

export class Surroundings {
  constructor(scene, light) {
    this.root = new Group();
    const make = { tree, bunk, carrier };
    const parts = scene.surroundings.flatMap((thing) => make[thing.kind](thing.size).map((part) => placed(part, thing)));
    const things = new Mesh(merged(parts, light), new MeshBasicMaterial({ vertexColors: true }));
    things.renderOrder = 1;
    this.root.add(things, sky(), ...ground(scene.ground));
  }
}

function placed([geometry, colour], { xyz, yaw }) {
  return [geometry.rotateZ(yaw).translate(...xyz), COLOURS[colour]];
}

// A dome that grows lighter towards the horizon.
function sky() {
  const dome = new SphereGeometry(FAR, 24, 16).rotateX(Math.PI / 2);
  const [zenith, horizon] = [new Color(COLOURS.sky), new Color(COLOURS.horizon)];
  const heights = dome.attributes.position;
  const colours = [];
  for (let i = 0; i < heights.count; i++) {
    const share = Math.min(1, Math.max(0, heights.getZ(i) / FAR) * 1.8);
    colours.push(...horizon.clone().lerp(zenith, Math.sqrt(share)).toArray());
  }
  dome.setAttribute("color", new Float32BufferAttribute(colours, 3));
  const mesh = new Mesh(dome, new MeshBasicMaterial({ vertexColors: true, side: BackSide, fog: false }));
  mesh.renderOrder = BACKDROP + 1;
  return mesh;
}

function ground(height) {
  const disc = new Mesh(new CircleGeometry(FAR, 48), new MeshBasicMaterial({ color: COLOURS.ground }));
  disc.position.z = height - 0.01;
  disc.renderOrder = BACKDROP;
  const fine = new GridHelper(GRID, GRID, COLOURS.gridFine, COLOURS.gridFine).rotateX(Math.PI / 2);
  fine.position.z = height;
  const coarse = new GridHelper(2 * GRID, GRID / 2.5, COLOURS.grid, COLOURS.grid).rotateX(Math.PI / 2);
  coarse.position.z = height + 0.004;
  for (const grid of [fine, coarse]) grid.renderOrder = BACKDROP;
  return [disc, fine, coarse];
}

function tree([radius, height]) {
  const tiers = TIERS.map(([wide, foot, high]) => {
    const tier = new ConeGeometry(wide * radius, high * height, 9, 1, true).rotateX(Math.PI / 2);
    return [tier.translate(0, 0, (foot + high / 2) * height), "tree"];
  });
  const trunk = new CylinderGeometry(0.09 * radius, 0.11 * radius, 0.2 * height, 6).rotateX(Math.PI / 2);
  return [...tiers, [trunk.translate(0, 0, 0.1 * height), "trunk"]];
}

// A trailer's bunk with stakes and some logs; its origin is on the ground in its middle.
function bunk([length, width, height]) {
  const floor = 0.42 * height;
  const parts = [-1, 1].map((side) => block("steel", [length, 0.12, 0.18], [0, 0.2 * side * width, floor]));
  for (const share of [-0.42, -0.14, 0.14, 0.42]) {
    const x = share * length;
    parts.push(block("steel", [0.14, width, 0.12], [x, 0, floor + 0.12]));
    for (const y of [-0.48 * width, 0.48 * width]) {
      parts.push(block("steel", [0.1, 0.08, height - floor], [x, y, 0.5 * (height + floor)]));
    }
  }
  for (const x of [0.12 * length, 0.34 * length]) {
    for (const y of [-0.42 * width, 0.42 * width]) parts.push(...wheel(0.9 * floor, x, y));
  }
  return [...parts, ...pile(length, width, floor + 0.18)];
}

function pile(length, width, floor) {
  const radius = 0.08 * width;
  const places = [[-2.5, 0], [-0.9, 0], [0.8, 0], [2.4, 0], [-1.6, 1], [0.1, 1]]; // across and up, in diameters
  return places.flatMap(([across, up], i) => {
    const thick = radius * (0.95 + 0.06 * ((i * 7) % 5));
    const at = [0.02 * length * ((i % 3) - 1), 2 * across * radius, floor + radius * (1 + 1.75 * up)];
    const lying = (r, l) => new CylinderGeometry(r, r, l, 14).rotateZ(Math.PI / 2).translate(...at);
    return [[lying(thick, 0.94 * length), "bark"], [lying(0.9 * thick, 0.945 * length), "log"]];
  });
}

// A carrier with its cab behind the crane and a pillar under it, for a pivot at some height over the ground.
function carrier([height]) {
  const s = height / 2.2; // as a C-180's
  const sized = (colour, size, xyz) => block(colour, size.map((each) => s * each), xyz.map((each) => s * each));
  const parts = [
    sized("steel", [4.6, 1.1, 0.35], [-1.3, 0, 0.85]),
    sized("paint", [1.5, 1.9, 1.0], [-3.2, 0, 1.5]),
    sized("paint", [1.4, 1.8, 0.9], [-1.85, 0, 1.45]),
    sized("glass", [1.3, 1.66, 1.0], [-1.85, 0, 2.4]),
    sized("paint", [1.5, 1.86, 0.12], [-1.85, 0, 2.95]),
  ];
  for (const x of [-2.48, -1.2]) for (const y of [-0.83, 0.83]) parts.push(sized("paint", [0.06, 0.06, 1.05], [x, y, 2.4]));
  for (const x of [-2.9, 0.3]) for (const y of [-1.0, 1.0]) parts.push(...wheel(1.35 * s, x * s, y * s));
  const pillar = new CylinderGeometry(0.42 * s, 0.5 * s, 0.75 * s, 24).rotateX(Math.PI / 2).translate(0, 0, 1.1 * s);
  return [...parts, [pillar, "steel"]];
}

function block(colour, size, xyz) {
  return [new BoxGeometry(...size).translate(...xyz), colour];
}

// A wheel that stands on the ground, across x, with its rim.
function wheel(diameter, x, y) {
  const round = (d, wide) => new CylinderGeometry(d / 2, d / 2, wide * diameter, 24).translate(x, y, diameter / 2);
  return [[round(diameter, 0.42), "rubber"], [round(0.5 * diameter, 0.43), "steel"]];
}
