"use strict";

const STATE_NAMES = ["fitted", "excluded by the project", "held out", "lifted", "standing", "warm-up", "transition", "outlier"];
const SIGNS = [["", "as the format states"], ["iso", "ISO"], ["sae", "SAE"], ["adapted-sae", "adapted SAE"]];
/** What a selection of rows does, and where the project file has it. */
const SELECTIONS = { exclude: ["data", "exclude", "Excluded"], hold_out: ["fit", "hold_out", "Held out"] };

/** The tables: columns, time histories, operating conditions, selected rows. */
class DataTab {
  constructor(studio) {
    this.studio = studio;
    this.opened = new Set();
    this.chart = new TimeChart(find("time-chart"), (first, last) => this.setRows(first, last));
    find("upload").addEventListener("change", (event) => this.upload([...event.target.files]));
    find("example").addEventListener("click", () => {
      studio.say("measuring the example");
      studio.edit("example", {});
    });
    const drop = find("drop");
    for (const [name, over] of [["dragover", true], ["dragleave", false], ["drop", false]]) {
      document.addEventListener(name, (event) => {
        event.preventDefault();
        drop.classList.toggle("over", over);
      });
    }
    document.addEventListener("drop", (event) => this.upload([...event.dataTransfer.files]));
    find("signs").addEventListener("change", (event) => studio.set("data", "signs", event.target.value || null));
    find("shown-table").addEventListener("change", () => this.showTable());
    find("shown-channel").addEventListener("change", () => this.showHistory());
    for (const id of ["first", "last"]) find(id).addEventListener("change", () => this.chart.mark(...this.rows()));
    for (const [id, how] of [["exclude", "exclude"], ["keep", "keep"], ["hold-out", "hold_out"]]) {
      find(id).addEventListener("click", () => this.select(how));
    }
  }

  async upload(files) {
    for (const file of files) {
      this.studio.say(`reading ${file.name}`);
      const answer = await fetch(`upload/${encodeURIComponent(file.name)}`, { method: "POST", body: file });
      const text = await answer.text();
      if (answer.ok) this.studio.say(`added: ${text}`);
      else this.studio.fail(text);
    }
    find("upload").value = "";
  }

  async refresh() {
    const { sections } = this.studio.state;
    fillChoice(find("signs"), SIGNS, sections.data?.signs ?? "");
    this.tables = sections.data?.tables?.length ? await this.studio.call("data") : [];
    find("first-steps").hidden = this.tables.length > 0;
    find("tables").replaceChildren(...this.tables.map((table, i) => this.tableCard(table, i)));
    const usable = this.tables.map((table, i) => [String(i), table.name]).filter(([i]) => !this.tables[i].error);
    find("history").hidden = !usable.length;
    const before = find("shown-table").value;
    fillChoice(find("shown-table"), usable, usable.some(([i]) => i === before) ? before : usable[0]?.[0]);
    this.showSelections();
    if (usable.length) await this.showTable();
  }

  tableCard(table, index) {
    const remove = element("button", { type: "button", "aria-label": `Remove ${table.name}` }, "Remove");
    remove.addEventListener("click", () => {
      const tables = this.studio.state.sections.data.tables.filter((_, i) => i !== index);
      this.studio.edit("tables", { tables });
    });
    const card = element("article", { class: "table" }, element("h2", {}, element("span", {}, table.name), remove));
    if (table.error) card.append(element("p", { class: "bad" }, table.error));
    for (const each of table.findings ?? []) card.append(element("p", { class: each.serious ? "bad" : "warning" }, each.text));
    for (const { text, keys } of table.corrections ?? []) {
      const apply = element("button", { type: "button", class: "first" }, `Read so: ${text}`);
      apply.addEventListener("click", () => this.studio.edit("correct", { keys }));
      card.append(element("p", {}, apply));
    }
    card.append(this.meanings(table));
    if (table.error) return card;
    const counts = Object.entries(table.counts).map(([state, rows]) => `${state}: ${rows}`).join(", ");
    card.append(element("p", {}, table.title), element("p", {}, counts));
    const columns = element("table");
    fillTable(columns, table.columns.header, table.columns.rows);
    const ignored = table.ignored.length ? [element("p", {}, `Columns that are not used: ${table.ignored.join(", ")}`)] : [];
    const wide = element("div", { class: "wide", tabindex: "0", role: "group", "aria-label": `Columns of ${table.name}` }, columns);
    card.append(element("details", {}, element("summary", {}, `Ranges of ${table.name}`), wide, ...ignored));
    return card;
  }

  /** Return the table of channels: what each was taken for, with column, sign and unit to correct. */
  meanings(table) {
    const shown = element("table", { class: "meanings" });
    const rows = table.meanings.map((each) => {
      const { channel, column, unit } = each;
      const source = element("input", { type: "text", value: column, placeholder: channel, "aria-label": `Column of ${channel} in ${table.name}` });
      const turn = element("button", { type: "button", "aria-label": `Other sign of ${channel} in ${table.name}`, "aria-pressed": String(column.startsWith("-")) }, "\u00b1");
      const units = element("select", { "aria-label": `Unit of ${channel} in ${table.name}` });
      fillChoice(units, ["", ...new Set([...each.units, ...(unit ? [unit] : [])])].map((name) => [name, name || "as read"]), unit);
      source.addEventListener("change", () => this.correct("columns", channel, source.value.trim()));
      turn.addEventListener("click", () => this.correct("columns", channel, column === `-${channel}` ? "" : column.startsWith("-") ? column.slice(1) : `-${column || channel}`));
      units.addEventListener("change", () => this.correct("units", channel, units.value));
      return [channel, each.taken_for, element("span", {}, source, " ", turn), units, each.evidence];
    });
    fillTable(shown, ["channel", "taken for", "column", "unit", "evidence"], rows);
    const wide = element("div", { class: "wide", tabindex: "0", role: "group", "aria-label": `Meaning of the columns of ${table.name}` }, shown);
    const note = element("p", { class: "note" }, "A correction is for all tables of the project. Column: its name in the file; none: it is not read.");
    const details = element("details", {}, element("summary", {}, `Columns of ${table.name}: what they were taken for`), note, wide);
    details.open = this.opened.has(table.name);
    details.addEventListener("toggle", () => this.opened[details.open ? "add" : "delete"](table.name));
    return details;
  }

