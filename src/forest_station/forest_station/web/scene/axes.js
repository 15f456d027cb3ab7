// The driven joints, in the order of every array that has one number per axis.

export const AXES = ["swing", "boom", "stick"];
const STILL = 1e-3; // [rad/s]

const NEAR = 0.7; // [1] of its greatest rate, from which on a joint is taken to be at it

// The axis that is nearest to its greatest rate; "" if none is near, or nobody knows. value(name): of a signal [SI].
export function axisAtRate(value) {
  const share = (axis) => Math.abs(value(`joint_states/${axis}.velocity`)) / value(`crane/${axis}.greatest_rate`) || 0;
  const best = AXES.reduce((one, other) => (share(other) > share(one) ? other : one));
  return share(best) >= NEAR ? best : "";
}

// The axis that is nearest to a limit that it moves towards, in shares of its range; one that stands has two.
//
// joints: of a scene; value(name): of a signal [SI].
export function axisAtLimit(joints, value) {
  const room = (axis) => {
    const { limit, signal } = joints.find(({ name }) => name === axis);
    const [position, rate] = [value(signal), value(`joint_states/${axis}.velocity`)];
    const [below, above] = [position - limit[0], limit[1] - position];
    return (rate > STILL ? above : rate < -STILL ? below : Math.min(below, above)) / (limit[1] - limit[0]);
  };
  return AXES.reduce((best, axis) => (room(axis) < room(best) ? axis : best));
}
