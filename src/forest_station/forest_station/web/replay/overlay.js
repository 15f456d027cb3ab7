// The second bag over the first: which one, by how much it is shown later, and what aligns them.

import { make, setText } from "../elements.js";

const STARTS = "";

// Returns the element; `bags` are those that can be laid over.
export function makeOverlay(replay, bags) {
  const choice = make("select", { onchange: () => replay.lay(choice.value) });
  const offset = make("input", { type: "number", step: 0.05, className: "offset" });
  offset.addEventListener("change", () => replay.setOffset(offset.valueAsNumber));
  const align = make("select", { onchange: () => replay.align(align.value) });
  const distance = make("output");
  const details = make(
    "span",
    { className: "details" },
    make("label", {}, "aligned by ", align),
    make("label", {}, "shown later by ", offset, " s"),
    distance,
  );
  const follow = () => {
    if (!replay.active) return;
    details.hidden = !replay.ghost;
    const over = replay.ghost?.bag.name ?? "";
    const names = new Set([over, ...bags.entries.map(({ name }) => name)].filter(Boolean));
    names.delete(replay.bag.name);
    setOptions(choice, [["", "no other recording"], ...[...names].map((name) => [name, name])], over);
    if (!replay.ghost) return;
    setOptions(align, [[STARTS, "starts"], ...shared(replay).map((topic) => [topic, `first ${topic}`])], align.value);
    if (document.activeElement !== offset) offset.value = Number(replay.ghost.offset.toFixed(3));
    measure();
  };
  const measure = () => {
    const apart = replay.tipDistance();
    setText(distance, Number.isFinite(apart) ? `tips ${apart.toFixed(2)} m apart` : "");
  };
  replay.addEventListener("change", follow);
  bags.addEventListener("change", follow);
  replay.addEventListener("moment", measure);
  return make("div", { className: "overlay" }, make("label", {}, "compare with ", choice), details);
}

// Topics whose first message both bags tell.
function shared(replay) {
  return Object.keys(replay.bag.first).filter((topic) => topic in replay.ghost.bag.first);
}

// Sets a choice's options, if they differ: one that is open must not be rebuilt under the finger.
function setOptions(select, options, value) {
  const key = JSON.stringify(options);
  if (select.dataset.key !== key) {
    select.dataset.key = key;
    select.replaceChildren(...options.map(([name, text]) => make("option", { value: name, textContent: text })));
  }
  select.value = value;
}
