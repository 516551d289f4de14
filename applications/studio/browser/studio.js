"use strict";

const TABS = ["data", "fit", "compare", "diagnose", "export"];

/** The window: the state of the project as the server reports it, and the tab that shows it. */
class Studio {
  constructor() {
    this.tab = "data";
    this.state = null;
    this.tabs = { data: new DataTab(this), fit: new FitTab(this), compare: new CompareTab(this), diagnose: new DiagnoseTab(this), export: new ExportTab(this) };
    TABS.forEach((name, i) => {
      const button = find(`tab-${name}`);
      button.addEventListener("click", () => this.show(name));
      button.addEventListener("keydown", (event) => {
        const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
        if (step) this.show(TABS[(i + step + TABS.length) % TABS.length], true);
      });
    });
    find("undo").addEventListener("click", () => this.edit("undo"));
    find("stop").addEventListener("click", () => this.attempt(this.call("stop")));
    this.connection = new Connection((event) => this.receive(event), () => this.refresh(), () => this.fail("The server is not connected; the project is saved."));
    this.show("data");
  }

  get running() {
    return Boolean(this.state?.work.running);
  }

  call(name, content) {
    return this.connection.call(name, content);
  }

  say(text) {
    find("message").textContent = "";
    find("status").textContent = text;
  }

  fail(text) {
    find("message").textContent = text;
  }

  /** Wait for an answer; show its error. Returns whether there was none. */
  async attempt(promise) {
    try {
      await promise;
      find("message").textContent = "";
      return true;
    } catch (error) {
      this.fail(error.message);
      if (error.stale) await this.refresh(true);
      return false;
    }
  }

  /** Change the project; the change was made to the state that is shown. */
  async edit(name, content = {}) {
    const changed = await this.attempt(this.call(name, { ...content, version: this.state.version }));
    if (changed) await this.refresh();
    return changed;
  }

  set(section, key, value) {
    return this.edit("set", { section, key, value });
  }

  async run(steps) {
    if (await this.attempt(this.call("run", { steps }))) this.tabs.fit.moved = performance.now();
  }

  show(name, focus = false) {
    this.tab = name;
    for (const each of TABS) {
      const button = find(`tab-${each}`);
      button.setAttribute("aria-selected", String(each === name));
      button.tabIndex = each === name ? 0 : -1;
      find(each).hidden = each !== name;
    }
    if (focus) find(`tab-${name}`).focus();
    if (this.state) this.attempt(this.tabs[name].refresh());
  }

  /** Take the state of the project; while one refresh runs, one more waits. */
  async refresh(keepMessage = false) {
    if (this.refreshing) {
      this.again = true;
      return;
    }
    this.refreshing = true;
    try {
      this.state = await this.call("state");
      find("subtitle").textContent = this.state.folder;
      find("undo").disabled = !this.state.undoable;
      this.showWork();
      await this.tabs[this.tab].refresh();
      if (keepMessage !== true && find("message").textContent.startsWith("The server")) find("message").textContent = "";
    } catch (error) {
      this.fail(error.message);
    }
    this.refreshing = false;
    if (this.again) {
      this.again = false;
      await this.refresh(keepMessage);
    }
  }

  showWork() {
    const { running, title, lines } = this.state.work;
    find("stop").disabled = !running;
    const text = running ? `${title}: ${lines.at(-1) ?? "begins"}` : "";
    find("work").textContent = text;
    find("work").title = text;
  }

  receive(event) {
    if (event.event === "line") {
      if (this.state) this.state.work.lines.push(event.line);
      if (this.running) this.showWork();
    } else if (event.event === "started") {
      if (this.state) Object.assign(this.state.work, { running: true, title: event.title, lines: [] });
      this.refresh();
      if (this.tab === "fit" && event.title.includes("fit")) this.attempt(this.tabs.fit.showTire("live"));
    } else if (event.event === "stage") {
      if (this.tab === "fit") this.attempt(this.tabs.fit.showTire("live"));
    } else if (event.event === "ended") {
      if (event.message) this.fail(`${event.title}: ${event.message}`);
      else this.say(`${event.title}: done`);
      this.refresh();
    } else {
      this.refresh();
    }
  }
}

const studio = new Studio();
