// Shapes of the crane's parts, made to look like steel from the plain visuals of a URDF.

import {
  BoxGeometry, CylinderGeometry, ExtrudeGeometry, Shape, TorusGeometry,
} from "../vendor/three.js";

const SLENDER = 6; // length over width from which a box is a beam
const AROUND = 20; // faces of what is round

// Parts of a visual: [geometry, name of its colour].
export function parts(link, visual) {
  if (visual.shape === "box") return visual.size[0] > SLENDER * visual.size[1] ? beam(visual.size) : box(visual.size);
  if (visual.shape === "sphere") return head(visual.size[0]);
  if (link.endsWith("_rod")) return rod(visual.size);
  if (link.endsWith("_barrel")) return barrel(visual.size);
  if (link === "platform") return column(visual.size);
  return [[tube(...visual.size), "cast"]];
}

function box([x, y, z]) {
  return [[new BoxGeometry(x, y, z), "cast"]];
}

// A welded box beam along x: deep behind the middle, slim at the ends, a pin's boss at each end.
function beam([length, width, depth]) {
  const [half, d] = [length / 2, depth];
  const side = new Shape();
  side.moveTo(-half, -0.45 * d);
  side.lineTo(-half + 0.28 * length, -0.62 * d);
  side.lineTo(half - 0.03 * length, -0.3 * d);
  side.lineTo(half, 0.3 * d);
  side.lineTo(-half + 0.3 * length, 0.62 * d);
  side.lineTo(-half, 0.45 * d);
  side.closePath();
  const bevel = 0.06 * width;
  const thick = 0.72 * width;
  const geometry = new ExtrudeGeometry(side, {
    depth: thick - 2 * bevel, bevelThickness: bevel, bevelSize: bevel, bevelSegments: 2,
  });
  geometry.translate(0, 0, bevel - thick / 2).rotateX(Math.PI / 2);
  return [[geometry, "beam"], [boss(0.48 * d, width).translate(-half, 0, 0), "cast"],
    [boss(0.38 * d, 0.9 * width).translate(half, 0, 0), "cast"]];
}

// A pin's boss across the crane's plane.
function boss(radius, width) {
  return new CylinderGeometry(radius, radius, width, AROUND);
}

// Cylinders of a URDF lie along z, three's along y.
function tube(radius, length, wider = radius) {
  return new CylinderGeometry(wider, radius, length, AROUND).rotateX(Math.PI / 2);
}

function column([radius, height]) {
  const ring = new TorusGeometry(1.02 * radius, 0.12 * radius, 8, 32).translate(0, 0, -height / 2);
  const cheek = () => new BoxGeometry(1.3 * radius, 0.22 * radius, 0.95 * radius);
  return [
    [tube(1.05 * radius, 0.82 * height, 0.72 * radius).translate(0, 0, -0.09 * height), "cast"],
    [ring, "barrel"],
    [cheek().translate(0.25 * radius, 0.62 * radius, 0.42 * height), "beam"],
    [cheek().translate(0.25 * radius, -0.62 * radius, 0.42 * height), "beam"],
    [new BoxGeometry(0.9 * radius, 0.5 * radius, 0.7 * radius).translate(-0.1 * radius, 1.05 * radius, 0.55 * height), "barrel"],
  ];
}

function barrel([radius, length]) {
  const collar = () => tube(1.14 * radius, 0.05 * length);
  return [
    [tube(radius, length), "barrel"],
    [collar().translate(0, 0, 0.475 * length), "cast"],
    [collar().translate(0, 0, -0.44 * length), "cast"],
    [boss(1.05 * radius, 2.2 * radius).translate(0, 0, -length / 2), "cast"],
  ];
}

function rod([radius, length]) {
  return [[tube(radius, length), "rod"], [boss(1.9 * radius, 3 * radius).translate(0, 0, length / 2), "cast"]];
}

// A rotator with a grapple's two jaws, about as big as the ball that stands for it.
function head(radius) {
  return [
    [boss(0.26 * radius, 0.8 * radius).translate(0, 0, 0.35 * radius), "cast"],
    [tube(0.34 * radius, 0.7 * radius), "barrel"],
    [new BoxGeometry(1.1 * radius, 0.7 * radius, 0.34 * radius).translate(0, 0, -0.42 * radius), "head"],
    [jaw(radius), "head"],
    [jaw(radius).rotateZ(Math.PI), "head"],
  ];
}

// A curved claw in the plane of the beam, wide across it.
function jaw(radius) {
  const claw = new Shape();
  claw.moveTo(0.42 * radius, -0.4 * radius);
  claw.bezierCurveTo(1.15 * radius, -0.7 * radius, 1.05 * radius, -1.4 * radius, 0.1 * radius, -1.62 * radius);
  claw.bezierCurveTo(0.75 * radius, -1.3 * radius, 0.75 * radius, -0.85 * radius, 0.2 * radius, -0.5 * radius);
  claw.closePath();
  const width = 0.62 * radius;
  const geometry = new ExtrudeGeometry(claw, { depth: width, bevelEnabled: false, curveSegments: 8 });
  return geometry.translate(0, 0, -width / 2).rotateX(Math.PI / 2);
}

export function log([radius, length]) {
  const cut = () => tube(0.97 * radius, 0.01);
  return [
    [tube(radius, length), "bark"],
    [cut().translate(0, 0, length / 2), "log"],
    [cut().translate(0, 0, -length / 2), "log"],
  ];
}
