// Ground, sky, carrier, bunk and trees: for the eye only, the crane neither feels nor avoids them.

import {
  BackSide, BoxGeometry, CircleGeometry, Color, ConeGeometry, CylinderGeometry, Float32BufferAttribute, GridHelper, Group,
  InstancedMesh, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, Quaternion, SphereGeometry, Vector3,
} from "../vendor/three.js";
import { COLOURS } from "./colours.js";

const FAR = 120; // [m] radius of ground and sky
const GRID = 40; // [m] of the grid of metres
const TIERS = [[1, 0.12, 0.55], [0.78, 0.36, 0.42], [0.52, 0.62, 0.38]]; // of a spruce: radius, height above ground, height

export class Surroundings {
  constructor(scene) {
    this.root = new Group();
    this.root.add(sky(), ground(scene.ground));
    const things = Map.groupBy(scene.surroundings, ({ kind }) => kind);
    this.root.add(trees(things.get("tree") ?? []));
    for (const thing of things.get("bunk") ?? []) this.root.add(placed(bunk(thing.size), thing));
    for (const thing of things.get("carrier") ?? []) this.root.add(placed(carrier(thing.size[0]), thing));
  }
}

function placed(group, { xyz, yaw }) {
  group.position.set(...xyz);
  group.rotation.z = yaw;
  return group;
}

// A dome that grows lighter towards the horizon.
function sky() {
  const dome = new SphereGeometry(FAR, 24, 12).rotateX(Math.PI / 2);
  const [zenith, horizon] = [new Color(COLOURS.sky), new Color(COLOURS.horizon)];
  const colours = [];
  const heights = dome.attributes.position;
  for (let i = 0; i < heights.count; i++) {
    const share = Math.min(1, Math.max(0, heights.getZ(i) / FAR) * 2.2);
    colours.push(...horizon.clone().lerp(zenith, share).toArray());
  }
  dome.setAttribute("color", new Float32BufferAttribute(colours, 3));
  return new Mesh(dome, new MeshBasicMaterial({ vertexColors: true, side: BackSide, fog: false, depthWrite: false }));
}

function ground(height) {
  const group = new Group();
  const disc = new Mesh(new CircleGeometry(FAR, 48), new MeshBasicMaterial({ color: COLOURS.ground }));
  disc.position.z = -0.01;
  const fine = new GridHelper(GRID, GRID, COLOURS.gridFine, COLOURS.gridFine).rotateX(Math.PI / 2);
  const coarse = new GridHelper(2 * GRID, GRID / 2.5, COLOURS.grid, COLOURS.grid).rotateX(Math.PI / 2);
  coarse.position.z = 0.004;
  group.add(disc, fine, coarse);
  group.position.z = height;
  return group;
}

function trees(things) {
  const group = new Group();
  const needles = new MeshLambertMaterial({ color: COLOURS.tree });
  for (const [wide, from, high] of TIERS) {
    const tier = new ConeGeometry(wide, high, 7, 1, true).rotateX(Math.PI / 2).translate(0, 0, from + high / 2);
    group.add(many(tier, needles, things));
  }
  const trunk = new CylinderGeometry(0.1, 0.12, 0.2, 6).rotateX(Math.PI / 2).translate(0, 0, 0.1);
  group.add(many(trunk, new MeshLambertMaterial({ color: COLOURS.trunk }), things));
  return group;
}

// One call draws all trees.
function many(geometry, material, things) {
  const mesh = new InstancedMesh(geometry, material, things.length);
  things.forEach(({ xyz, size: [radius, height], yaw }, i) => {
    const turn = new Quaternion().setFromAxisAngle(new Vector3(0, 0, 1), yaw);
    mesh.setMatrixAt(i, new Matrix4().compose(new Vector3(...xyz), turn, new Vector3(radius, radius, height)));
  });
  mesh.computeBoundingSphere();
  return mesh;
}

