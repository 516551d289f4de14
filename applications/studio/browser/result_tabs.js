"use strict";

const FMI = [["3", "3.0"], ["2", "2.0"]];
const EXPORT_STEPS = ["export", "convert", "generate", "check", "explore", "inspect"];
const INPUTS = ["slip", "wheel", "hub", "hub-torque"].map((name) => [name, name]);

/** Return the card of a step: what it found, and its files. */
function stepCard(step) {
  const rating = step.rating ?? "";
  const card = element("section", { class: `step ${rating}` });
  const title = element("h2", {}, `${step.name.charAt(0).toUpperCase()}${step.name.slice(1)}: `);
  title.append(element("span", { class: rating }, step.status === null ? "not up to date" : step.headline));
  card.append(title);
  if (step.status === null) return card;
  card.append(element("ul", {}, ...step.summary.map((line) => element("li", {}, line))));
  const links = step.files.map((file) => {
    const address = `results/${file.split("/").map(encodeURIComponent).join("/")}`;
    return element("li", {}, element("a", { href: address, target: "_blank", rel: "noopener" }, file));
  });
  card.append(element("ul", { class: "links" }, ...links));
  return card;
}

/** Export and check. */
class ExportTab {
  constructor(studio) {
    this.studio = studio;
    find("fmi").addEventListener("change", (event) => studio.set("export", "fmi", event.target.value));
    find("inputs").addEventListener("change", (event) => studio.set("export", "inputs", event.target.value));
    find("tolerance").addEventListener("change", (event) => {
      const value = event.target.valueAsNumber;
      studio.set("check", "tolerance", Number.isFinite(value) ? value : null);
    });
    find("run-export").addEventListener("click", () => studio.run(EXPORT_STEPS.filter((name) => studio.state.steps.some((step) => step.command === name))));
  }

  async refresh() {
    const { sections, steps } = this.studio.state;
    fillChoice(find("fmi"), FMI, sections.export?.fmi ?? "3");
    fillChoice(find("inputs"), INPUTS, sections.export?.inputs ?? "slip");
    find("tolerance").value = sections.check?.tolerance ?? "";
    find("run-export").disabled = this.studio.running || !steps.length;
    const { exports } = await this.studio.call("choices");
    for (const [key, names] of Object.entries(exports)) find(`export-${key}`).replaceChildren(...names.map((name) => this.box(key, name)));
    find("results").replaceChildren(...steps.filter((each) => each.command !== "diagnose").map(stepCard));
  }

  /** Return the box of a program or language of a list of [export]. */
  box(key, name) {
    const chosen = this.studio.state.sections.export?.[key] ?? [];
    const box = element("input", { type: "checkbox", id: `${key}-${name}` });
    box.checked = chosen.includes(name);
    box.addEventListener("change", () => {
      const names = box.checked ? [...chosen, name] : chosen.filter((each) => each !== name);
      this.studio.set("export", key, names.length ? names : null);
    });
    return element("label", { class: "check" }, box, ` ${name}`);
  }
}

/** The diagnosis: which effect the tire lacks, and whether it is added. */
class DiagnoseTab {
  constructor(studio) {
    this.studio = studio;
    find("run-diagnose").addEventListener("click", () => studio.run(["diagnose"]));
  }

  async refresh() {
    const steps = this.studio.state.steps.filter((each) => each.command === "diagnose");
    find("run-diagnose").disabled = this.studio.running || !steps.length;
    find("answers").replaceChildren(...steps.map((step) => {
      const card = stepCard(step);
      for (const effect of step.found ?? []) card.append(this.choice(effect));
      return card;
    }));
  }

  choice(effect) {
    const accept = element("button", { type: "button", class: "first" }, `Add ${effect} and fit again`);
    const reject = element("button", { type: "button" }, `Reject ${effect}`);
    accept.addEventListener("click", async () => {
      const choices = await this.studio.call("choices");
      const present = this.studio.state.sections.fit?.effects ?? choices.default;
      if (await this.studio.set("fit", "effects", [...new Set([...present, effect])])) this.studio.run(["fit"]);
    });
    reject.addEventListener("click", () => this.studio.edit("reject", { effect }));
    return element("p", {}, accept, " ", reject);
  }
}
