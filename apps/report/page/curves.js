// SPDX-License-Identifier: Apache-2.0
// The chosen designs: MTF, noise; and the charts of sensitivities and of the run.

const withCurves = report.chosen.filter((one) => one.frequency);
const curves = { unit: "cy/mm", what: "all" };
const inUnit = (one, f) => (curves.unit === "cy/mrad" ? f * one.focal_mm / 1e3 : curves.unit === "cy/px" ? f * one.pitch_um / 1e3 : f);

function curvesSpec() {
  const lines = [], nyquist = [];
  const add = (one, name, mtf) => mtf.forEach((value, i) => lines.push({ name, f: inUnit(one, one.frequency[i]), mtf: value }));
  const shownDesigns = curves.what === "all" ? withCurves : withCurves.filter((one) => one.design === Number(curves.what));
  const names = [], colours = [];
  for (const one of shownDesigns) {
    const rising = one.frequency.findIndex((f) => f >= one.nyquist), i = Math.max(1, rising);
    const t = rising < 0 ? NaN : (one.nyquist - one.frequency[i - 1]) / (one.frequency[i] - one.frequency[i - 1]);
    nyquist.push({ name: curves.what === "all" ? `design ${one.design}` : "system", f: inUnit(one, one.nyquist), mtf: rising < 0 ? 0 : one.system[i - 1] + t * (one.system[i] - one.system[i - 1]) });
    if (curves.what === "all") {
      names.push(`design ${one.design}`); colours.push(designColour(one.design));
      add(one, `design ${one.design}`, one.system);
    } else {
      one.components.forEach((component, k) => { names.push(component.label); colours.push(colourOf(palette[k % palette.length])); add(one, component.label, component.mtf); });
      names.push("system"); colours.push(colourOf("--ink"));
      add(one, "system", one.system);
    }
  }
  const x = { field: "f", type: "quantitative", title: `spatial frequency along x (${curves.unit})`, axis: { format: ".6~g", tickCount: 12 } };
  const y = { field: "mtf", type: "quantitative", title: "MTF", scale: { domain: [0, 1] } };
  const color = { field: "name", type: "nominal", title: null, sort: null, scale: { domain: names, range: colours }, legend: { symbolType: "stroke", symbolStrokeWidth: 3 } };
  return {
    width: "container", height: 360, datasets: { lines, nyquist },
    layer: [
      { data: { name: "lines" }, mark: { type: "line", strokeWidth: 2 }, encoding: { x, y, color, strokeWidth: { condition: { test: "datum.name === 'system'", value: 3.2 }, value: 1.9 } } },
      { data: { name: "lines" }, mark: { type: "circle", size: 60, opacity: 0 }, encoding: { x, y, tooltip: [{ field: "name", title: "curve" }, { field: "f", title: curves.unit, format: ".4~g" }, { field: "mtf", title: "MTF", format: ".4f" }] } },
      { data: { name: "nyquist" }, mark: { type: "point", filled: true, size: 70, opacity: 1, stroke: colourOf("--paper"), strokeWidth: 1 }, encoding: { x, y, color, tooltip: [{ field: "name", title: "Nyquist of" }, { field: "f", title: curves.unit, format: ".4~g" }, { field: "mtf", title: "MTF", format: ".4f" }] } },
    ],
  };
}

async function startCurves() {
  if (withCurves.length === 0) return;
  const redraw = () => draw("curves", curvesSpec(), 0, "MTF of the chosen designs");
  addChoice("curves", "show", [["all", "systems of all designs"], ...withCurves.map((one) => [one.design, `components of design ${one.design}`])], "all", (value) => { curves.what = value; redraw(); });
  addChoice("curves", "frequency in", [["cy/mm", "cy/mm"], ["cy/mrad", "cy/mrad"], ["cy/px", "cy/px"]], curves.unit, (value) => { curves.unit = value; redraw(); });
  const hint = document.createElement("small");
  hint.textContent = "Dots: the MTF at Nyquist along x.";
  document.querySelector("#curves .controls").append(hint);
  await redraw();
}

// Terms whose variances add to the temporal noise, as `mtf budget` names them.
const noiseTerms = { scene_shot: "shot noise of scene and path", background_shot: "shot noise of optics and stop", dark_shot: "shot noise of dark current",
  read: "read", reset: "reset", other: "other", quantisation: "quantisation" };

