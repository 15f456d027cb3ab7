// The emergency stop in words; pure.

// What an operator calls the nodes of our graphs; others keep their names.
const NAMES = { controller: "control", valve_driver: "valves", simulator: "simulated crane" };

// The name of a node for an operator; a namespace stays before it.
export function partName(node) {
  return node.replace(/[^/]+$/, (name) => NAMES[name] ?? name);
}

// Who stands still, and who does not: sources of the message `emergency_stop`.
export function sourcesText(sources) {
  const named = (wanted) => sources.filter(({ state }) => (state === "stopped") === wanted).map(({ name }) => partName(name));
  const [stopped, others] = [named(true), named(false)];
  const parts = [stopped.length && `Stopped: ${stopped.join(", ")}`, others.length && `not stopped: ${others.join(", ")}`];
  return parts.filter(Boolean).join("; ").replace(/.$/, "$&.");
}

// What the line at the top says of the stop; "" for nothing.
//
// told: the newest message; note: what became of a request, or ""; drives: this page does; order: what to do next.
export function stopText({ active, sources }, { note, drives, order }) {
  if (!active) return note;
  const rest = drives ? `Nothing moves. ${order}` : "Nothing moves until it is reset by who drives.";
  return `STOPPED. ${note || `${rest} ${sourcesText(sources)}`}`;
}

// Why a reset was refused, of the server's answer.
export function refusalText(text) {
  const [, node, why] = /^([\w/]+): (?:refused: )?(.*)$/s.exec(text) ?? [];
  return `Not reset: ${node ? `${partName(node)}: ${why}` : text}`;
}
