// SPDX-License-Identifier: Apache-2.0
// All designs: a scatter of any two columns, filters, and parallel coordinates of what is left.

const filterColumns = [...axes, ...asked].filter((column, i, all) => all.findIndex((c) => c.index === column.index) === i && column.role !== "error");
const filters = new Map();  // column index -> { low, high } or { level }
const only = { feasible: false, front: false };
let brushed = null;  // ranges of the two columns that were dragged over

function passes(row) {
  if (only.feasible && !row.feasible) return false;
  if (only.front && !row.front) return false;
  for (const [index, { low, high, level }] of filters) {
    const value = row[`c${index}`];
    if (level !== undefined) { if (String(value) !== level) return false; continue; }
    if (value === null || (low !== null && value < low) || (high !== null && value > high)) return false;
  }
  return true;
}

const scatter = { x: asked[0], y: asked[1] ?? asked[0], colour: asked[2] ?? null, view: null };

function scatterSpec(visible) {
  const { x, y, colour } = scatter;
  const xy = { x: quantity(x), y: quantity(y) };
  const plain = { value: colourOf("--s0") };
  const coloured = colour ? { field: colour.field, type: "quantitative", title: colour.label, scale: { scheme: "viridis", zero: false }, legend: { format: ".6~g" } } : plain;
  return {
    width: "container", height: 400,
    datasets: { all: visible, front: visible.filter((row) => row.front), chosen: visible.filter((row) => row.chosen) },
    layer: [
      { data: { name: "all" }, params: [{ name: "brush", select: { type: "interval" } }],
        mark: { type: "circle", size: 26, stroke: colourOf("--soft"), strokeWidth: 0.4, tooltip: hoverDesign },
        encoding: { ...xy, color: coloured,
          opacity: { condition: { test: "datum.feasible", value: 0.85 }, value: 0.3 } } },
      ...(visible.some((row) => row.front) ? [{ data: { name: "front" }, mark: { type: "point", size: 46, strokeWidth: 1.3, stroke: colourOf("--s3"), fill: null, tooltip: false },
        encoding: { ...xy, opacity: { value: 0.8 } } }] : []),
      ...(visible.some((row) => row.chosen) ? [{ data: { name: "chosen" }, mark: { type: "point", shape: "diamond", size: 120, filled: true, fill: colourOf("--s3"), stroke: colourOf("--paper"), strokeWidth: 1, opacity: 1, tooltip: hoverDesign },
        encoding: xy },
        ...[{ stroke: colourOf("--paper"), strokeWidth: 3, strokeJoin: "round" }, { style: "ink" }].map((more) => (
        { data: { name: "chosen" }, mark: { type: "text", fontSize: 11, fontWeight: 600, color: colourOf("--ink"), tooltip: false, ...more },
          encoding: { ...xy, text: { field: "design" } } }))] : []),
    ],
  };
}

async function drawScatter() {
  const visible = rows.filter(passes);
  brushed = null;
  scatter.view = await draw("scatter", scatterSpec(visible), visible.length, `${scatter.y.label} against ${scatter.x.label}`, withPlacedLabels);
  scatter.view.addSignalListener("brush", (name, value) => {
    brushed = Object.keys(value).length > 0 ? value : null;
    clearTimeout(scatter.timer);
    scatter.timer = setTimeout(update, 120);
  });
  scatter.view.addEventListener("click", (event, item) => { if (item?.datum?.design !== undefined) pick(item.datum.design); });
}

// Every value of one design, to the last digit.
function pick(design) {
  const row = rows.find((one) => one.design === design);
  const place = document.getElementById("picked");
  place.textContent = "";
  if (!row) return;
  const heading = document.createElement("h3");
  heading.textContent = `Design ${design}${row.front ? ", on the Pareto front" : ""}${row.feasible ? "" : ", not feasible"}`;
  const list = document.createElement("dl");
  for (const column of columns.filter((one) => !one.gap)) {
    const line = document.createElement("div"), term = document.createElement("dt"), value = document.createElement("dd");
    term.textContent = column.label;
    value.textContent = row[column.field] === null ? "–" : String(row[column.field]);
    line.append(term, value);
    list.append(line);
  }
  place.append(heading, list);
}

