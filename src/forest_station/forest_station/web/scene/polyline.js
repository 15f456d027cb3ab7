// A line of some width whose points change in every frame. Line2's own setPositions makes new buffers
// each time, which nobody frees; here they are filled in place.

import { Line2, LineGeometry, LineMaterial } from "../vendor/three.js";

export class Polyline {
  constructor(most, look) {
    const geometry = new LineGeometry();
    geometry.setPositions(new Float32Array(3 * most));
    this.line = new Line2(geometry, new LineMaterial(look));
    if (look.dashed) this.line.computeLineDistances();
    this.line.frustumCulled = false;
    this.most = most;
    this.set([]);
  }

  // Shows points, each [x, y, z].
  set(points) {
    const { geometry } = this.line;
    const segments = Math.max(0, Math.min(points.length, this.most) - 1);
    geometry.instanceCount = segments;
    this.line.visible = segments > 0;
    if (segments === 0) return;
    const ends = geometry.attributes.instanceStart.data;
    for (let i = 0; i < segments; i++) {
      ends.array.set(points[i], 6 * i);
      ends.array.set(points[i + 1], 6 * i + 3);
    }
    ends.needsUpdate = true;
    this.#measure(segments, ends.array);
  }

  // Lets dashes begin where they belong: the way from the first point to each.
  #measure(segments, ends) {
    const ways = this.line.geometry.attributes.instanceDistanceStart?.data;
    if (!ways) return;
    let way = 0;
    for (let i = 0; i < segments; i++) {
      const [a, b, c, x, y, z] = ends.subarray(6 * i, 6 * i + 6);
      ways.array[2 * i] = way;
      way += Math.hypot(x - a, y - b, z - c);
      ways.array[2 * i + 1] = way;
    }
    ways.needsUpdate = true;
  }
}
