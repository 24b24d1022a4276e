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

const styleOf = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);

export class Curves {
  /** `legend`: a table of colour, name, value at Nyquist and value under the cursor. */
  constructor(place, legend) {
    Object.assign(this, { place, legend, chart: null, key: "", colours: new Map() });
    new ResizeObserver(() => this.chart?.setSize(this.size())).observe(place);
  }
  size() { return { width: Math.max(240, this.place.clientWidth), height: 210 }; }
  /** A component keeps its colour while others come and go. */
  colourOf(label) {
    if (!this.colours.has(label)) this.colours.set(label, COLOURS[this.colours.size % COLOURS.length]);
    return this.colours.get(label);
  }
  /** `base`: baseOf the answer for the sensor at the start or the kept one. */
  show(next, base, baseName) {
    this.later = this.library === undefined ? () => this.show(next, base, baseName) : null;
    const { curves, at_nyquist } = next, { frequency, unit } = curves;
    const lines = [{ label: "system", values: modulus(curves.system), nyquist: modulus(at_nyquist.system)[0], stroke: styleOf("--ink"), width: 2.5 }];
    if (base) lines.push({ label: baseName, values: frequency.map((f) => at(base, f)), nyquist: base.nyquist, stroke: styleOf("--soft"), width: 1.2, dash: [5, 4], base });
    curves.components.forEach((c, i) => lines.push({ label: c.label, values: modulus(c), nyquist: modulus(at_nyquist.components[i])[0], stroke: this.colourOf(c.label), width: 1.2 }));
    this.values = { frequency, unit, columns: Object.fromEntries(lines.filter((line) => !line.base).map((line) => [line.label, line.values])) };
    Object.assign(this, { lines, nyquist: curves.nyquist });
    this.showLegend();
    if (this.later) return this.load();
    const data = [frequency, ...lines.map((line) => line.values)];
    if (!this.library) return this.table(data, lines);
    const key = JSON.stringify([lines.map(({ label, stroke }) => [label, stroke]), unit]);
    if (key !== this.key) this.make(lines, unit, key, data);
    else this.chart.setData(data);
    return undefined;
  }
  async load() {
    this.loading ??= loadLibrary();
    this.library = await this.loading;
    this.later?.();
  }
  showLegend() {
    const body = this.legend.tBodies[0], [, , head] = this.legend.tHead.rows[0].cells;
    head.textContent = `Nyquist\n${shown(this.nyquist, 4)}`;
    if (body.rows.length !== this.lines.length) body.replaceChildren(...this.lines.map(() => {
      const row = document.createElement("tr");
      row.insertCell().append(Object.assign(document.createElement("span"), { className: "swatch" }));
      for (let i = 0; i < 3; i += 1) row.insertCell();
      return row;
    }));
    this.lines.forEach(({ label, nyquist, stroke, dash }, i) => {
      const [colour, name, value] = body.rows[i].cells;
      colour.firstChild.style.borderTop = `3px ${dash ? "dashed" : "solid"} ${stroke}`;
      [name.textContent, value.textContent] = [label, nyquist.toFixed(3)];
    });
    this.showCursor();
  }
  /** Values under the cursor are those of the nearest frequency that was computed. */
  showCursor() {
    const i = this.chart?.cursor.idx ?? null, { frequency } = this.values, f = frequency[i];
    this.legend.tHead.rows[0].cells[3].textContent = `cursor\n${f === undefined ? "" : shown(f, 4)}`;
    this.lines.forEach(({ values, base }, k) => {
      // Between its own frequencies the other sensor's curve is good for two digits.
      const digits = !base || base.frequency.includes(f) ? 3 : 2, value = f === undefined ? null : values[i] ?? null;
      this.legend.tBodies[0].rows[k].cells[3].textContent = value === null ? "" : value.toFixed(digits);
    });
  }
  make(lines, unit, key, data) {
    const grid = styleOf("--grid"), soft = styleOf("--soft");
    const series = [{}, ...lines.map(({ label, stroke, width, dash }) => ({ label, stroke, width, dash, pxAlign: 0, points: { show: false } }))];
    const axis = { stroke: soft, grid: { stroke: grid, width: 1 }, ticks: { stroke: grid, width: 1 }, font: "11px system-ui, sans-serif" };
    this.chart?.destroy();
    const nyquist = (u) => {
      if (!this.nyquist) return;
      const x = u.valToPos(this.nyquist, "x", true), { ctx } = u;
      if (x < u.bbox.left || x > u.bbox.left + u.bbox.width) return;
      ctx.save();
      ctx.strokeStyle = ctx.fillStyle = soft;
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
      ...this.size(), series, hooks: { draw: [nyquist], setCursor: [() => this.showCursor()] },
      axes: [{ ...axis, size: 34, label: unit, labelSize: 16, labelFont: "11px system-ui, sans-serif" }, { ...axis, size: 40 }],
      scales: { x: { time: false }, y: { range: (_, min, max) => [Math.min(low, min), Math.max(1, max) * 1.02] } },
      legend: { show: false }, cursor: { drag: { x: false, y: false } },
    }, data, this.place);
    this.key = key;
    this.showCursor();
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
export const baseOf = ({ curves, at_nyquist }) => ({ frequency: curves.frequency, values: modulus(curves.system), nyquist: modulus(at_nyquist.system)[0] });

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

export function showLeftOut(head, list, frame) {
  const items = frame.left_out.map((left) => `${left.what}: error at most ${shown(left.bound, 2)}`), { length } = items;
  for (const merged of frame.merged) items.push(`computed as one: ${merged}`);
  head.textContent = length === 0 ? "Left out: nothing" : `Left out: ${length} of small effect`;
  list.replaceChildren(...items.map((text) => Object.assign(document.createElement("li"), { textContent: text })));
}
