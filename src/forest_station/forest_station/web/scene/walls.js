// What the tip keeps out of, and the slow zone in which it brakes. The wall that holds it back lights up.

import {
  BoxGeometry, CircleGeometry, CylinderGeometry, EdgesGeometry, Group, LineBasicMaterial, LineSegments, Mesh,
  MeshBasicMaterial, PlaneGeometry, Quaternion, Vector3,
} from "../vendor/three.js";
import { COLOURS } from "./colours.js";

const CALM = 0.07; // opacity of a wall
const LIT = 0.42;
const SLOW = 0.04;
const EDGE = 0.45;
const SIZE = 20; // [m] of a plane's patch
const SPOT = 1.4; // [m] radius of what lights up of a plane, beside the tip
const ABOVE = 0.02; // [m] of a plane's patch before it, so that both can be seen

export class Walls {
  constructor(walls, slowZone) {
    this.root = new Group();
    this.walls = walls;
    this.surfaces = walls.map((wall) => this.#draw(wall, slowZone));
  }

  // Lights one wall, or none; of a plane what is beside the tip.
  light(lit, tip) {
    this.surfaces.forEach(({ surface, edges, spot }, i) => {
      const on = this.walls[i] === lit;
      if (spot) {
        spot.visible = on;
        spot.position.copy(foot(tip, this.walls[i]));
      } else surface.material.opacity = on ? LIT : CALM;
      for (const part of [surface, edges]) part.material.color.setHex(on ? COLOURS.alarm : COLOURS.wall);
    });
  }

  // The wall nearest to a point, with its distance [m]; null without walls.
  nearest(point) {
    let best = null;
    for (const wall of this.walls) {
      const distance = clearance(point, wall);
      if (!best || distance < best.distance) best = { wall, distance };
    }
    return best;
  }

  #draw(wall, slowZone) {
    const surface = mesh(wall, 0, CALM);
    const edges = new LineSegments(
      new EdgesGeometry(surface.geometry, 30),
      new LineBasicMaterial({ color: COLOURS.wall, transparent: true, opacity: EDGE }),
    );
    surface.add(edges);
    const spot = wall.kind === "plane" ? spotOn(wall) : null;
    const ground = wall.kind === "plane" && wall.normal[2] > 0; // it is drawn already: seen when it acts
    this.root.add(...(ground ? [] : [surface, mesh(wall, slowZone, SLOW)]), ...(spot ? [spot] : []));
    return { surface, edges, spot };
  }
}

function spotOn(wall) {
  const spot = new Mesh(new CircleGeometry(SPOT, 32), veil(COLOURS.alarm, LIT));
  spot.quaternion.copy(facing(wall));
  return spot;
}

// The point of a plane nearest to the tip.
function foot(tip, wall) {
  const normal = new Vector3(...wall.normal);
  return tip.clone().addScaledVector(normal, wall.offset + ABOVE - tip.dot(normal));
}

function facing(wall) {
  return new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(...wall.normal));
}

// Seen from outside only: the cab, within a wall, has a clear view.
function veil(color, opacity) {
  return new MeshBasicMaterial({ color, transparent: true, opacity, depthWrite: false });
}

function mesh(wall, wider, opacity) {
  const body = new Mesh(geometry(wall, wider), veil(COLOURS.wall, opacity));
  if (wall.kind === "plane") {
    body.position.copy(new Vector3(...wall.normal)).multiplyScalar(wall.offset + wider);
    body.quaternion.copy(facing(wall));
  } else if (wall.kind === "box") {
    body.position.set(...wall.lower.map((low, i) => 0.5 * (low + wall.upper[i])));
  } else {
    body.position.set(...wall.centre, 0.5 * (wall.bottom + wall.top));
  }
  return body;
}

function geometry(wall, wider) {
  if (wall.kind === "plane") return new PlaneGeometry(SIZE, SIZE);
  if (wall.kind === "box") return new BoxGeometry(...wall.lower.map((low, i) => wall.upper[i] - low + 2 * wider));
  const radius = wall.radius + wider;
  return new CylinderGeometry(radius, radius, wall.top - wall.bottom + 2 * wider, 32).rotateX(Math.PI / 2);
}

// Distance of a point to a wall [m], negative within; as forest_control.limits.workspace.
function clearance({ x, y, z }, wall) {
  if (wall.kind === "plane") return x * wall.normal[0] + y * wall.normal[1] + z * wall.normal[2] - wall.offset;
  if (wall.kind === "box") {
    return outside([x, y, z].map((value, i) => Math.max(wall.lower[i] - value, value - wall.upper[i])));
  }
  const [a, b] = wall.centre;
  return outside([Math.hypot(x - a, y - b) - wall.radius, Math.max(wall.bottom - z, z - wall.top)]);
}

// Distance from how far each direction lies beyond its bound.
function outside(beyond) {
  const far = Math.hypot(...beyond.map((value) => Math.max(0, value)));
  return far > 0 ? far : Math.max(...beyond);
}
