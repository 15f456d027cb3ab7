// Where the tip can be: the outline of its reach in the crane's plane, and a sector on the ground.

import {
  BufferGeometry, DoubleSide, Group, Line, LineBasicMaterial, LineLoop, Mesh, MeshBasicMaterial, Shape, ShapeGeometry, Vector3,
} from "../vendor/three.js";
import { COLOURS } from "./colours.js";

const STEPS = 96; // of a sector's arc
const ABOVE = 0.012; // [m] over the ground, so that both can be seen

export class WorkArea {
  constructor(area, ground) {
    this.root = new Group();
    this.plane = new Group();
    this.root.add(this.plane);
    const outline = area.section.map(([r, z]) => new Vector3(r, 0, z));
    this.plane.add(new LineLoop(new BufferGeometry().setFromPoints(outline), line(0.75)), filled(area.section));
    if (area.ground) this.root.add(sector(area.ground, area.swing, ground + ABOVE));
  }

  pose(swing) {
    this.plane.rotation.z = swing;
  }
}

function line(opacity) {
  return new LineBasicMaterial({ color: COLOURS.area, transparent: true, opacity });
}

function filled(section) {
  const geometry = new ShapeGeometry(new Shape(section.map(([r, z]) => ({ x: r, y: z })))).rotateX(Math.PI / 2);
  return new Mesh(geometry, new MeshBasicMaterial({
    color: COLOURS.area, transparent: true, opacity: 0.035, side: DoubleSide, depthWrite: false,
  }));
}

// The arcs of the least and greatest reach over the swing's range; sides only where it is no full turn.
function sector([inner, outer], [right, left], z) {
  const span = Math.min(left - right, 2 * Math.PI);
  const arc = (radius) => Array.from({ length: STEPS + 1 }, (_, i) => {
    const angle = 0.5 * (left + right) + span * (i / STEPS - 0.5);
    return new Vector3(radius * Math.cos(angle), radius * Math.sin(angle), z);
  });
  const group = new Group();
  const [near, far] = [arc(inner), arc(outer)];
  const lines = [near, far];
  if (span < 2 * Math.PI) lines.push([near[0], far[0]], [near[STEPS], far[STEPS]]);
  for (const points of lines) group.add(new Line(new BufferGeometry().setFromPoints(points), line(0.6)));
  return group;
}
