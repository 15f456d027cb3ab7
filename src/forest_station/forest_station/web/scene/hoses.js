// Hoses: black lines from the valves to the ports. Dashes run with the oil, in one colour to the actuator and
// in another one back.

import { CatmullRomCurve3, Group } from "../vendor/three.js";
import { COLOURS } from "./colours.js";
import { Polyline } from "./polyline.js";

const POINTS = 20; // of each line
const WIDTH = 0.045; // [m]
const STILL = 0.01; // of full flow: oil that counts as standing
const SPEED = 1.5; // [m/s] of the dashes at full flow

export class Hoses {
  constructor(hoses, crane) {
    this.root = new Group();
    this.crane = crane;
    this.hoses = hoses.map((hose) => this.#hose(hose));
  }

  pose(signals, seconds) {
    for (const hose of this.hoses) {
      const curve = new CatmullRomCurve3(hose.points.map(({ link, xyz }) => this.crane.place(link, xyz)));
      const points = curve.getPoints(POINTS - 1).map((point) => point.toArray());
      hose.rubber.set(points);
      this.#flow(hose, points, flow(hose, signals), seconds);
    }
  }

  #hose(hose) {
    const rubber = new Polyline(POINTS, { color: COLOURS.hose, linewidth: WIDTH, worldUnits: true });
    const oil = new Polyline(POINTS, {
      color: COLOURS.flowOut, linewidth: 1.05 * WIDTH, worldUnits: true, dashed: true, dashSize: 0.1, gapSize: 0.16,
    });
    oil.line.material.polygonOffset = true;
    oil.line.material.polygonOffsetFactor = -2;
    this.root.add(rubber.line, oil.line);
    return { ...hose, rubber, oil };
  }

  #flow({ oil }, points, share, seconds) {
    const flows = Math.abs(share) > STILL;
    oil.set(flows ? points : []);
    if (!flows) return;
    oil.line.material.color.setHex(share > 0 ? COLOURS.flowOut : COLOURS.flowBack);
    oil.line.material.dashOffset -= Math.sign(share) * SPEED * Math.sqrt(Math.min(1, Math.abs(share))) * seconds;
  }
}

// Share of full flow towards the actuator, -1 to 1; 0 where nobody tells it.
function flow(hose, signals) {
  for (const { signal, factor } of hose.flow) {
    const value = signals.value(signal);
    if (Number.isFinite(value)) return value * factor;
  }
  return 0;
}
