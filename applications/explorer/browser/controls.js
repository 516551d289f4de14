"use strict";

/** Return an element with attributes, properties of `dataset`, and children or text. */
function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/** Return the SI value of an input in the unit of its slider. */
function displayed({ scale, zero }, value) {
  return (value - zero) * scale;
}

/** Return the SI value of an input from that of its slider. */
function entered({ scale, zero }, value) {
  return value / scale + zero;
}

/** A number that is changed by a slider, a field or a reset button. */
class SliderRow {
  /**
   * @param {object} spec id, label, unit, text, lower, upper, value, marks
   * @param {function(number): void} changed
   */
  constructor(spec, changed) {
    this.spec = spec;
    const unit = spec.unit ? ` ${spec.unit}` : "";
    const words = `${spec.label}, ${spec.text}${unit}`;
    this.slider = element("input", {
      type: "range", id: `slider-${spec.id}`, min: spec.lower, max: spec.upper, step: "any", "aria-label": words,
    });
    this.field = element("input", { type: "number", id: `field-${spec.id}`, step: "any" });
    this.button = element("button", { type: "button", "aria-label": `Reset ${spec.label}`, title: "Reset" }, "\u21ba");
    const label = element("label", { for: this.field.id }, spec.label);
    this.marks = marksOf(spec);
    this.row = element(
      "div", { class: "row" },
      element("div", { class: "head" }, label, this.field, element("span", { class: "unit" }, spec.unit), this.button),
      this.slider,
      this.marks,
      element("p", { class: "text" }, spec.text, ...boundsText(spec)),
    );
    this.slider.addEventListener("input", () => this.change(this.slider.valueAsNumber, changed));
    this.field.addEventListener("change", () => {
      if (Number.isFinite(this.field.valueAsNumber)) this.change(this.field.valueAsNumber, changed);
      else this.show(this.value);
    });
    this.button.addEventListener("click", () => this.change(this.spec.value, changed));
    this.row.classList.toggle("unmeasured", spec.measured === false);
    this.show(spec.value);
  }

  change(value, changed) {
    this.show(value);
    changed(value);
  }

  show(value) {
    this.value = value;
    this.slider.value = value;
    this.slider.setAttribute("aria-valuetext", `${shortNumber(value)} ${this.spec.unit}`.trim());
    this.field.value = Number(value.toPrecision(7));
    this.button.disabled = !this.changed;
    this.row.classList.toggle("changed", this.changed);
  }

  get changed() {
    return this.value !== this.spec.value;
  }

  /** Set the value that is no change: its mark moves, and reset returns to it. */
  markAsUnchanged(value) {
    this.spec = { ...this.spec, value };
    const marks = marksOf(this.spec);
    this.marks.replaceWith(marks);
    this.marks = marks;
  }
}

/** Return the scale under a slider: the 95 % interval as a band, the loaded and the compared value as marks. */
function marksOf({ lower, upper, value, interval = [], other }) {
  const at = (x) => `${Math.min(Math.max((100 * (x - lower)) / (upper - lower || 1), 0), 100)}%`;
  const marks = element("div", { class: "marks", "aria-hidden": "true" });
  if (interval.length === 2) {
    const band = element("span", { class: "band" });
    band.style.left = at(interval[0]);
    band.style.right = `calc(100% - ${at(interval[1])})`;
    marks.append(band);
  }
  for (const [kind, x] of [["tick", value], ["tick other", other]]) {
    if (x === undefined) continue;
    const tick = element("span", { class: kind });
    tick.style.left = at(x);
    marks.append(tick);
  }
  return marks;
}

function boundsText({ lower, upper, interval = [], other, otherName }) {
  const parts = [` (${shortNumber(lower)} to ${shortNumber(upper)}).`];
  if (interval.length === 2) parts.push(` 95 % interval ${interval.map(shortNumber).join(" to ")}.`);
  if (other !== undefined) parts.push(` ${otherName}: ${shortNumber(other)}.`);
  return parts;
}