  /** Set or remove the column or the unit of a channel in the project file. */
  correct(key, channel, value) {
    const { [channel]: _, ...others } = this.studio.state.sections.data?.[key] ?? {};
    const values = value ? { ...others, [channel]: value } : others;
    this.studio.edit("correct", { keys: { [key]: Object.keys(values).length ? values : null } });
  }

  async showTable() {
    const table = this.tables[find("shown-table").value];
    const before = find("shown-channel").value;
    const channels = table.channels.map((name) => [name, name]);
    fillChoice(find("shown-channel"), channels, table.channels.includes(before) ? before : table.channels.find((name) => name === "Fy") ?? table.channels[0]);
    find("states").replaceChildren(
      ...Object.entries(table.counts).map(([state, rows]) =>
        element("li", {}, element("span", { class: `swatch s${STATE_NAMES.indexOf(state)}`, "aria-hidden": "true" }), `${state} (${rows})`)),
    );
    this.showGrid(table);
    await this.showHistory();
  }

  async showHistory() {
    const [table, channel] = [Number(find("shown-table").value), find("shown-channel").value];
    this.chart.draw(channel, await this.studio.call("series", { table, channel }));
  }

  rows() {
    return ["first", "last"].map((id) => find(id).valueAsNumber);
  }

  setRows(first, last) {
    find("first").value = first;
    find("last").value = last;
  }

  select(how) {
    const [first, last] = this.rows();
    this.studio.edit("rows", { table: Number(find("shown-table").value), first, last, how });
  }

  /** Show the conditions: one table for each pressure, camber down, load across. */
  showGrid(table) {
    const label = (name, cell) => (cell.levels[name] === null || cell.levels[name] === undefined ? "all" : `${shortNumber(cell.levels[name])} ${cell.units[name]}`);
    const groups = Map.groupBy ? Map.groupBy(table.grid, (cell) => label("p", cell)) : new Map([["all", table.grid]]);
    const tables = [...groups].map(([pressure, cells]) => {
      const [loads, cambers] = ["Fz", "gamma"].map((name) => [...new Set(cells.map((cell) => label(name, cell)))]);
      const rows = cambers.map((camber) => [
        camber,
        ...loads.map((load) => cells.find((cell) => label("Fz", cell) === load && label("gamma", cell) === camber)),
      ]);
      const shown = element("table", {}, element("caption", { class: "note" }, `Pressure ${pressure}: camber down, load across`));
      const head = ["camber", ...loads].map((text) => element("th", { scope: "col" }, text));
      shown.append(
        element("thead", {}, element("tr", {}, ...head)),
        element("tbody", {}, ...rows.map(([camber, ...found]) =>
          element("tr", {}, element("th", { scope: "row" }, camber), ...found.map((cell, i) => element("td", {}, cell ? this.cellButton(cell, `${loads[i]}, camber ${camber}, pressure ${pressure}`) : "")))),
        ),
      );
      return element("div", { class: "wide", tabindex: "0", role: "group", "aria-label": `Conditions at pressure ${pressure}` }, shown);
    });
    find("grid").replaceChildren(...tables);
  }

  cellButton(cell, words) {
    const chosen = Object.keys(SELECTIONS).find((how) => this.listed(how).includes(cell.expression));
    const weights = this.studio.state.sections.fit?.weights ?? {};
    const weight = weights[cell.expression];
    const text = `${cell.fitted} / ${cell.rows}${weight === undefined ? "" : ` \u00d7 ${shortNumber(weight)}`}`;
    const button = element("button", { type: "button", "aria-pressed": String(Boolean(chosen)), "aria-label": `${words}: ${text} rows fitted` }, text);
    if (chosen === "hold_out") button.classList.add("held-out");
    button.addEventListener("click", () => {
      const how = chosen ?? document.querySelector('input[name="cell"]:checked').value;
      if (how === "weigh") {
        const { [cell.expression]: _, ...others } = weights;
        const changed = weight === undefined ? { ...others, [cell.expression]: find("factor").valueAsNumber } : others;
        this.studio.set("fit", "weights", Object.keys(changed).length ? changed : null);
        return;
      }
      const others = this.listed(how).filter((each) => each !== cell.expression);
      this.setListed(how, chosen ? others : [...others, cell.expression]);
    });
    return button;
  }

  listed(how) {
    const [section, key] = SELECTIONS[how];
    return this.studio.state.sections[section]?.[key] ?? [];
  }

  setListed(how, expressions) {
    const [section, key] = SELECTIONS[how];
    this.studio.set(section, key, expressions.length ? expressions : null);
  }

  showSelections() {
    const items = Object.keys(SELECTIONS).flatMap((how) =>
      this.listed(how).map((expression) => {
        const remove = element("button", { type: "button", "aria-label": `Remove: ${expression}` }, "Remove");
        remove.addEventListener("click", () => this.setListed(how, this.listed(how).filter((each) => each !== expression)));
        return element("li", {}, `${SELECTIONS[how][2]}: `, element("code", {}, expression), " ", remove);
      }),
    );
    find("selections").replaceChildren(...(items.length ? items : [element("li", {}, "none")]));
  }
}
