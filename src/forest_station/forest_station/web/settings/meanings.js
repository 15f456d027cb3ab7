// What the choices that an operator changes while driving mean: docs/explanation/control.md.

const OF_THE_THESIS = "A stick moves the tip, as in the thesis: to compare.";

const MEANINGS = {
  scheme: {
    coordinated: "A stick moves the tip.",
    joint: "A stick moves one joint.",
    ik_velocity: OF_THE_THESIS, ik_position: OF_THE_THESIS, jacobian_velocity: OF_THE_THESIS, jacobian_position: OF_THE_THESIS,
  },
  mode: {
    rate: "The farther the stick, the faster the tip.",
    position: "The farther the stick, the farther the tip from where the deadman was pressed.",
  },
  axis_frame: {
    cartesian: "Away and left are the carrier's directions.",
    cylindrical: "Away is out from the column, left is around it.",
  },
  profile: {
    default: "Straight curves, and a small deadzone for real sticks.",
    exact: "No deadzone: for scripts; a real stick creeps with it.",
    fine: "Near the tree: a stick is a place, at most 0.3 m away.",
    operator: "Small deflections are fine work; the crane swings round.",
  },
  workspace: {
    "": "Only the crane's own limits stop the tip.",
    c180: "The tip brakes before the ground and the vehicle, and slides along them.",
  },
  adapt: {
    true: "The valve driver learns each valve's deadband and gain from how the crane moves.",
    false: "Each valve keeps the deadband and gain that its driver has.",
  },
  anti_sway: {
    true: "The tip is led so that the grapple swings less; it arrives a little later.",
    false: "The grapple swings as it hangs.",
  },
};

const OF_A_JOINT = {
  mode: {
    rate: "The farther the stick, the faster the joint.",
    position: "The farther the stick, the farther the joint from where the deadman was pressed.",
  },
  axis_frame: { cartesian: "Counts for schemes that move the tip.", cylindrical: "Counts for schemes that move the tip." },
};

// The sentence of a setting's value with a scheme; "" for one that explains itself.
export function meaning(name, value, scheme) {
  return (scheme === "joint" && OF_A_JOINT[name]?.[value]) || (MEANINGS[name]?.[value] ?? "");
}
