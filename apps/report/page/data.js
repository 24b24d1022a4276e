// SPDX-License-Identifier: Apache-2.0
// What the page holds, as rows that charts read. Names of columns may be anything, so fields are called c0, c1, ...
"use strict";

const report = JSON.parse(document.getElementById("data").textContent);
const columns = report.columns.map((column, index) => ({
  ...column,
  index,
  field: `c${index}`,
  label: column.unit ? `${column.name} (${column.unit})` : column.name,
  discrete: column.levels.length > 0 && report.cells[index].some((v) => typeof v === "string"),
}));
const columnOf = (name) => columns.find((column) => column.name === name);

const front = new Set(report.pareto);
const chosenDesigns = new Set(report.chosen.map((one) => one.design));
const feasibleColumn = columns.find((column) => column.role === "feasible");

const rows = report.design.map((design, i) => {
  const row = { design, front: front.has(design), chosen: chosenDesigns.has(design), feasible: true };
  for (const column of columns) row[column.field] = report.cells[column.index][i];
  if (feasibleColumn) row.feasible = row[feasibleColumn.field] !== 0;
  return row;
});

// Numbers that differ between designs: what a chart can show.
const numeric = columns.filter((column) => !["feasible", "pareto"].includes(column.role) && !column.gap && !column.discrete &&
  report.cells[column.index].some((v) => typeof v === "number"));
const axes = report.axes.map((axis) => ({ ...axis, ...columnOf(axis.column) }));
const objectives = report.objectives.map((objective) => ({ ...objective, ...columnOf(objective.column), text: objective.text }));
const numericAxes = axes.filter((axis) => !axis.discrete && numeric.some((column) => column.index === axis.index));

// Objectives, then metrics, then the rest: the order in which people ask.
const asked = [...new Map([...objectives.filter((o) => numeric.some((c) => c.index === o.index)),
  ...numeric.filter((c) => c.role === "metric"), ...numericAxes, ...numeric].map((c) => [c.index, columns[c.index]])).values()];

const palette = ["--s0", "--s1", "--s2", "--s3", "--s4", "--s5", "--s6", "--s7"];
const colourOf = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const designColour = (design) => colourOf(palette[report.chosen.findIndex((one) => one.design === design) % palette.length]);
const shown = (value) => (typeof value === "number" ? String(Number(value.toPrecision(5))) : value === null ? "–" : String(value));
