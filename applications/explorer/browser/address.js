"use strict";

/** Write the state of the page to its address: coefficients, effects, inputs and choices that differ. */
function writeHash() {
  const state = new URLSearchParams();
  const changes = now.changes();
  for (const each of changes.coefficients) state.set(each.name, now.values.get(each.name));
  for (const each of changes.effects) state.set(`effect.${each.name}`, now.on.has(each.name) ? "on" : "off");
  for (const [name, row] of inputRows) if (row.changed) state.set(`input.${name}`, view.inputs[name]);
  if (view.over !== (measured.conditions[view.condition]?.slip || "alpha")) state.set("over", view.over);
  if (view.family !== familyAtFirst()) state.set("loads", view.family ? "5" : "1");
  if (view.condition) state.set("condition", view.condition);
  if (timePanel.text()) state.set("time", timePanel.text());
  const hash = `#${state}`;
  if (hash !== location.hash && !(hash === "#" && !location.hash)) history.replaceState(null, "", hash);
}

/** Read the state of the page from its address; what is unknown or no number is ignored. */
function readHash() {
  now.reset();
  const state = new URLSearchParams(location.hash.slice(1));
  const number = (text) => (text !== null && text.trim() !== "" && Number.isFinite(Number(text)) ? Number(text) : undefined);
  view.condition = Math.min(Math.max(Math.trunc(number(state.get("condition")) ?? 0), 0), Math.max(measured.conditions.length - 1, 0));
  view.over = measured.conditions[view.condition]?.slip || view.over;
  resetInputs();
  for (const [key, text] of state) {
    const value = number(text);
    if (now.values.has(key) && value !== undefined) now.values.set(key, value);
    const [kind, name] = key.split(".");
    if (kind === "input" && name in view.inputs && value !== undefined) view.inputs[name] = value;
    if (kind === "effect" && now.all.has(name)) text === "on" ? now.on.add(name) : now.on.delete(name);
  }
  now.update();
  const slips = now.data.inputs.map((each) => each.name);
  view.over = ["alpha", "kappa"].includes(state.get("over")) && slips.includes(state.get("over")) ? state.get("over") : view.over;
  view.family = familyAtFirst() ? state.get("loads") !== "1" : state.get("loads") === "5";
  timePanel.read(state.get("time"));
}
