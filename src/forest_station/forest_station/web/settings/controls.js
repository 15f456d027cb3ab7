// A control for a parameter of a node, by its type: what it takes, what it sends, how it shows a value.

import { make, makeButton } from "../elements.js";

const STEPS = 100; // of a slider

// Returns {element, show}: `show(value)` displays a value, `set(value)` is called with a new one.
export function makeControl(parameter, set) {
  const { type, choices } = parameter;
  const made = choices ? choice(choices, set) : type === "bool" ? toggle(set) : input(parameter, set);
  for (const part of [made.element, ...made.element.querySelectorAll("*")]) part.disabled = !parameter.live;
  return made;
}

// Buttons, one of which is pressed: for the few settings that are changed while driving.
export function makeButtons(names, set) {
  const buttons = names.map(([value, text]) => [value, makeButton(text, () => set(value))]);
  const element = make("div", { className: "choices" }, ...buttons.map(([, button]) => button));
  element.setAttribute("role", "group");
  const show = (value) => buttons.forEach(([own, button]) => button.setAttribute("aria-pressed", own === value));
  return { element, show };
}

// A slider with its number; what is dragged is sent when it is let go.
export function makeSlider({ range: [low, high] }, unit, set) {
  const slider = make("input", { type: "range", min: low, max: high, step: niceStep(low, high) });
  const told = make("output");
  const tell = () => (told.textContent = `${slider.valueAsNumber} ${unit}`);
  slider.addEventListener("input", tell);
  slider.addEventListener("change", () => set(slider.valueAsNumber));
  const show = (value) => {
    if (document.activeElement === slider && slider.matches(":active")) return;
    slider.value = value;
    tell();
  };
  return { element: make("div", { className: "slider" }, slider, told), input: slider, show };
}

// What a parameter takes, in words.
export function allowed({ type, range, choices, live }) {
  if (!live) return "set at the node's start";
  if (choices) return choices.join(", ");
  if (!range) return type === "bool" ? "on or off" : type;
  const [low, high] = range.map((limit) => limit ?? "any");
  return `${low} to ${high}`;
}

// Names of shipped files that a text parameter's description tells: "walls: c180, or path of a file".
export function namesIn(text) {
  const found = /: (.+?), or path of a file/.exec(text);
  return found ? found[1].split(", ") : [];
}

function choice(choices, set) {
  const select = make("select", {}, ...choices.map((value) => make("option", { value, textContent: value })));
  select.addEventListener("change", () => set(select.value));
  return { element: select, show: (value) => (select.value = value) };
}

function toggle(set) {
  const box = make("input", { type: "checkbox" });
  box.addEventListener("change", () => set(box.checked));
  return { element: box, show: (value) => (box.checked = value) };
}

function input({ type, range }, set) {
  const single = type === "float" || type === "int";
  const field = make("input", single ? { type: "number", step: type === "int" ? 1 : "any" } : { type: "text" });
  if (single && range) [field.min, field.max] = range.map((limit) => limit ?? "");
  field.addEventListener("change", () => set(parsed(type, field.value)));
  const show = (value) => {
    if (document.activeElement !== field) field.value = Array.isArray(value) ? value.join(", ") : (value ?? "");
  };
  return { element: field, show };
}

// What was typed in the parameter's type; what cannot be read goes as it is, and the node says what is wrong with it.
function parsed(type, text) {
  if (type.endsWith("[]")) return text.split(",").map((part) => parsed(type.slice(0, -2), part.trim()));
  if (type === "str") return text;
  if (type === "bool") return text === "true";
  const value = Number(text);
  return text.trim() === "" || Number.isNaN(value) ? text : value;
}

function niceStep(low, high) {
  return 10 ** Math.floor(Math.log10((high - low) / STEPS));
}
