// SPDX-License-Identifier: Apache-2.0
// A column over two axes: cells of a grid with the other axes held, points where designs are sampled.

const map = { x: numericAxes[0], y: numericAxes[1], value: asked.find((column) => column.role !== "axis") ?? asked[0], held: new Map() };
const isGrid = report.method === "grid" && report.every === 1;

// The limits of constraints on one column, as borders between a cell that keeps the limit and a neighbour that does not.
const drawnLimits = report.constraints.filter((one) => one.relation);
function limitBorders(here, { x, y }) {
  const levels = ({ field }) => [...new Set(here.map((row) => row[field]))].sort((a, b) => a - b);
  const across = levels(x), up = levels(y);
  const cells = new Map(here.map((row) => [`${row[x.field]} ${row[y.field]}`, row]));
  return drawnLimits.flatMap(({ text, columns: [name], limit, relation }) => {
    const { field } = columnOf(name);
    // Equal within the rounding of units is equal.
    const keeps = (row) => (Math.abs(row[field] - limit) <= 1e-9 * Math.abs(limit) ? relation.endsWith("=") : (row[field] < limit) === relation.startsWith("<"));
    const borders = [];
    across.forEach((a, i) => up.forEach((b, j) => {
      const row = cells.get(`${a} ${b}`);
      for (const [side, other] of [["right", cells.get(`${across[i + 1]} ${b}`)], ["top", cells.get(`${a} ${up[j + 1]}`)]])
        if (row && other && row[field] !== null && other[field] !== null && keeps(row) !== keeps(other))
          borders.push({ text, side, [x.field]: a, [y.field]: b });
    }));
    if (borders.length > 0) borders[borders.length >> 1].label = text;
    return borders;
  });
}

function mapSpec() {
  const { x, y, value } = map;
  // All values have a colour of their own; over more than a decade by their logarithm.
  const { low, high } = extremes.get(value.index);
  const here = isGrid ? rows.filter((row) => [...map.held].every(([index, level]) => String(row[`c${index}`]) === level)) : rows;
  const colour = { field: value.field, type: "quantitative", title: value.label, scale: { scheme: "viridis", type: low > 0 && high > 10 * low ? "log" : "linear", ...(high > low ? { domain: [low, high] } : {}) }, legend: { gradientLength: 300, format: ".5~g" } };
  const fade = { condition: { test: "datum.feasible", value: 1 }, value: 0.35 };
  if (!isGrid)
    return { marks: here.length, spec: { width: "container", height: 400, data: { values: here.filter((row) => row[value.field] !== null) },
      mark: { type: "circle", size: 34, stroke: colourOf("--soft"), strokeWidth: 0.4, tooltip: hoverDesign }, encoding: { x: quantity(x, { scale: { type: x.scale === "log" ? "log" : "linear" } }), y: quantity(y, { scale: { type: y.scale === "log" ? "log" : "linear" } }), color: colour, opacity: fade } } };
  const level = (column) => ({ field: column.field, type: "ordinal", title: column.label, axis: { labelExpr: "format(datum.value, '.4~g')", labelOverlap: "parity", labelSeparation: 4, labelAngle: 0, ticks: false, domain: false } });
  const encoding = { x: level(x), y: { ...level(y), sort: "descending" } };
  const borders = limitBorders(here, map);
  const end = (column, bandPosition, more = {}) => ({ field: column.field, bandPosition, ...more });
  const border = { right: { x: { ...encoding.x, bandPosition: 1 }, y: { ...encoding.y, bandPosition: 0 }, y2: end(y, 1) },
    top: { x: { ...encoding.x, bandPosition: 0 }, x2: end(x, 1), y: { ...encoding.y, bandPosition: 0 } } };
  const label = (size) => ({ type: "text", fontSize: 11, fontWeight: 700, color: "#ffffff", tooltip: false, ...size });
  const halo = { stroke: "#111111", strokeWidth: 2.6, strokeJoin: "round" };
  return { marks: here.length, spec: { width: "container", height: 400,
    datasets: { here: here.filter((row) => row[value.field] !== null), chosen: here.filter((row) => row.chosen), borders },
    layer: [
      { data: { name: "here" }, mark: { type: "rect", tooltip: hoverDesign }, encoding: { ...encoding, color: colour, opacity: fade } },
      ...Object.entries(border).filter(([side]) => borders.some((one) => one.side === side)).flatMap(([side, places]) => [{ stroke: "#ffffff", strokeWidth: 4 }, { stroke: "#111111", strokeWidth: 1.8 }].map((line) => (
        { data: { name: "borders" }, transform: [{ filter: `datum.side === '${side}'` }], mark: { type: "rule", strokeCap: "square", ...line, tooltip: { expr: "datum.text" } }, encoding: places }))),
      ...(here.some((row) => row.chosen) ? [{ data: { name: "chosen" }, mark: { type: "point", shape: "diamond", size: 90, filled: true, fill: "#ffffff", stroke: "#111111", strokeWidth: 1.2, opacity: 1, tooltip: hoverDesign }, encoding },
      ...[halo, {}].map((more) => ({ data: { name: "chosen" }, mark: label(more), encoding: { ...encoding, text: { field: "design" } } }))] : []),
      ...(borders.length > 0 ? [halo, {}] : []).map((more) => ({ data: { name: "borders" }, transform: [{ filter: "datum.label" }], mark: label(more), encoding: { ...encoding, text: { field: "label" } } })),
    ] } };
}

async function drawMap() {
  const { spec, marks } = mapSpec();
  await draw("map", spec, marks, `${map.value.label} over ${map.x.label} and ${map.y.label}`, withPlacedLabels);
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
  if (!document.getElementById("map")) return;
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
  const others = report.constraints.filter((one) => !one.relation).map((one) => one.text);
  hint.textContent = `Faint: not feasible.${isGrid ? ` Diamonds: chosen.${drawnLimits.length > 0 ? " Lines: limits of constraints." : ""}${others.length > 0 ? ` Not drawn, as it compares more than one column: ${others.join("; ")}.` : ""}` : ""}`;
  document.querySelector("#map .controls").append(hint);
  addHeld();
  await drawMap();
}
