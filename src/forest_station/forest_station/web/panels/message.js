// The line at the top that says what is in the way and what to do, one thing at a time. It keeps its height, full or empty.

import { make, setText } from "../elements.js";
import { messageLineOf } from "../message_line.js";

export const place = "top";
export const title = "";

export function mount(element, station) {
  const text = make("p", { role: "status" });
  element.append(text);
  const line = messageLineOf(station);
  const show = () => {
    const { text: said, tone } = line.shown;
    setText(text, said);
    text.dataset.tone = tone;
    text.title = said; // where the line is too short
  };
  line.addEventListener("change", show);
  show();
}
