// The hands message, byte by byte: docs/reference/station-protocol.md.

const BYTES = 48;
const HANDS = 1;
const AXES_OFFSET = 16;

export function handsMessage({ number, time, held, axes, buttons, pong }) {
  const view = new DataView(new ArrayBuffer(BYTES));
  view.setUint8(0, HANDS);
  view.setUint8(1, held ? 1 : 0);
  view.setUint32(4, number, true);
  view.setFloat64(8, time, true);
  axes.forEach((value, axis) => view.setFloat32(AXES_OFFSET + 4 * axis, value, true));
  view.setUint32(40, buttons, true);
  view.setUint32(44, pong, true);
  return view.buffer;
}
