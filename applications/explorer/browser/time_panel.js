"use strict";

/** Time constants of the slowest state that a response lasts by default, and the limits of its duration, s. */
const TIME_CONSTANTS = 5;
const SHORTEST = 0.01;
const LONGEST = 3600;

/** The response of tires to a step or a sweep of one input: controls, a chart for each force and each state. */
class TimePanel {
  /**
   * @param {object} found elements: section, input, kind, from, to, unit, duration, host
   * @param {object} tires now, loaded, other (or null)
   * @param {function(): object} selected the inputs of the sliders
   * @param {function(): void} changed
   */
  constructor(found, tires, selected, changed) {
    this.found = found;
    this.tires = tires;
    this.selected = selected;
    const { data } = tires.now;
    this.states = [...data.lags, ...data.states.filter((each) => each.effects.length)];
    this.exists = this.states.length > 0;
    found.section.hidden = !this.exists;
    if (!this.exists) return;
    this.inputs = data.inputs.filter((each) => !data.states.some(({ name }) => name === each.name));
    for (const { name } of this.inputs) found.input.append(element("option", { value: name }, name));
    for (const kind of COURSES) {
      const radio = element("input", { type: "radio", name: "course", id: `course-${kind}`, value: kind });
      radio.addEventListener("change", () => this.change({ kind }, changed));
      found.kind.append(element("label", { class: "check", for: radio.id }, radio, ` ${kind}`));
    }
    found.input.addEventListener("change", () => this.change(this.initial(found.input.value), changed));
    for (const end of ["from", "to"]) {
      this.onNumber(found[end], (value) => this.change({ [end]: entered(this.input, value) }, changed));
    }
    this.onNumber(found.duration, (value) => this.change({ duration: clipped(value) }, changed));
    this.build();
    this.reset();
  }

  onNumber(field, take) {
    field.addEventListener("change", () => {
      if (Number.isFinite(field.valueAsNumber)) take(field.valueAsNumber);
      else this.show();
    });
  }

  get input() {
    return this.inputs.find((each) => each.name === this.course.input);
  }

  /** Return the course of an input without a choice: from its nominal value half the way to the end of its range. */
  initial(name) {
    const { nominal, high } = this.inputs.find((each) => each.name === name);
    return { input: name, from: nominal, to: nominal + (high - nominal) / 2 };
  }

  reset() {
    if (!this.exists) return;
    this.course = { ...this.initial("alpha"), kind: COURSES[0], duration: 0 };
  }

  change(values, changed) {
    Object.assign(this.course, values);
    this.show();
    changed();
  }

  show() {
    if (!this.exists) return;
    const { input, kind, from, to } = this.course;
    this.found.input.value = input;
    for (const radio of document.getElementsByName("course")) radio.checked = radio.value === kind;
    this.found.from.value = Number(displayed(this.input, from).toPrecision(7));
    this.found.to.value = Number(displayed(this.input, to).toPrecision(7));
    this.found.unit.textContent = this.input.unit;
    this.found.duration.value = this.duration();
  }

  /** Return the selected duration, or one in which the slowest state settles. */
  duration() {
    if (this.course.duration) return this.course.duration;
    const { now } = this.tires;
    const inputs = { ...inputsOf(now, this.selected()), [this.course.input]: this.course.to };
    const rates = now.rates(inputs, now.statesAtStart(inputs));
    const decays = Object.keys(rates).filter((key) => key.endsWith("_decay")).map((key) => rates[key]);
    const slowest = Math.min(...decays.filter((decay) => decay > 0));
    return clipped(Number.isFinite(slowest) ? Number((TIME_CONSTANTS / slowest).toPrecision(1)) : 1);
  }

  build() {
    const { data } = this.tires.now;
    const axes = (each) => ({ xTitle: "t (s)", yTitle: each.unit ? `${each.name} (${each.unit})` : each.name });
    const chart = (each) => new Chart(this.found.host, { title: `${each.name} over time: ${each.text}`, ...axes(each) });
    const alone = (kind) => (each) => ({ name: each.name, kind, members: [each.name], chart: chart(each) });
    const nodes = this.states.filter((each) => each.temperature);
    const together = { name: "temperature", text: "of each part of the tire", unit: nodes[0]?.unit };
    this.charts = [
      ...data.outputs.map(alone("forces")),
      ...(nodes.length ? [{ ...alone("states")(together), members: nodes.map((each) => each.name) }] : []),
      ...this.states.filter((each) => !each.temperature).map(alone("states")),
    ];
  }

  /** Compute the responses and draw them; a chart of a state that no tire has, or of a force of 0, is hidden. */
  draw() {
    if (!this.exists) return;
    const course = { ...this.course, duration: this.duration() };
    const shown = Object.entries({ loaded: this.tires.loaded, other: this.tires.other, now: this.tires.now })
      .filter(([, tire]) => tire?.data.inputs.some((each) => each.name === course.input))
      .map(([style, tire]) => [style, tire, timeResponse(tire, this.selected(), course)]);
    for (const { kind, members, chart } of this.charts) {
      const curves = [];
      for (const [style, tire, response] of shown) {
        const label = { loaded: "as loaded", other: tire.data.name, now: "this tire" }[style];
        members.forEach((name, i) => {
          const zero = this.states.find((each) => each.name === name)?.zero ?? 0;
          const y = response[kind].map((each) => each[name] - zero);
          const own = members.length > 1 ? { label: `${name}, ${label}`, color: LOAD_COLORS[i] } : { label };
          if (Number.isFinite(y[0])) curves.push({ ...own, style, x: response.t, y });
        });
        if (kind === "forces" && style === "now") {
          curves.unshift({ label: "in steady state", style: "steady", x: response.t, y: response.steady.map((each) => each[members[0]]) });
        }
      }
      chart.figure.hidden = !curves.length || (kind === "forces" && curves.every(({ y }) => y.every((value) => !value)));
      if (curves.length) chart.draw(curves);
      chart.describe();
    }
  }

  /** Take a width for all charts, or with 0 that of the page. */
  fit(width) {
    for (const { chart } of this.charts ?? []) chart.fit(width);
  }

  /** Return the choices as a text for the address of the page; empty if there are none. */
  text() {
    if (!this.exists) return "";
    const { input, kind, from, to, duration } = this.course;
    const plain = this.initial(input);
    const changed = input !== "alpha" || kind !== COURSES[0] || duration || from !== plain.from || to !== plain.to;
    return changed ? [input, kind, from, to, duration].join(" ") : "";
  }

  /** Take the choices from a text; one that is not complete is ignored. */
  read(text) {
    this.reset();
    const [name, kind, ...numbers] = (text ?? "").split(" ");
    const [from, to, duration] = numbers.map(Number);
    if (!this.exists || !this.inputs.some((each) => each.name === name) || !COURSES.includes(kind)) return;
    if (numbers.length !== 3 || ![from, to, duration].every(Number.isFinite)) return;
    this.course = { input: name, kind, from, to, duration: duration && clipped(duration) };
  }
}

function clipped(duration) {
  return Math.min(Math.max(duration, SHORTEST), LONGEST);
}
