// SPDX-License-Identifier: Apache-2.0
// Drawing: one Vega view a chart, in the place of its static figure; SVG unless there are too many marks.

const manyMarks = 2500;
const drawn = new Map();  // id -> { view, spec, canvas }

// In a canvas no style sheet reaches, so colours are given here too.
const chartConfig = () => ({
  background: "transparent",
  font: "system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif",
  view: { stroke: null },
  axis: { labelColor: colourOf("--soft"), titleColor: colourOf("--ink"), gridColor: colourOf("--grid"), domainColor: colourOf("--soft"),
    tickColor: colourOf("--soft"), titleFontWeight: 500, labelFontSize: 11, titleFontSize: 12, titlePadding: 8 },
  legend: { labelColor: colourOf("--soft"), titleColor: colourOf("--ink"), titleFontWeight: 500, labelFontSize: 11, titleFontSize: 12, labelLimit: 200, titleLimit: 180 },
  header: { labelColor: colourOf("--ink"), titleColor: colourOf("--ink"), labelFontSize: 12 },
});

// Vega-Lite has no words for Vega's placing of labels: texts move to where they cover nothing of
// the layers before them, which must not be empty, but the first, which holds all designs.
const withPlacedLabels = (spec) => {
  const layers = spec.marks.filter((mark) => /^layer_[1-9]/.test(mark.name));
  for (const [i, mark] of layers.entries()) {
    if (mark.type !== "text") continue;
    const avoidMarks = layers.slice(0, i).filter((one) => one.type !== "text" || one.from.data !== mark.from.data).map((one) => one.name);
    mark.transform = [{ type: "label", size: { signal: "[max(width, 1), max(height, 1)]" }, avoidMarks, offset: [9, 14, 20],
      anchor: ["top", "right", "left", "bottom", "top-right", "top-left", "bottom-right", "bottom-left"] }];
  }
  return spec;
};

// Puts a Vega-Lite chart into the figure `id`; resolves to its view.
async function draw(id, spec, marks = 0, about = "", patch = undefined) {
  const place = document.querySelector(`#${id} .view`);
  const canvas = marks > manyMarks;
  const holder = document.createElement("div");
  // Sized before anything is measured: the old chart stays until the new one is there.
  holder.style.width = "100%";
  place.append(holder);
  const { view } = await vegaEmbed(holder, { $schema: "https://vega.github.io/schema/vega-lite/v6.json", ...spec, config: chartConfig() }, {
    renderer: canvas ? "canvas" : "svg",
    patch,
    ast: true,  // no code is made from text, so the page's policy can forbid it
    actions: { export: { svg: true, png: true }, source: false, compiled: false, editor: false },
    tooltip: { theme: "custom", formatTooltip: tooltipHtml },
  });
  drawn.get(id)?.view.finalize();
  for (const old of [...place.children]) if (old !== holder) old.remove();
  if (about) holder.setAttribute("aria-label", about);
  drawn.set(id, { view, canvas, holder });
  return view;
}

// How many columns of that width have room in a chart, at most `most`.
const columnsIn = (id, pixels, most) => Math.max(1, Math.min(most, Math.floor(document.querySelector(`#${id} .view`).clientWidth / pixels)));

// A labelled choice in the controls of a chart. `options`: [value, text].
function addChoice(id, label, options, value, changed) {
  const element = document.createElement("label");
  element.textContent = label;
  const select = document.createElement("select");
  for (const [option, text] of options) select.add(new Option(text, option, false, String(option) === String(value)));
  select.addEventListener("change", () => changed(select.value));
  element.append(select);
  document.querySelector(`#${id} .controls`).append(element);
  return select;
}

// Names as the report writes them.
const columnChoices = (list) => list.map((column) => [column.index, column.label]);
const quantity = (column, more = {}) => ({ field: column.field, type: "quantitative", title: column.label,
  scale: { zero: false, nice: true, ...(more.scale ?? {}) }, axis: { format: ".6~g", tickCount: 9, ...(more.axis ?? {}) } });
// Marks that stand for a design carry the design itself; its words are made when somebody points at it.
const hoverDesign = { content: "data" };
const hoverColumns = columns.filter((column) => !column.gap && !["feasible", "pareto", "error"].includes(column.role)).slice(0, 14);
function tooltipHtml(value, sanitize) {
  const pairs = value.design !== undefined && "front" in value
    ? [["design", value.design], ...hoverColumns.map((column) => [column.label, shown(value[column.field])])]
    : Object.entries(value);
  return `<table>${pairs.map(([key, text]) => `<tr><td class="key">${sanitize(key)}</td><td class="value">${sanitize(String(text))}</td></tr>`).join("")}</table>`;
}

// A canvas prints as pixels: while printing an SVG of the same scene takes its place.
addEventListener("beforeprint", () => {
  for (const { view, canvas, holder } of drawn.values()) {
    if (!canvas) continue;
    const svg = new vega.SVGStringRenderer().initialize(null, view.width() + 2 * 90, view.height() + 70, view.origin(), 1)
      .render(view.scenegraph().root).svg();
    const copy = document.createElement("div");
    copy.className = "print";
    copy.innerHTML = svg;
    holder.classList.add("has-print");
    holder.append(copy);
  }
});
addEventListener("afterprint", () => {
  for (const copy of document.querySelectorAll(".view .print")) copy.remove();
});
