// Pressures of the three axes at valve and actuator, with the supply line.

import { makeInstrument } from "../instruments/instrument.js";
import { bar } from "../instruments/units.js";

const SUPPLY = { label: "supply", signals: ["hydraulics/supply/pressure"], value: bar, colour: "#f4f7f5" };

const ACTUATORS = { swing: "motor", boom: "cylinder", stick: "cylinder" };

function ofAxis(axis) {
  const line = (port, where, dashed) => ({
    label: `${axis} port ${port} at the ${dashed ? ACTUATORS[axis] : "valve"}`,
    signals: [`hydraulics/pressures/${axis}_${port}_${where}`],
    value: bar,
    colour: port === 1 ? "#5ec8ff" : "#ffb454",
    dashed,
  });
  const lines = [line(1, "valve", false), line(2, "valve", false), line(1, "actuator", true), line(2, "actuator", true)];
  return { title: "Pressures", unit: "bar", range: [0, 220], lines: [...lines, SUPPLY] };
}

export const { place, title, mount } = makeInstrument(...["swing", "boom", "stick"].map(ofAxis));
