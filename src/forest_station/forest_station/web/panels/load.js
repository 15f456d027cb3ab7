// Mass of the log in the simulated head, and as the controller weighs it; the driver has it grasp one and drop it.

import { make, makeButton, setText } from "../elements.js";
import { makeInstrument } from "../instruments/instrument.js";

const instrument = makeInstrument(
  {
    title: "Load",
    unit: "kg",
    range: [0, 500],
    lines: [
      { label: "log", signals: ["ground_truth/load/mass"], value: (mass) => mass },
      { label: "weighed", signals: ["tip/load/mass"], value: (mass) => mass },
    ],
  },
  {
    title: "Of what is allowed at this reach",
    unit: "%",
    range: [0, 100],
    height: 72,
    lines: [{ label: "of the load allowed here", signals: ["tip/load/share"], value: (share) => 100 * share }],
  },
);

export const { place, title } = instrument;

export function mount(element, station) {
  instrument.mount(element, station);
  const said = make("span", { className: "said" });
  said.setAttribute("role", "status");
  const act = async (what) => {
    const { text } = await station.ask("grapple", { act: what });
    setText(said, text);
  };
  const buttons = [makeButton("Grasp a log", () => act("grasp")), makeButton("Drop it", () => act("drop"))];
  const hint = make("p", { className: "hint" }, "At rest the seals hide some of the load: the first motion weighs it.");
  element.append(hint, make("div", { className: "grapple" }, ...buttons, said));
  station.on("seat", ({ you_drive: drives }) => {
    for (const button of buttons) button.disabled = !drives;
  });
}
