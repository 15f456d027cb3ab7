// Taught work: choose a cycle, play it, and teach one by driving.

import { make, makeButton, setText } from "../elements.js";
import { cyclesOf } from "../taught/cycles.js";
import { makeSegments } from "../taught/segments.js";
import { actionsIn, isBusy, progressText, stateText } from "../taught/words.js";

export const place = "left";
export const title = "Taught work";

const TEACHES = [["path", "Path from here"], ["pose", "Pose here"], ["close", "Grapple closes"], ["open", "Grapple opens"]]; // prettier-ignore

export function mount(element, station) {
  new TaughtWork(element, station, cyclesOf(station));
}

class TaughtWork {
  constructor(element, station, cycles) {
    Object.assign(this, { station, cycles, drives: false });
    this.state = make("p", { className: "state", role: "status" });
    this.progress = make("p", { className: "progress" });
    this.answer = make("p", { className: "answer", role: "status" });
    this.choice = make("select", { onchange: () => cycles.choose(this.choice.value) });
    this.choice.setAttribute("aria-label", "Cycle");
    this.buttons = make("div", { className: "line" });
    this.trouble = make("p", { className: "trouble" });
    this.segments = makeSegments((what, args) => this.#ask(what, args));
    this.work = make("div", {}, this.choice, this.buttons, this.trouble, this.segments.element, this.#teacher());
    element.append(this.state, this.progress, this.work, this.answer);
    station.on("seat", ({ you_drive: drives }) => {
      this.drives = drives;
      this.#show();
    });
    station.on("frame", () => setText(this.progress, progressText(this.#status())));
    for (const kind of ["told", "change"]) cycles.addEventListener(kind, () => this.#show());
    cycles.addEventListener("told", () => this.#forget());
    this.#show();
  }

  // The form in which a step is taught: at the end of a cycle, which may be a new one.
  #teacher() {
    this.cycle = make("input", { type: "text", placeholder: "cycle: new or known", maxLength: 64, spellcheck: false });
    this.label = make("input", { type: "text", placeholder: "name of the step", maxLength: 60 });
    this.cycle.setAttribute("aria-label", "Cycle that is taught");
    this.cycle.addEventListener("input", () => this.cycle.setCustomValidity(""));
    this.label.setAttribute("aria-label", "Name of the step");
    this.teaching = TEACHES.map(([what, text]) => makeButton(text, () => this.#teach(what)));
    return make("details", { className: "teach" }, make("summary", {}, "Teach by driving"), this.cycle, this.label,
      make("div", { className: "kinds" }, ...this.teaching));
  }

  async #teach(what) {
    const cycle = this.cycle.value.trim() || this.cycles.name;
    if (!cycle) return this.#askForName();
    const { ok } = await this.#ask("teach", { cycle, what, label: this.label.value });
    if (!ok) return null;
    this.label.value = this.cycle.value = "";
    return this.cycles.choose(cycle);
  }

  // At the field itself: below the buttons nobody would look.
  #askForName() {
    this.cycle.setCustomValidity("Name a cycle here, or choose one above.");
    this.cycle.reportValidity();
  }

  async #ask(what, args) {
    setText(this.answer, "");
    const answer = await this.cycles.ask(what, args);
    this.answer.dataset.ok = answer.ok;
    setText(this.answer, answer.text);
    return answer;
  }

  // What was answered is over when something else goes on: the state tells of that.
  #forget() {
    const { phase } = this.cycles.told;
    if (phase !== this.phase && phase !== "idle") setText(this.answer, "");
    this.phase = phase;
  }

  #status() {
    const value = (label) => this.station.value(`cycle/status/${label}`);
    return { way: value("way"), length: value("length"), away: value("away") };
  }

  #show() {
    const { told, cycle, trouble } = this.cycles;
    setText(this.state, stateText(told, this.station.signals.has("ground_truth/load/mass")));
    this.work.hidden = !told.there;
    this.#choose();
    this.#offer(actionsIn(told.phase));
    setText(this.trouble, trouble || cycle?.trouble || "");
    this.segments.show(cycle, told);
    for (const button of this.teaching) button.disabled = !this.drives || isBusy(told.phase);
  }

  #choose() {
    const { entries, name, told } = this.cycles;
    const options = ["", ...entries.map((entry) => entry.name)];
    if ([...this.choice.options].map(({ value }) => value).join("\n") !== options.join("\n")) {
      this.choice.replaceChildren(...options.map((value) => make("option", { value, textContent: value || "choose a cycle" })));
    }
    this.choice.value = options.includes(name) ? name : "";
    this.choice.disabled = isBusy(told.phase);
  }

  #offer(actions) {
    const texts = actions.map(({ text }) => text).join();
    if (texts !== this.offered) {
      this.buttons.replaceChildren(...actions.map(({ what, text }) => makeButton(text, () => this.#act(what))));
    }
    this.offered = texts; // a button that is replaced while it is pressed hears no click
    actions.forEach(({ what, drives }, i) => {
      this.buttons.children[i].disabled = (drives && !this.drives) || (what === "play_cycle" && !this.cycles.cycle);
    });
  }

  #act(what) {
    return this.#ask(what, what === "play_cycle" ? { cycle: this.cycles.name } : {});
  }
}