const inBrush = (row) => !brushed || Object.entries(brushed).every(([field, [a, b]]) =>
  row[field] !== null && row[field] >= Math.min(a, b) && row[field] <= Math.max(a, b));

// Lines through all columns, up being better for objectives; a readable number of them, evenly taken.
const mostLines = 350;
const extremes = new Map(filterColumns.filter((column) => !column.discrete).map((column) => {
  let low = Infinity, high = -Infinity;
  for (const row of rows) {
    const value = row[column.field];
    if (typeof value === "number") { low = Math.min(low, value); high = Math.max(high, value); }
  }
  const objective = objectives.find((one) => one.index === column.index);
  return [column.index, { low, high, down: objective !== undefined && !objective.maximize, objective }];
}));

const parallelColumns = filterColumns.filter((column) => extremes.get(column.index)?.high > extremes.get(column.index)?.low);

// A name on up to three lines of about 13 characters, broken after underscores and dots.
function threeLines(name) {
  const lines = [""];
  for (const part of name.split(/(?<=_|\.(?=[a-z]))/i))
    if (lines.at(-1) && lines.at(-1).length + part.length > 13 && lines.length < 3) lines.push(part);
    else lines[lines.length - 1] += part;
  return lines;
}

function parallelSpec(visible) {
  const across = parallelColumns;
  const always = visible.filter((row) => row.chosen);
  const others = visible.filter((row) => !row.chosen);
  const step = Math.max(1, Math.ceil(others.length / mostLines));
  const lines = [];
  for (const row of [...others.filter((_, i) => i % step === 0), ...always])
    for (const [place, column] of across.entries()) {
      const { low, high, down } = extremes.get(column.index);
      const value = row[column.field];
      if (typeof value !== "number") continue;
      const share = high > low ? (value - low) / (high - low) : 0.5;
      lines.push({ design: row.design, place, share: down ? 1 - share : share, kind: row.chosen ? `design ${row.design}` : row.front ? "Pareto front" : row.feasible ? "feasible" : "not feasible", name: column.label, value });
    }
  const names = across.map((column) => threeLines(column.name)), most = Math.max(...names.map((lines) => lines.length));
  const ends = across.map((column, place) => {
    const { low, high, down, objective } = extremes.get(column.index);
    return { place, name: names[place], unit: column.unit ? `(${column.unit})` : "", top: shown(down ? low : high), bottom: shown(down ? high : low),
      wanted: objective ? (down ? ["turned round:", "less is better"] : ["more is better"]) : [] };
  });
  const kinds = ["not feasible", "feasible", "Pareto front", ...always.map((row) => `design ${row.design}`)];
  const colours = [colourOf("--rule"), colourOf("--s7"), colourOf("--ink"), ...always.map((row) => designColour(row.design))];
  const x = { field: "place", type: "quantitative", axis: null, scale: { domain: [-0.35, across.length - 0.65] } };
  const words = (field, y, dy, more = {}) => ({ data: { name: "ends" }, mark: { type: "text", dy, fontSize: 11, color: colourOf("--soft"), limit: 92, lineHeight: 13, ...more },
    encoding: { x, y: { datum: y, axis: null }, text: { field } } });
  return {
    width: columnsIn("parallel", 86, across.length) < across.length ? 86 * across.length : "container",  // else the chart scrolls
    height: 300, padding: { left: 5, right: 5, top: 41 + 13 * most, bottom: 5 },
    datasets: { lines, ends },
    layer: [
      { data: { name: "ends" }, mark: { type: "rule", color: colourOf("--rule") }, encoding: { x, y: { datum: 0, axis: null }, y2: { datum: 1 } } },
      { data: { name: "lines" }, params: [{ name: "hover", select: { type: "point", fields: ["design"], on: "pointerover", clear: "pointerout" } }],
        mark: { type: "line", strokeJoin: "round" },
        encoding: { x, y: { field: "share", type: "quantitative", axis: null, scale: { domain: [0, 1] } }, detail: { field: "design" },
          color: { field: "kind", type: "nominal", scale: { domain: kinds, range: colours }, legend: { title: null, orient: "bottom", offset: 46, columns: columnsIn("parallel", 120, 6), symbolType: "stroke", symbolStrokeWidth: 3 } },
          strokeWidth: { condition: [{ param: "hover", empty: false, value: 3 }, { test: "indexof(datum.kind, 'design ') === 0", value: 2.6 }], value: 1 },
          opacity: { condition: [{ param: "hover", empty: false, value: 1 }, { test: "indexof(datum.kind, 'design ') === 0", value: 1 }, { test: "datum.kind === 'not feasible'", value: 0.35 }], value: 0.5 },
          tooltip: [{ field: "design" }, { field: "kind" }] } },
      { data: { name: "lines" }, mark: { type: "circle", size: 30, opacity: 0 }, encoding: { x, y: { field: "share", type: "quantitative", axis: null },
        tooltip: [{ field: "design" }, { field: "name" }, { field: "value", type: "quantitative", format: ".5~g" }] } },
      words("name", 1, { expr: "-27 - 13 * length(datum.name)" }, { fontWeight: 600, color: colourOf("--ink") }), words("unit", 1, -26), words("top", 1, -12),
      words("bottom", 0, 12), words("wanted", 0, 27, { color: colourOf("--accent") }),
    ],
  };
}

