// A chart of the last minute with the newest values above it, or those under the cursor. A click stops all charts.

import { make, setText } from "../elements.js";
import uPlot from "../vendor/uplot.js";
import { lineValues } from "./lines.js";
import { drawn } from "./drawing.js";
import { pauseOf } from "./pause.js";

const [SPAN_S, LEAST_SPAN_S] = [60, 5]; // of the chart: as long as what is known, at the most a minute
const STRIDE = 3; // of 30 frames a second: a chart has fewer pixels
const HEIGHT = 96; // [px]
const COLOURS = ["#5ec8ff", "#ffb454", "#7dff9f", "#ff7ab8", "#c4a7ff", "#f4f7f5"];
const SHADE = "rgb(255 212 121 / 22%)";
const FAINT = "rgb(160 180 168 / 25%)";

export class Chart {
  constructor(station, definition) {
    this.station = station;
    this.definition = definition;
    this.pause = pauseOf(station);
    this.inSight = true;
    this.drawn = NaN; // time of the newest frame that is drawn
    this.values = definition.lines.map(() => make("output"));
    this.moment = make("span", { className: "moment" });
    this.frame = make("div", { className: "frame", tabIndex: 0 });
    this.frame.setAttribute("role", "button");
    this.frame.setAttribute("aria-label", `${definition.title}, ${definition.lines[0].label}: stop or go on`);
    this.frame.style.minHeight = `${this.#size().height}px`; // before the first drawing, too
    this.element = make("div", { className: "chart", hidden: true }, this.#readings(), this.frame);
    this.frame.addEventListener("click", () => this.pause.toggle());
    this.frame.addEventListener("keydown", ({ code }) => code === "Enter" && this.pause.toggle());
    this.pause.addEventListener("change", () => this.#showPause());
    new IntersectionObserver(([entry]) => (this.inSight = entry.isIntersecting)).observe(this.element);
    new ResizeObserver(() => this.plot?.setSize(this.#size())).observe(this.frame);
    station.on("signals", () => (this.drawn = NaN));
    drawn(this);
  }

  // Draws what is new; tells whether there was anything.
  drawNew() {
    if (this.station.history.newestTime === this.drawn) return false;
    return this.draw();
  }

  // Draws the newest minute, if somebody can see it; tells whether that is so.
  draw() {
    this.element.hidden = !this.definition.lines.some(({ signals }) => this.#known(signals));
    if (this.element.hidden || !this.inSight || this.pause.paused || document.hidden) return false;
    this.plot ??= this.#plot();
    this.drawn = this.station.history.newestTime;
    this.plot.setData(this.#minute());
    this.#showValues();
    return true;
  }

  #known(signals) {
    return signals.every((name) => this.station.signals.has(name));
  }

  #column(name) {
    return this.station.history.series(this.station.signals.get(name), STRIDE).values;
  }

  // Seconds before the newest frame, and each line's values; null where nothing is known.
  #minute() {
    const { times } = this.station.history.series(0, STRIDE);
    const newest = times.at(-1);
    const lines = this.definition.lines.map((line) => {
      if (!this.#known(line.signals)) return times.map(() => NaN);
      return lineValues(line, times, line.signals.map((name) => this.#column(name)));
    });
    return [Array.from(times, (time) => time - newest), ...lines.map(withGaps)];
  }

  #readings() {
    const entries = this.definition.lines.map(({ label }, i) => {
      const swatch = make("i", { className: this.definition.lines[i].dashed ? "dashed" : "" });
      swatch.style.color = this.#colour(i);
      return make("label", {}, swatch, `${label} `, this.values[i]);
    });
    const unit = make("span", { className: "unit" }, this.definition.unit);
    return make("div", { className: "readings" }, ...entries, unit, this.moment);
  }

  #colour(i) {
    return this.definition.lines[i].colour ?? COLOURS[i % COLOURS.length];
  }

  #size() {
    return { width: Math.max(120, this.frame.clientWidth), height: this.definition.height ?? HEIGHT };
  }

  #plot() {
    const ink = getComputedStyle(this.frame).color;
    const axis = { stroke: ink, font: "11px system-ui, sans-serif", grid: { stroke: FAINT, width: 1 }, ticks: { show: false } };
    const series = this.definition.lines.map(({ dashed }, i) => ({
      stroke: this.#colour(i),
      width: 1.5,
      dash: dashed ? [4, 3] : undefined,
      points: { show: false },
    }));
    const options = {
      ...this.#size(),
      padding: [6, 14, 0, 0],
      legend: { show: false },
      cursor: { y: false, drag: { x: false, y: false }, sync: { key: "minute" } },
      scales: { x: { time: false, range: (_, first) => [-Math.min(SPAN_S, Math.max(LEAST_SPAN_S, -first || 0)), 0] }, y: { range: (_, low, high) => this.#range(low, high) } },
      axes: [{ ...axis, size: 20, values: (_, at) => at.map((s) => `${s} s`) }, { ...axis, size: 44 }],
      series: [{}, ...series],
      hooks: { drawClear: [(plot) => this.#shade(plot)], setCursor: [() => this.#showValues()] },
    };
    return new uPlot(options, [[], ...series.map(() => [])], this.frame);
  }

  #range(low, high) {
    const [least, most] = this.definition.range;
    return [Math.min(least, low ?? least), Math.max(most, high ?? most)];
  }

  // The band as it is at the newest frame.
  #shade(plot) {
    const { band } = this.definition;
    if (!band || !this.#known(band.signals)) return;
    const [low, high] = band.edges(...band.signals.map((name) => this.station.value(name)));
    if (!Number.isFinite(high - low)) return;
    const [top, bottom] = [plot.valToPos(high, "y", true), plot.valToPos(low, "y", true)];
    plot.ctx.fillStyle = SHADE;
    plot.ctx.fillRect(plot.bbox.left, top, plot.bbox.width, bottom - top);
  }

  #showValues() {
    const { cursor, data } = this.plot;
    const pointed = Number.isInteger(cursor.idx);
    const at = pointed ? cursor.idx : data[0].length - 1;
    this.values.forEach((output, i) => setText(output, this.#text(data[i + 1][at])));
    setText(this.moment, pointed ? `${data[0][at].toFixed(1)} s` : "");
  }

  #text(value) {
    return Number.isFinite(value) ? value.toFixed(this.definition.digits ?? 0).replace(/^-(?=0\.?0*$)/, "") : "–";
  }

  #showPause() {
    this.element.classList.toggle("paused", this.pause.paused);
    this.draw();
  }
}

function withGaps(values) {
  return Array.from(values, (value) => (Number.isFinite(value) ? value : null));
}
