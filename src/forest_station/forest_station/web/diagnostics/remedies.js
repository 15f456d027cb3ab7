// What to do about a message of /diagnostics: docs/explanation/safety.md and docs/reference/codes.md say why.

import { partName } from "../hands/stop_words.js";

// The first entry whose pattern is found in the message.
const REMEDIES = [
  [/^the graph starts/, "Wait some seconds. What is missing then is said here."],
  [/waiting for a joystick/, "If you have the seat, wait a second. Else take it, or start a joystick node in the same ROS domain."],
  [/waiting for the machine's state/, "Start the simulator, or the crane's interface."],
  [/waiting for commands/, "Start the controller, in the same ROS domain and namespace."],
  [/waiting for voltages/, "Start the valve driver."],
  [/waiting for pressures|the nominal load is taken/, "Look at the pressure transducers. Until then the tip follows less exactly."],
  [/waiting for/, "Start who is waited for, in the same ROS domain and namespace."],
  [/is not heard/, "Have its publisher offer the QoS that is named: docs/reference/topics.md lists it."],
  [/more than one node publishes/, "Stop all of the named nodes but ours. Then release the deadman, centre the sticks, and reset the stop."],
  [/emergency stop pressed/, "See why it was pressed. Then release the deadman, centre the sticks, and reset it."],
  [/never repeats a sample/, "Set the joystick driver's autorepeat rate to 20 Hz or more."],
  [/nothing new for longer than joy_timeout/, "Look at the joystick and its link. Centre the sticks, then press the deadman anew."],
  [/held still to the last bit/, "The joystick may hang: let go, centre the sticks, press the deadman anew; else unplug it."],
  [/until they have been centred/, "Let go of the sticks. Then they move the crane."],
  [/^joy/, "Look at the joystick's driver: it sends what /joy does not allow."],
  [/goes by itself/, "Shut off the hydraulics: a spool sticks or a pipe is torn."],
  [/^machine file/, "Stand clear. Start the graph anew with this crane's machine file; look at valves and sensors."],
  [/^the supply/, "Stand clear. Look whether engine and pump run, and at the oil; then let go of the deadman."],
  [/^supply/, "Stand clear. Look whether engine and pump run. Else start the graph anew with this crane's machine file."],
  [/^overload/, "Stand clear. Let go of the deadman, then put the load down, or draw it in."],
  [/^load:/, "Draw the load in, or put it down: then there is room again."],
  [/its sensor is frozen/, "Stand clear. Look at this joint's sensor and its cable, and whether the joint is stuck."],
  [/^joint state: .*(is .* rad|moves at|finite)/, "Look at this joint's sensor, its cable and its calibration."],
  [/^joint state|no state of the machine/, "Look at the sensors of the joints, and whether the crane's interface runs."],
  [/valve driver: no voltages|no command/, "Look whether controller and valve driver run; restart the one that is gone."],
  [/keeps the valves shut/, "Read what the valve driver says. Look whether it waits, or runs with --shadow."],
  [/clipped to its rating/, "The valve cannot open further: ask for less speed."],
  [/too soon|goes back|stands still/, "Look for two publishers of this topic, and at the clocks of the computers."],
  [/a command is not zero/, "Release the deadman, then reset."],
  [/hands off/, "An experiment has the valves: wait for its end, or press the emergency stop."],
  [/deadman is held/, "Release the deadman first."],
  [/allowed:/, "Have its sender keep to what is allowed."],
];

export function remedy(text) {
  return REMEDIES.find(([pattern]) => pattern.test(text))?.[1] ?? "Read the node's log, and docs/explanation/safety.md.";
}

const WORST_FIRST = ["error", "stale", "warning", "ok"];

// What is not well, the worst first; of several alike the first by name. What several say is told once, with all their names.
export function troubles(statuses) {
  const found = new Map(); // by level and text
  for (const { name, level, text } of statuses.filter(({ level }) => level !== "ok")) {
    const key = `${level} ${text}`;
    found.set(key, { names: [...(found.get(key)?.names ?? []), name], level, text });
  }
  const told = [...found.values()].map(({ names, level, text }) => ({ name: namesText(names), level, text }));
  return told.sort((a, b) => WORST_FIRST.indexOf(a.level) - WORST_FIRST.indexOf(b.level) || a.name.localeCompare(b.name));
}

// Names of parts, "NODE: PART", as an operator calls the nodes; a part that all of them have is named once.
function namesText(names) {
  const found = names.map((name) => /^([^:]+): (.*)$/s.exec(name) ?? ["", name, ""]);
  const [[, , part]] = found;
  const nodes = found.map(([, node]) => partName(node));
  if (names.length > 1 && part && found.every(([, , other]) => other === part)) return `${part}: ${nodes.join(", ")}`;
  return found.map(([, , own], i) => (own ? `${nodes[i]}: ${own}` : nodes[i])).join(", ");
}
