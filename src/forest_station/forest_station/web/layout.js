// The frame around all panels: the drawer of a narrow screen, and whether what is seen is fresh.

import { setText } from "./elements.js";

const FRESH_MS = 500; // frames come 30 times a second

export function layOut(station) {
  const button = document.getElementById("drawer-button");
  const show = (open) => {
    document.body.toggleAttribute("data-drawer", open);
    button.setAttribute("aria-expanded", String(open));
    setText(button, open ? "Crane" : "Instruments"); // what a press shows
  };
  button.addEventListener("click", () => show(!document.body.hasAttribute("data-drawer")));
  station.on("replay", (replay) => replay && show(false)); // it is seen in the scene, and left there
  watch(station);
}

// Sets `data-link` of the page: "connecting", then "live", "stale" (no frame came lately) or "lost".
function watch(station) {
  let newest = -Infinity;
  const mark = (link) => {
    if (document.body.dataset.link !== link) document.body.dataset.link = link;
  };
  station.on("frame", () => {
    newest = performance.now();
    mark("live");
  });
  station.on("close", () => newest > -Infinity && mark("lost"));
  setInterval(() => {
    if (station.connected && station.live && performance.now() - newest > FRESH_MS) mark("stale");
  }, FRESH_MS / 2);
  mark("connecting");
}
