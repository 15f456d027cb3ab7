// Every parameter of every node, searchable, with the node's own description.

import { make } from "../elements.js";
import { allowed, makeControl } from "./controls.js";

// Returns {element, show}: `show(nodes)` displays parameters, `set(node, name, value)` is called with a new value.
export function makeTable(set) {
  const search = make("input", { type: "search", placeholder: "search settings" });
  search.setAttribute("aria-label", "Search settings");
  const rows = make("div", { className: "rows" });
  let known = new Map(); // "node name" → its row
  const sift = () => {
    const words = search.value.toLowerCase().split(/\s+/);
    for (const row of known.values()) row.element.hidden = !words.every((word) => row.words.includes(word));
  };
  search.addEventListener("input", sift);
  const show = (nodes) => {
    const all = listed(nodes);
    if (all.length !== known.size || all.some(({ key }) => !known.has(key))) {
      known = new Map(all.map((parameter) => [parameter.key, makeRow(parameter, set)]));
      rows.replaceChildren(...[...known.values()].map(({ element }) => element));
      sift();
    }
    for (const { key, value } of all) known.get(key).show(value);
  };
  return { element: make("details", {}, make("summary", {}, "All settings"), search, rows), show };
}

function listed(nodes) {
  return Object.entries(nodes).flatMap(([node, parameters]) =>
    Object.entries(parameters).map(([name, parameter]) => ({ ...parameter, node, name, key: `${node} ${name}` })),
  );
}

function makeRow(parameter, set) {
  const { node, name, text, key } = parameter;
  const control = makeControl(parameter, (value) => set(node, name, value));
  control.element.setAttribute("aria-label", key);
  const element = make(
    "div",
    { className: "row" },
    make("span", { className: "name" }, make("small", { textContent: node }), ` ${name}`),
    control.element,
    make("small", { className: "text", textContent: `${text}; ${allowed(parameter)}` }),
  );
  return { element, words: `${key} ${text}`.toLowerCase(), show: control.show };
}
