// SPDX-License-Identifier: Apache-2.0
// A column over two axes: cells of a grid with the other axes held, points where designs are sampled.

const map = { x: numericAxes[0], y: numericAxes[1], value: asked.find((column) => column.role !== "axis") ?? asked[0], held: new Map() };
const isGrid = report.method === "grid" && report.every === 1;

// Labels of a legend over `domain`, which say at its ends where values beyond have the same colour.
function clippedLegend(values, [low, high]) {
  if (!(high > low)) return { format: ".6~g" };
  const numbers = values.filter((v) => typeof v === "number");
  const below = numbers.some((v) => v < low), above = numbers.some((v) => v > high);
  return { values: [0, 1, 2, 3, 4].map((i) => low + (high - low) * i / 4),
    labelExpr: `format(datum.value, '.5~g') + (${below} && datum.index === 0 ? ' and below' : ${above} && datum.index === 4 ? ' and above' : '')` };
}

function mapSpec() {
  const { x, y, value } = map;
  // Colours are for designs that count: those that are not feasible may be far off.
  const counted = (rows.some((row) => row.feasible) ? rows.filter((row) => row.feasible) : rows).map((row) => row[value.field]).filter((v) => typeof v === "number");
  const domain = counted.reduce(([low, high], v) => [Math.min(low, v), Math.max(high, v)], [Infinity, -Infinity]);
  const here = isGrid ? rows.filter((row) => [...map.held].every(([index, level]) => String(row[`c${index}`]) === level)) : rows;
  const colour = { field: value.field, type: "quantitative", title: value.label, scale: { scheme: "viridis", zero: false, clamp: true, ...(domain[1] > domain[0] ? { domain } : {}) }, legend: { gradientLength: 300, ...clippedLegend(here.map((row) => row[value.field]), domain) } };
  const fade = { condition: { test: "datum.feasible", value: 1 }, value: 0.35 };
  if (!isGrid)
    return { marks: here.length, spec: { width: "container", height: 400, data: { values: here.filter((row) => row[value.field] !== null) },
      mark: { type: "circle", size: 34, stroke: colourOf("--soft"), strokeWidth: 0.4, tooltip: hoverDesign }, encoding: { x: quantity(x, { scale: { type: x.scale === "log" ? "log" : "linear" } }), y: quantity(y, { scale: { type: y.scale === "log" ? "log" : "linear" } }), color: colour, opacity: fade } } };
  const level = (column) => ({ field: column.field, type: "ordinal", title: column.label, axis: { labelExpr: "format(datum.value, '.4~g')", labelOverlap: "parity", labelSeparation: 4, labelAngle: 0, ticks: false, domain: false } });
  const encoding = { x: level(x), y: { ...level(y), sort: "descending" } };
  return { marks: here.length, spec: { width: "container", height: 400,
    datasets: { here: here.filter((row) => row[value.field] !== null), chosen: here.filter((row) => row.chosen) },
    layer: [
      { data: { name: "here" }, mark: { type: "rect", tooltip: hoverDesign }, encoding: { ...encoding, color: colour, opacity: fade } },
      ...(here.some((row) => row.chosen) ? [{ data: { name: "chosen" }, mark: { type: "point", shape: "diamond", size: 90, filled: true, fill: "#ffffff", stroke: "#111111", strokeWidth: 1.2, opacity: 1, tooltip: hoverDesign }, encoding },
      { data: { name: "chosen" }, mark: { type: "text", dy: -11, fontSize: 11, fontWeight: 700, color: "#ffffff", stroke: "#111111", strokeWidth: 2.4, strokeJoin: "round" }, encoding: { ...encoding, text: { field: "design" } } },
      { data: { name: "chosen" }, mark: { type: "text", dy: -11, fontSize: 11, fontWeight: 700, color: "#ffffff", tooltip: false }, encoding: { ...encoding, text: { field: "design" } } }] : []),
    ] } };
}

async function drawMap() {
  const { spec, marks } = mapSpec();
  await draw("map", spec, marks, `${map.value.label} over ${map.x.label} and ${map.y.label}`);
}

function addHeld() {
  const controls = document.querySelector("#map .controls");
  for (const old of controls.querySelectorAll("label.held")) old.remove();
  map.held.clear();
  if (!isGrid) return;
  const best = rows.find((row) => row.design === report.best[0]) ?? rows[0];
  for (const axis of axes.filter((one) => one.index !== map.x.index && one.index !== map.y.index)) {
    const levels = [...new Set(rows.map((row) => row[axis.field]))];
    map.held.set(axis.index, String(best[axis.field]));
    addChoice("map", axis.label, levels.map((level) => [level, shown(level)]), best[axis.field], (value) => { map.held.set(axis.index, value); drawMap(); })
      .parentElement.classList.add("held");
  }
}

async function startMaps() {
  if (numericAxes.length < 2) return;
  const choose = (key, other) => (value) => {
    const wanted = numericAxes.find((axis) => axis.index === Number(value));
    if (wanted.index === map[other].index) { map[other] = map[key]; selects[other].value = map[other].index; }
    map[key] = wanted;
    addHeld();
    drawMap();
  };
  const selects = {
    x: addChoice("map", "across", columnChoices(numericAxes), map.x.index, choose("x", "y")),
    y: addChoice("map", "up", columnChoices(numericAxes), map.y.index, choose("y", "x")),
  };
  addChoice("map", "shown", columnChoices(asked), map.value.index, (value) => { map.value = columns[Number(value)]; drawMap(); });
  const hint = document.createElement("small");
  hint.textContent = "Faint: not feasible. Diamonds: chosen.";
  document.querySelector("#map .controls").append(hint);
  addHeld();
  await drawMap();
}