async function startNoise() {
  const values = [];
  for (const one of report.chosen) {
    const budget = one.budget ?? [];
    if (budget.some(([name, value]) => name === "temporal" && value === null)) continue; // saturated: shares of nothing
    for (const [name, value] of budget)
      if (noiseTerms[name] && value > 0) values.push({ design: `design ${one.design}`, term: noiseTerms[name], rms: value, variance: value * value, place: Object.keys(noiseTerms).indexOf(name) });
  }
  if (values.length === 0) return;
  const terms = Object.values(noiseTerms).filter((term) => values.some((one) => one.term === term));
  await draw("noise", {
    width: "container", height: 32 * new Set(values.map((one) => one.design)).size, data: { values },
    mark: { type: "bar", height: { band: 0.72 } },
    encoding: {
      y: { field: "design", type: "nominal", title: null, sort: null },
      x: { field: "variance", type: "quantitative", stack: "normalize", title: "share of the temporal variance", axis: { format: "%", tickCount: 10 } },
      color: { field: "term", type: "nominal", title: null, sort: terms, scale: { domain: terms, range: palette.map(colourOf) }, legend: { orient: "bottom", columns: columnsIn("noise", 210, 4), labelLimit: 240 } },
      order: { field: "place", sort: "ascending" },
      tooltip: [{ field: "design" }, { field: "term" }, { field: "rms", title: "e- rms", format: ".4~g" }],
    },
  }, 0, "shares of the temporal noise");
}

async function startIndices() {
  if (!document.getElementById("indices")) return;
  const values = report.indices.filter((index) => index[4] !== null).slice(0, 60).flatMap(([metric, parameter, first, firstSd, total, totalSd]) => [
    { metric, parameter, kind: "first order", value: first, low: first - firstSd, high: first + firstSd },
    { metric, parameter, kind: "total", value: total, low: total - totalSd, high: total + totalSd }]);
  const y = { field: "parameter", type: "nominal", title: null, sort: null }, yOffset = { field: "kind", sort: ["first order", "total"] };
  await draw("indices", {
    data: { values },
    facet: { field: "metric", title: null, sort: null, header: { labelAngle: 0, labelAlign: "left", labelOrient: "top", labelFontWeight: 600, labelAnchor: "start" } },
    spacing: 14, columns: 2,
    spec: { width: 380, height: { step: 15 }, layer: [
      { mark: { type: "bar" }, encoding: { y, yOffset, x: { field: "value", type: "quantitative", title: "share of the variance", scale: { domain: [0, 1], clamp: true } },
        color: { field: "kind", title: null, scale: { domain: ["first order", "total"], range: [colourOf("--s7"), colourOf("--s0")] }, legend: { orient: "top" } },
        tooltip: [{ field: "metric" }, { field: "parameter" }, { field: "kind" }, { field: "value", format: ".3f" }] } },
      { mark: { type: "rule", color: colourOf("--ink") }, encoding: { y, yOffset, x: { field: "low", type: "quantitative" }, x2: { field: "high" } } },
    ] },
    resolve: { scale: { x: "shared" } },
  }, 0, "Sobol indices");
}

async function startAccuracy() {
  if (report.accuracy.length === 0) return;
  const values = report.accuracy.flatMap(([tolerance, promised, realised, time]) =>
    [{ tolerance, kind: "promised", error: promised, time }, { tolerance, kind: "realised", error: realised, time }])
    .filter((one) => one.error > 0 && one.time > 0);
  if (values.length === 0) return;
  await draw("accuracy", {
    width: "container", height: 300, data: { values },
    mark: { type: "line", point: { size: 45, filled: true }, strokeWidth: 2 },
    encoding: {
      x: { field: "time", type: "quantitative", scale: { type: "log", nice: false, padding: 12 }, title: "time of a design (µs)", axis: { format: ".6~g" } },
      y: { field: "error", type: "quantitative", scale: { type: "log" }, title: "error", axis: { format: ".0e", tickCount: 8 } },
      color: { field: "kind", title: null, scale: { domain: ["promised", "realised"], range: [colourOf("--s7"), colourOf("--s0")] } },
      tooltip: [{ field: "kind" }, { field: "tolerance", format: ".0e" }, { field: "error", format: ".2e" }, { field: "time", title: "µs", format: ".3~g" }],
    },
  }, 0, "error against time");
}
