// What the nodes say is wrong, the worst first, and what to do about it.

import { remedy, troubles } from "../diagnostics/remedies.js";
import { make, setText } from "../elements.js";

export const place = "left";
export const title = "Diagnostics";

const LOG_LINES = 5;

export function mount(element, station) {
  const summary = make("p", { className: "summary" });
  summary.setAttribute("role", "status");
  setText(summary, "No node has told of itself yet: the graph starts, or none runs.");
  const list = make("ul", { className: "troubles" });
  const log = make("ol", { className: "log" });
  const logged = make("details", { hidden: true }, make("summary", {}, "Log"), log);
  element.append(make("div", { className: "now" }, summary, list), logged);
  station.on("diagnostics", ({ parts }) => show(summary, list, parts));
  station.on("log", (line) => {
    log.prepend(make("li", { className: line.level }, make("b", {}, `${line.node} `), line.text));
    while (log.children.length > LOG_LINES) log.lastChild.remove();
    logged.hidden = false;
  });
}

function show(summary, list, parts) {
  const found = troubles(parts);
  setText(summary, found.length ? "" : parts.length ? `All is well: ${parts.length} parts of the crane report.` : "");
  summary.dataset.well = parts.length > 0;
  const key = JSON.stringify(found);
  if (list.dataset.key === key) return;
  list.dataset.key = key;
  list.replaceChildren(...found.map(trouble));
}

function trouble({ name, level, text }) {
  const head = make("b", {}, make("span", { className: "level" }, level), ` ${name}`);
  return make("li", { className: level }, head, make("p", {}, text), make("p", { className: "remedy" }, remedy(text)));
}
