// Many geometries as one with a colour at each corner: a call for each part costs more than its pixels.

import { BufferGeometry, Color, Float32BufferAttribute, Vector3 } from "../vendor/three.js";

const LEAST = 0.42; // share of its colour that a face away from the light has

// `parts`: [geometry, colour]. With `light`, the direction from which it comes, the light is in the colours, for a
// material that computes none.
export function merged(parts, light = null) {
  const [positions, normals, colours] = [[], [], []];
  for (const [geometry, colour] of parts) {
    const plain = geometry.index ? geometry.toNonIndexed() : geometry;
    positions.push(...plain.attributes.position.array);
    normals.push(...plain.attributes.normal.array);
    colours.push(...painted(plain.attributes.normal, new Color(colour), light?.clone().normalize()));
    geometry.dispose();
  }
  const whole = new BufferGeometry();
  for (const [name, values] of [["position", positions], ["normal", normals], ["color", colours]]) {
    whole.setAttribute(name, new Float32BufferAttribute(values, 3));
  }
  return whole;
}

function painted(normals, colour, light) {
  const values = [];
  const normal = new Vector3();
  for (let i = 0; i < normals.count; i++) {
    const lit = light ? normal.fromBufferAttribute(normals, i).dot(light) : 1;
    const share = LEAST + (1 - LEAST) * Math.max(0, 0.5 + 0.5 * lit);
    values.push(colour.r * share, colour.g * share, colour.b * share);
  }
  return values;
}
