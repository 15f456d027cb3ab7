// The chosen cycle of taught work: the way of the tip, and where each segment ends.

import { Group, Mesh, MeshBasicMaterial, SphereGeometry, Vector3 } from "../vendor/three.js";
import { COLOURS } from "./colours.js";
import { Polyline } from "./polyline.js";

const MOST = 2048; // points: the server sends fewer
const RADIUS = 0.06; // [m] of a place

export class Taught {
  constructor() {
    this.root = new Group();
    this.way = new Polyline(MOST, { color: COLOURS.taught, linewidth: 2 });
    this.places = new Group();
    this.geometry = new SphereGeometry(RADIUS, 12, 8);
    this.material = new MeshBasicMaterial({ color: COLOURS.taught });
    this.root.add(this.way.line, this.places);
    this.show(null);
  }

  // Shows a line of points, and ends, each with `name` and `end`; null: nothing.
  show(taught) {
    this.ends = taught?.ends ?? [];
    this.way.set(taught?.line ?? []);
    this.places.clear();
    for (const { end } of this.ends) {
      const place = new Mesh(this.geometry, this.material);
      place.position.set(...end);
      this.places.add(place);
    }
  }

  labels() {
    return this.ends.map(({ name, end }, i) => ({ key: `taught ${i}`, text: name, at: new Vector3(...end), kind: "taught" }));
  }
}
