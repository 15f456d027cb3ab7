// The driven joints, in the order of every array that has one number per axis.

export const AXES = ["swing", "boom", "stick"];
const STILL = 1e-3; // [rad/s]

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
