// The page: connects, draws the crane, and mounts every panel of web/panels.
//
// A panel is one module, `panels/NAME.js`, with an optional style sheet `panels/NAME.css`. It exports
//   place: "top", "left", "right" or "bottom"; title: a short noun, "" for none;
//   mount(element, station): builds its content once, and listens to the station from then on.

import { Station } from "./station.js";
import { drawScene } from "./scene/scene.js";

async function mountPanel(name, station) {
  const panel = await import(`/web/panels/${name}.js`);
  const section = document.createElement("section");
  section.id = name;
  if (panel.title) {
    const heading = document.createElement("h2");
    heading.textContent = panel.title;
    section.append(heading);
  }
  const body = document.createElement("div");
  section.append(body);
  document.getElementById(panel.place).append(section);
  panel.mount(body, station);
}

function addStyleSheet(name) {
  const link = document.createElement("link");
  link.rel = "stylesheet";
  link.href = `/web/panels/${name}.css`;
  document.head.append(link);
}

async function json(path) {
  const response = await fetch(path);
  if (!response.ok) throw new Error(`${path}: ${response.status}`);
  return response.json();
}

const station = new Station();
const { modules, styles } = await json("/panels.json");
styles.forEach(addStyleSheet);
for (const name of modules) await mountPanel(name, station);
await drawScene(document.getElementById("scene"), station, await json("/scene.json"));
station.connect();
