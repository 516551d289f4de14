"use strict";

/** Return the text of the .tir file of a tire, as tirefmu writes it. */
function propertyFile(tire) {
  const changes = tire.changes();
  const changed = new Set(changes.coefficients.map((each) => each.name));
  const absentAdded = tire.data.effects.filter((each) => each.added && !tire.on.has(each.name));
  const others = new Set([...tire.all].filter((name) => !absentAdded.some((each) => each.name === name)));
  const kept = tire.live(others);
  const contains = (name) => kept.has(name) || !tire.always.has(name);
  const lines = [];
  for (const line of tire.data.file) {
    if (typeof line === "string") lines.push(line);
    else if (line.coefficient) {
      const name = line.coefficient;
      if (contains(name)) lines.push(`${name} = ${tire.vector[name]}${line.rest}`);
    } else if (line.assumed) {
      const names = line.assumed.filter((name) => contains(name) && !changed.has(name));
      if (names.length) lines.push(`${line.title} = '${names.join(",")}'`);
    } else if (line.effects) lines.push(...effectLines(tire));
    else if (line.changes) lines.push(`CHANGED = '${changeText(changes) || "nothing"}'`);
  }
  return `${lines.join("\n")}\n`;
}

/** Return the entries that depend on the effects: their names, and coefficients that an absent effect rescales. */
function effectLines(tire) {
  const lines = [`EFFECTS = '${tire.data.effects.filter((each) => tire.on.has(each.name)).map((each) => each.name).join(",")}'`];
  for (const each of tire.data.effects) {
    if (!tire.on.has(each.name)) for (const [name] of each.rescales) lines.push(`CORE_${name} = ${tire.values.get(name)}`);
  }
  return lines;
}

/** Return a list of the changes, for the file and the status line. */
function changeText(changes) {
  return [...changes.coefficients, ...changes.effects].map((each) => each.name).join(", ");
}

/** Let the browser save a text as a file. */
function saveFile(name, text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/plain" }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
