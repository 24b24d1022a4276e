// SPDX-License-Identifier: Apache-2.0
// Curves, budget, what was left out: text and lines of what the server has computed.

const COLOURS = ["#3b82c4", "#d9822b", "#3f9d5a", "#b4529c", "#8a7a20", "#5a9fb0", "#c2554d", "#7a6fd0", "#7f8c8d"];
const modulus = (curve) => curve.re.map((re, i) => Math.hypot(re, curve.im[i]));
export const shown = (value, digits = 5) => {
  if (value === null || value === undefined) return "-";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) return value.toExponential(digits - 2).replace("e+", "e");
  return String(Number(value.toPrecision(digits)));
};

/** Loads the chart library, which no picture waits for; a build without it has none. */
const loadLibrary = () => new Promise((resolve) => {
  document.head.append(Object.assign(document.createElement("script"), { src: "/uPlot.iife.min.js", onload: () => resolve(true), onerror: () => resolve(false) }));
});

export class Curves {
  constructor(place) {
    this.place = place;
    this.chart = null;
    this.key = "";
    new ResizeObserver(() => this.chart?.setSize(this.size())).observe(place);
  }
  size() { return { width: Math.max(240, this.place.clientWidth), height: 240 }; }
  /** `base`: the system's curve at the start or of the kept sensor, on its own frequencies. */
  show(curves, base, baseName) {
    const lines = [{ label: "system", curve: curves.system, width: 2.5 }, ...curves.components.map((c) => ({ label: c.label, curve: c, width: 1 }))];
    const data = [curves.frequency, ...lines.map((line) => modulus(line.curve))];
    this.values = { frequency: curves.frequency, unit: curves.unit, columns: Object.fromEntries(lines.map((line, i) => [line.label, data[i + 1]])) };
    if (base) data.push(curves.frequency.map((f) => at(base, f)));
    this.later = this.library === undefined ? () => this.show(curves, base, baseName) : null;
    if (this.later) return this.load();
    if (!this.library) return this.table(data, lines);
    const key = JSON.stringify([lines.map((line) => line.label), baseName, curves.unit, Boolean(base), getComputedStyle(document.documentElement).getPropertyValue("--ink")]);
    if (key !== this.key) this.make(lines, base ? baseName : "", curves.unit, key, data);
    else this.chart.setData(data);
    this.nyquist = curves.nyquist;
    return undefined;
  }
  async load() {
    this.loading ??= loadLibrary();
    this.library = await this.loading;
    this.later?.();
  }
  make(lines, baseName, unit, key, data) {
    const style = getComputedStyle(document.documentElement), ink = style.getPropertyValue("--ink"), grid = style.getPropertyValue("--grid");
    const number = (_, value) => (value === null ? "" : value.toFixed(3));
    const series = [{ label: `f [${unit}]`, value: (_, f) => (f === null ? "" : shown(f, 4)) },
      ...lines.map((line, i) => ({ label: line.label, stroke: i === 0 ? ink : COLOURS[(i - 1) % COLOURS.length], width: line.width, value: number, pxAlign: 0, points: { show: false } }))];
    if (baseName) series.push({ label: baseName, stroke: style.getPropertyValue("--soft"), width: 1.2, dash: [5, 4], pxAlign: 0, value: number, points: { show: false } });
    const axis = { stroke: style.getPropertyValue("--soft"), grid: { stroke: grid, width: 1 }, ticks: { stroke: grid, width: 1 }, font: "11px system-ui, sans-serif" };
    this.chart?.destroy();
    const nyquist = (u) => {
      if (!this.nyquist) return;
      const x = u.valToPos(this.nyquist, "x", true), { ctx } = u;
      if (x < u.bbox.left || x > u.bbox.left + u.bbox.width) return;
      ctx.save();
      ctx.strokeStyle = ctx.fillStyle = style.getPropertyValue("--soft");
      ctx.setLineDash([2, 4]);
      ctx.beginPath();
      ctx.moveTo(x, u.bbox.top);
      ctx.lineTo(x, u.bbox.top + u.bbox.height);
      ctx.stroke();
      ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
      ctx.textAlign = "left";
      ctx.fillText("Nyquist", x + 4 * devicePixelRatio, u.bbox.top + 12 * devicePixelRatio);
      ctx.restore();
    };
    const low = Math.min(0, ...data.slice(1).flat());
    this.chart = new uPlot({
      ...this.size(), series, hooks: { draw: [nyquist] },
      axes: [{ ...axis, size: 34, label: unit, labelSize: 16, labelFont: "11px system-ui, sans-serif" }, { ...axis, size: 40 }],
      scales: { x: { time: false }, y: { range: (_, min, max) => [Math.min(low, min), Math.max(1, max) * 1.02] } },
      legend: { live: true, markers: { width: 0, fill: (u, i) => u.series[i].stroke(u, i) } }, cursor: { drag: { x: false, y: false } },
    }, data, this.place);
    this.key = key;
  }
  // A build without the chart library.
  table(data, lines) {
    const rows = data[0].map((f, i) => (i % 6 === 0 ? `${shown(f, 4)}\t${shown(data[1][i], 4)}` : "")).filter(Boolean);
    const text = document.createElement("pre");
    text.textContent = `frequency\t${lines[0].label}\n${rows.join("\n")}`;
    this.place.replaceChildren(text);
  }
}

/** A curve between its frequencies, by straight lines; nothing beyond its end. */
function at(base, f) {
  const { frequency, values } = base;
  const i = frequency.findIndex((x) => x >= f);
  if (i < 0) return null;
  if (i === 0) return values[0];
  const share = (f - frequency[i - 1]) / (frequency[i] - frequency[i - 1]);
  return values[i - 1] + share * (values[i] - values[i - 1]);
}
export const baseOf = (curves) => ({ frequency: curves.frequency, values: modulus(curves.system) });

const FIRST = ["netd", "spatial_netd", "snr", "total", "well_fill", "mrtd", "nep", "dstar"];

/** What is asked for most stands first, the rest in the order of the program. */
export function showBudget(table, all) {
  const rank = (row) => (FIRST.includes(row.name) ? FIRST.indexOf(row.name) : FIRST.length);
  const rows = all.toSorted((a, b) => rank(a) - rank(b));
  const body = table.tBodies[0];
  if (body.rows.length !== rows.length) body.replaceChildren(...rows.map(() => {
    const line = document.createElement("tr");
    for (let i = 0; i < 3; i += 1) line.append(document.createElement("td"));
    return line;
  }));
  rows.forEach((row, i) => {
    const line = body.rows[i], [name, value, unit] = line.cells;
    line.title = row.reason || row.doc;
    line.className = FIRST.includes(row.name) ? "key" : "";
    const text = row.saturated ? "saturated" : shown(row.value);
    if (name.textContent !== row.name) name.textContent = row.name;
    if (value.textContent !== text) value.textContent = text;
    if (unit.textContent !== row.unit) unit.textContent = row.unit;
    value.dataset.value = row.value ?? "";
  });
}

export function showLeftOut(list, frame) {
  const items = frame.left_out.map((left) => `${left.what}: at most ${shown(left.bound, 2)}`);
  if (items.length === 0) items.push("nothing: every part counts at this tolerance");
  for (const merged of frame.merged) items.push(`merged: ${merged}`);
  list.replaceChildren(...items.map((text) => Object.assign(document.createElement("li"), { textContent: text })));
}
