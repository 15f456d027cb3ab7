// Calibration of a device: its centres while nobody touches it, then the ends that it shows while everything is moved.

import { calibrated, rawValue } from "./mapping.js";

export class Calibration {
  #seen; // per axis of /joy: {centre, low, high} or null

  // Begins with what the device says untouched.
  constructor(device, mapping) {
    this.mapping = mapping;
    this.#seen = mapping.axes.map((one) => {
      if (!one) return null;
      const centre = rawValue(device, one.from);
      return { centre, low: centre, high: centre };
    });
  }

  // Looks at the device again.
  look(device) {
    this.#seen.forEach((seen, axis) => {
      if (!seen) return;
      const raw = rawValue(device, this.mapping.axes[axis].from);
      seen.low = Math.min(seen.low, raw);
      seen.high = Math.max(seen.high, raw);
    });
  }

  // The mapping with what was found.
  finish() {
    const axes = this.mapping.axes.map((one, axis) => (one ? calibrated(one, this.#seen[axis]) : null));
    return { ...this.mapping, axes };
  }
}
