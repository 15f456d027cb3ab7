// The segments of the chosen cycle: the one that is played stands out, each can be edited by the driver.

import { make, makeButton } from "../elements.js";

// Returns {element, show}: `show(cycle, told)` displays a cycle, `ask(what, args)` edits it.
export function makeSegments(ask) {
  const element = make("ol", { className: "segments" });
  let shown = "";
  const show = (cycle, told) => {
    const key = JSON.stringify(cycle?.segments ?? []);
    if (key !== shown) element.replaceChildren(...(cycle?.segments ?? []).map((segment) => row(segment, cycle.name, ask)));
    shown = key;
    const at = cycle?.name === told.cycle && !["idle", "finished"].includes(told.phase) ? told.segment : null;
    for (const item of element.children) item.toggleAttribute("data-current", item.dataset.name === at);
  };
  return { element, show };
}

function row(segment, cycle, ask) {
  const named = make("span", { className: "name", textContent: segment.name });
  const item = make("li", {}, make("details", {}, make("summary", {}, named, " ", make("small", {}, segment.text)),
    editor(segment, (what, args) => ask(what, { cycle, segment: segment.name, ...args }))));
  item.dataset.name = segment.name;
  return item;
}

function editor({ name, kind, speed, wait }, ask) {
  const label = field("name", { type: "text", value: name, maxLength: 60, required: true });
  const number = kind === "grapple"
    ? field("seconds", { type: "number", min: 0.1, max: 600, step: "any", value: wait || "", placeholder: "until confirmed" })
    : field("m/s", { type: "number", min: 0.02, max: 3, step: "any", value: speed, required: true });
  const form = make("form", {}, label.element, number.element, make("button", { type: "submit", textContent: "Save" }),
    makeButton("Earlier", () => ask("move_segment", { by: -1 })),
    makeButton("Later", () => ask("move_segment", { by: 1 })),
    makeButton("Delete", () => ask("delete_segment"), "delete"));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const value = number.input.valueAsNumber;
    const told = kind === "grapple" ? { wait: Number.isNaN(value) ? "confirmation" : value } : { speed: value };
    ask("change_segment", { changes: { name: label.input.value, ...told } });
  });
  return form;
}

function field(text, properties) {
  const input = make("input", properties);
  return { input, element: make("label", {}, `${text} `, input) };
}