async function update() {
  const visible = rows.filter((row) => passes(row) && inBrush(row));
  const output = document.querySelector("#filters output");
  if (output) output.textContent = `${visible.length} of ${rows.length}${rows.length < report.designs ? " in this page" : ""}`;
  if (parallelColumns.length > 1 && visible.length > 0) {
    const view = await draw("parallel", parallelSpec(visible), 0, "parallel coordinates of the designs that pass the filters");
    view.addEventListener("click", (event, item) => {
      const design = item?.datum?.design ?? item?.items?.[0]?.datum?.design;
      if (design !== undefined) pick(design);
    });
  }
}

function addFilters() {
  const place = document.getElementById("filters");
  const box = document.createElement("details");
  box.innerHTML = "<summary>Filter designs: <output></output></summary><div class=\"controls\"></div><div class=\"grid\"></div>";
  const changed = () => { clearTimeout(addFilters.timer); addFilters.timer = setTimeout(() => drawScatter().then(update), 150); };
  for (const [key, text] of [["feasible", "feasible only"], ["front", "Pareto front only"]]) {
    const label = document.createElement("label"), input = document.createElement("input");
    input.type = "checkbox";
    input.addEventListener("change", () => { only[key] = input.checked; changed(); });
    label.append(input, text);
    box.querySelector(".controls").append(label);
  }
  for (const column of filterColumns) {
    const label = document.createElement("label"), name = document.createElement("span");
    name.textContent = name.title = column.label;
    label.append(name);
    if (column.discrete) {
      const select = document.createElement("select");
      select.add(new Option("all", ""));
      for (const level of new Set(report.cells[column.index])) select.add(new Option(String(level), String(level)));
      select.addEventListener("change", () => {
        if (select.value) filters.set(column.index, { level: select.value }); else filters.delete(column.index);
        changed();
      });
      label.append(select);
    } else {
      const ends = ["at least", "at most"].map((words) => {
        const input = document.createElement("input");
        input.type = "number"; input.step = "any"; input.placeholder = words;
        input.setAttribute("aria-label", `${column.label} ${words}`);
        label.append(input);
        return input;
      });
      const read = (input) => (input.value === "" ? null : Number(input.value));
      for (const input of ends) input.addEventListener("input", () => {
        const [low, high] = ends.map(read);
        if (low === null && high === null) filters.delete(column.index); else filters.set(column.index, { low, high });
        changed();
      });
    }
    box.querySelector(".grid").append(label);
  }
  place.append(box);
}

async function startDesigns() {
  if (asked.length < 2 || rows.length < 2) return;
  const redraw = (key) => (value) => { scatter[key] = value === "" ? null : columns[Number(value)]; drawScatter().then(update); };
  addChoice("scatter", "across", columnChoices(asked), scatter.x.index, redraw("x"));
  addChoice("scatter", "up", columnChoices(asked), scatter.y.index, redraw("y"));
  addChoice("scatter", "colour", [["", "none"], ...columnChoices(asked)], scatter.colour?.index ?? "", redraw("colour"));
  const hint = document.createElement("small");
  hint.textContent = "Ringed: Pareto front. Faint: not feasible. Drag to select, click for all values.";
  document.querySelector("#scatter .controls").append(hint);
  addFilters();
  await drawScatter();
  await update();
}
