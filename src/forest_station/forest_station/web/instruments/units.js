// From SI to what an operator reads.

export const bar = (pascal) => pascal * 1e-5;
export const litresPerMinute = (flow) => flow * 6e4;
export const degrees = (radians) => (radians * 180) / Math.PI;
export const percent = (share) => 100 * share;
export const revolutionsPerMinute = (radiansPerSecond) => (radiansPerSecond * 30) / Math.PI;
export const celsius = (kelvin) => kelvin - 273.15;
export const kilowatts = (watts) => watts * 1e-3;
export const millimetres = (metres) => metres * 1e3;
