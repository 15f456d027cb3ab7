// The page: connects, draws the crane, and mounts every panel of web/panels.
//
// A panel is one module, `panels/NAME.js`, with an optional style sheet `panels/NAME.css`. It exports
//   place: "top", "left", "right" or "bottom"; title: a short noun, "" for none;
//   mount(element, station): builds its content once, and listens to the station from then on.

import { layOut } from "./layout.js";
import { Station } from "./station.js";
import { drawScene } from "./scene/scene.js";

const FIRST = ["emergency_stop", "seat", "message", "sticks"]; // what a person needs, however slowly the rest comes

// A panel that fails leaves the others, the emergency stop above all, alone.
async function mountPanel(name, station, loading) {
  try {
    const panel = await loading;
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
    await panel.mount(body, station);
  } catch (error) {
    tell(`The panel ${name} is missing: ${error.message}`);
  }
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

function tell(text) {
  const notice = document.getElementById("notice");
  notice.textContent = text;
  notice.hidden = !text;
  console.error(text);
}

// The crane may fail to be drawn: hands and instruments work without it.
async function showCrane(station) {
  try {
    station.scene = await json("/scene.json");
    await drawScene(document.getElementById("scene"), station, station.scene);
  } catch (error) {
    tell(`The crane cannot be drawn: ${error.message}`);
  }
}

const station = new Station();
layOut(station);
const { modules, styles } = await json("/panels.json");
styles.forEach(addStyleSheet);
const names = [...FIRST.filter((name) => modules.includes(name)), ...modules.filter((name) => !FIRST.includes(name))];
const panels = names.map((name) => [name, import(`/web/panels/${name}.js`)]); // all at once: the next does not wait for the last
for (const [, loading] of panels) loading.catch(() => {}); // it is told where it is mounted
for (const [name, loading] of panels) await mountPanel(name, station, loading);
await showCrane(station);
station.connect();