/** The coefficients of a tire: one group for the core, one for each effect, with a switch. `changed` draws. */
class CoefficientPanel {
  constructor(host, tire, other, changed) {
    this.tire = tire;
    this.rows = new Map();
    this.boxes = new Map();
    this.groups = [];
    const others = new Map(other ? other.data.coefficients.map((each) => [each.name, each.value]) : []);
    const shown = tire.data.coefficients.filter((each) => each.read);
    const make = (each) => {
      const spec = { id: each.name, label: each.name, ...each, other: others.get(each.name), otherName: other?.data.name };
      const row = new SliderRow(spec, (value) => {
        tire.set(each.name, value);
        changed();
      });
      row.words = `${each.name} ${each.text} ${each.owner}`.toLowerCase();
      this.rows.set(each.name, row);
      return row.row;
    };
    host.append(this.core(shown.filter((each) => each.owner === "core"), make));
    for (const effect of tire.data.effects) {
      const own = shown.filter((each) => each.owner === effect.name);
      host.append(this.effect(effect, own, make, changed));
    }
  }

  core(coefficients, make) {
    const details = element("details", { open: "" }, element("summary", {}, "Core"));
    const groups = [...new Set(coefficients.map((each) => each.group))];
    groups.sort((a, b) => (a.length > 2) - (b.length > 2)); // channels first, sections of scale factors last
    for (const group of groups) {
      const rows = coefficients.filter((each) => each.group === group).map(make);
      details.append(element("h3", {}, group.toLowerCase() === group || group.length <= 2 ? group : sentence(group)), ...rows);
    }
    this.groups.push(details);
    return details;
  }

  effect(effect, coefficients, make, changed) {
    const box = element("input", { type: "checkbox", id: `effect-${effect.name}` });
    box.addEventListener("change", () => {
      this.tire.switch(effect.name, box.checked);
      this.show();
      changed();
    });
    this.boxes.set(effect.name, box);
    const label = element("label", { class: "check", for: box.id }, box, ` ${effect.name}`);
    const text = element("p", { class: "text" }, effect.text);
    const group = element("div", { class: "effect" }, label, text);
    if (coefficients.length) {
      const count = coefficients.length === 1 ? "1 coefficient" : `${coefficients.length} coefficients`;
      const summary = element("summary", {}, `${count} of ${effect.name}`);
      const channels = [...new Set(coefficients.map((each) => each.group))];
      const details = element("details", {}, summary);
      for (const channel of channels) {
        const rows = coefficients.filter((each) => each.group === channel).map(make);
        details.append(element("h3", {}, channel.length <= 2 ? channel : sentence(channel)), ...rows);
      }
      group.append(details);
      this.groups.push(details);
    }
    return group;
  }

  /** Show the state of the tire; coefficients of absent effects are disabled. */
  show() {
    for (const [name, row] of this.rows) {
      row.show(this.tire.values.get(name));
      const idle = this.tire.idle.has(name);
      row.row.classList.toggle("idle", idle);
      row.slider.disabled = idle;
      row.field.disabled = idle;
    }
    for (const [name, box] of this.boxes) box.checked = this.tire.on.has(name);
  }

  /** Show only coefficients that contain a text, or that were changed; without a filter all. */
  filter(text, changedOnly) {
    const wanted = text.trim().toLowerCase();
    const active = Boolean(wanted) || changedOnly;
    for (const row of this.rows.values()) {
      const visible = row.words.includes(wanted) && (!changedOnly || row.row.classList.contains("changed"));
      row.row.hidden = !visible;
    }
    for (const details of this.groups) {
      const found = [...details.querySelectorAll(".row")].some((each) => !each.hidden);
      const box = details.parentElement.classList.contains("effect") ? details.parentElement : details;
      box.hidden = active && !found;
      for (const heading of details.querySelectorAll("h3")) heading.hidden = active;
      if (active && found) details.open = true;
    }
  }
}

function sentence(section) {
  const words = section.replaceAll("_", " ").toLowerCase();
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** Fill a table; the first cell of a row is its heading. */
function fillTable(table, head, rows) {
  const cells = (tag, row) => row.map((cell, i) => element(tag === "td" && i === 0 ? "th" : tag, tag === "th" ? { scope: "col" } : i ? {} : { scope: "row" }, cell));
  table.replaceChildren(
    element("thead", {}, element("tr", {}, ...cells("th", head))),
    element("tbody", {}, ...rows.map((row) => element("tr", {}, ...cells("td", row)))),
  );
}