// A trailer's bunk with stakes and some logs; its origin is on the ground in its middle.
function bunk([length, width, height]) {
  const group = new Group();
  const [steel, rubber] = [lambert("steel"), lambert("rubber")];
  const floor = 0.42 * height;
  for (const side of [-1, 1]) group.add(block(steel, [length, 0.12, 0.18], [0, side * 0.2 * width, floor]));
  for (const share of [-0.42, -0.14, 0.14, 0.42]) {
    group.add(block(steel, [0.14, width, 0.12], [share * length, 0, floor + 0.12]));
    for (const side of [-1, 1]) {
      group.add(block(steel, [0.1, 0.08, height - floor], [share * length, side * 0.48 * width, 0.5 * (height + floor)]));
    }
  }
  for (const share of [0.12, 0.34]) for (const side of [-1, 1]) group.add(wheel(rubber, floor, [share * length, side * 0.42 * width]));
  group.add(...pile(length, width, floor + 0.18));
  return group;
}

function pile(length, width, floor) {
  const [bark, cut] = [lambert("bark"), lambert("log")];
  const radius = 0.08 * width;
  return [[-2.5, 0], [-0.9, 0], [0.8, 0], [2.4, 0], [-1.6, 1], [0.1, 1]].map(([across, up], i) => {
    const thick = radius * (1.9 + 0.12 * ((i * 7) % 5)) / 2;
    const log = new Mesh(new CylinderGeometry(thick, 1.1 * thick, 0.94 * length, 14).rotateZ(Math.PI / 2), [bark, cut, cut]);
    log.position.set(0.02 * length * ((i % 3) - 1), 2 * across * radius, floor + radius * (1 + 1.75 * up));
    return log;
  });
}

// A carrier with cab behind the crane and a pillar under it, for a boom's pivot at a height over the ground.
function carrier(height) {
  const s = height / 2.2;
  const group = new Group();
  const [paint, steel, glass, rubber] = ["paint", "steel", "glass", "rubber"].map(lambert);
  group.add(block(steel, [4.6 * s, 1.1 * s, 0.35 * s], [-1.3 * s, 0, 0.85 * s]));
  group.add(block(paint, [1.5 * s, 1.9 * s, 1.0 * s], [-3.2 * s, 0, 1.5 * s]));
  group.add(block(paint, [1.4 * s, 1.8 * s, 0.9 * s], [-1.85 * s, 0, 1.45 * s]));
  group.add(block(glass, [1.3 * s, 1.66 * s, 1.0 * s], [-1.85 * s, 0, 2.4 * s]));
  for (const x of [-2.48, -1.2]) for (const y of [-0.83, 0.83]) group.add(block(paint, [0.1 * s, 0.1 * s, 1.05 * s], [x * s, y * s, 2.4 * s]));
  group.add(block(paint, [1.5 * s, 1.86 * s, 0.12 * s], [-1.85 * s, 0, 2.95 * s]));
  for (const x of [-2.9, 0.3]) for (const side of [-1, 1]) group.add(wheel(rubber, 1.35 * s, [x * s, side * 1.0 * s]));
  const pillar = new Mesh(new CylinderGeometry(0.42 * s, 0.5 * s, 0.7 * s, 24).rotateX(Math.PI / 2), steel);
  pillar.position.z = 1.1 * s;
  group.add(pillar);
  return group;
}

function lambert(colour) {
  return new MeshLambertMaterial({ color: COLOURS[colour] });
}

function block(material, size, xyz) {
  const mesh = new Mesh(new BoxGeometry(...size), material);
  mesh.position.set(...xyz);
  return mesh;
}

// A wheel that stands on the ground, across x.
function wheel(material, diameter, [x, y]) {
  const mesh = new Mesh(new CylinderGeometry(diameter / 2, diameter / 2, 0.42 * diameter, 24), material);
  mesh.position.set(x, y, diameter / 2);
  return mesh;
}
