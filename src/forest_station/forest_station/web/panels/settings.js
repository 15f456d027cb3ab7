// Settings of the running nodes: the few that an operator changes while driving, and all others in a table.

import { make, setText } from "../elements.js";
import { makeButtons, makeSlider, namesIn } from "../settings/controls.js";
import { meaning } from "../settings/meanings.js";
import { makeTable } from "../settings/table.js";

export const place = "right";
export const title = "Settings";

const SWITCH = [[false, "off"], [true, "on"]]; // prettier-ignore

// What stands first: of which node, what people call it, and how it is chosen.
const FIRST = [
  { node: "controller", name: "scheme", label: "Scheme", make: choices },
  { node: "controller", name: "mode", label: "Sticks give", make: choices },
  { node: "controller", name: "axis_frame", label: "Sticks' axes", make: choices },
  { node: "controller", name: "profile", label: "Profile", make: shipped },
  { node: "controller", name: "tip_speed", label: "Tip speed", make: (told, set) => makeSlider(told, "m/s", set) },
  { node: "controller", name: "workspace", label: "Walls", make: (told, set) => shipped(told, set, ["", "none"]) },
  { node: "valve_driver", name: "adapt", label: "Learning valves", make: (_, set) => makeButtons(SWITCH, set) },
  { node: "controller", name: "anti_sway", label: "Sway damping", make: (_, set) => makeButtons(SWITCH, set) },
];

export function mount(element, station) {
  const answer = make("p", { className: "answer", role: "status" });
  let nodes = {};
  const set = async (node, name, value) => {
    const { ok, text } = await station.ask("set_parameter", { node, name, value });
    answer.dataset.ok = ok;
    setText(answer, text);
    show(); // what was refused stands as it was
  };
  const first = make("div", { className: "first" });
  const table = makeTable(set);
  element.append(first, answer, table.element);
  let controls = new Map();
  const show = () => {
    const there = FIRST.filter(({ node, name }) => nodes[node]?.[name]);
    if (there.length !== controls.size || there.some((one) => !controls.has(one))) {
      controls = new Map(there.map((one) => [one, made(one, nodes[one.node][one.name], set)]));
      first.replaceChildren(...[...controls.values()].flatMap(({ label, element: control, means }) => [label, control, means]));
    }
    for (const [one, control] of controls) {
      const { value } = nodes[one.node][one.name];
      control.show(value);
      setText(control.means, meaning(one.name, value, nodes.controller?.scheme?.value));
    }
    table.show(nodes);
  };
  station.on("parameters", (told) => {
    nodes = told.nodes;
    show();
  });
}

function made(one, told, set) {
  const control = one.make(told, (value) => set(one.node, one.name, value));
  (control.input ?? control.element).setAttribute("aria-label", one.label);
  return { ...control, label: make("span", { textContent: one.label, title: told.text }), means: make("small") };
}

function choices(told, set) {
  return makeButtons(told.choices.map((name) => [name, name.replaceAll("_", " ")]), set);
}

// Buttons for the shipped files that a parameter's description names.
function shipped(told, set, ...more) {
  return makeButtons([...more, ...namesIn(told.text).map((name) => [name, name])], set);
}
