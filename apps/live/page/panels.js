// SPDX-License-Identifier: Apache-2.0
// Forms, curves, budget and texts beside the pictures. Each follows the edits by requests of its own, one at a time.

import { ask, Refused } from "./api.js";
import { $, app, editsOf, inSpace, moving, state } from "./app.js";
import { baseOf, showBudget, showLeftOut, shown } from "./figures.js";
import { commandOf, difference } from "./files.js";
import * as edits from "./history.js";

const CALM_MS = 150; // curves follow a moving slider no more often: pictures come first
let asking = false, wanted = false, models = 0, shownModels = 0, waiting = 0, sceneText = null;
let baseline = {}; // by unit, direction and edits

export const isBusy = () => asking || wanted || waiting > 0 || shownModels < models;

export function problem(error) {
  // The reader's words begin with the place in the file; the control shows what is wrong with it.
  const text = error.message.split("\n").map((line) => line.replace(/^\S+:\d+:\d+: error: /, "")).join("\n");
  if (!app.place?.problem(app.lastName, text)) app.controls.problem(app.lastName, text);
  $("problem").textContent = text;
  $("problem").hidden = false;
}
export function clearProblem() {
  app.controls.clear();
  app.place?.clear();
  $("problem").hidden = true;
}

/** Curves and budget follow the picture. */
export async function figures() {
  wanted = true;
  if (asking) return;
  asking = true;
  while (wanted) {
    wanted = false;
    try {
      showFigures(await ask("figures", { edits: edits.current(), angle: Number($("angle").value) || 0, unit: $("unit").value, temperature: Number($("temperature").value) }));
    } catch (error) {
      if (!(error instanceof Refused)) break;
    }
    if (moving()) await new Promise((resolve) => setTimeout(resolve, CALM_MS));
  }
  asking = false;
}

/** The dashed curve: the other sensor, where there are two, else the start. */
const base = () => (state.left === "kept" ? { name: edits.side() === 1 ? "A" : "B", list: editsOf(1 - edits.side()) } : { name: "start", list: [] });

export function showFigures(next) {
  const { name, list } = base(), key = JSON.stringify([next.curves.unit, next.curves.angle_deg, list]);
  if (!baseline[key]) makeBaseline(key, next.curves, list);
  app.curves.show(next.curves, baseline[key]?.curve, name);
  const { nyquist, cutoff, q, unit } = next.curves;
  $("merits").textContent = `Nyquist ${shown(nyquist, 4)} ${unit}` + (cutoff ? `, cutoff ${shown(cutoff, 4)} ${unit}` : "") + (q ? `, Q ${shown(q, 3)}` : "");
  $("budget-panel").hidden = !next.budget;
  if (next.budget) showBudget($("budget"), next.budget);
  $("saturation").textContent = next.saturation ?? "";
  app.figures = next;
}

async function makeBaseline(key, { unit, angle_deg: angle }, list) {
  if (Object.keys(baseline).length > 20) baseline = {};
  baseline[key] = {}; // is being made
  try {
    const made = await ask("figures", { edits: list, angle, unit, temperature: Number($("temperature").value) });
    baseline[key] = { curve: baseOf(made.curves) };
    if (app.figures) showFigures(app.figures);
  } catch { /* that sensor cannot be drawn: no dashes */ }
}

export async function showModel() {
  const turn = (models += 1);
  let model;
  try {
    model = await ask("model", { edits: edits.current() });
  } catch (error) {
    if (error instanceof Refused) problem(error);
    shownModels = Math.max(shownModels, turn);
    return;
  }
  if (turn !== models) return; // a later one is on its way
  shownModels = turn;
  app.model = model;
  app.controls.show(model);
  $("name").textContent = model.name || app.start.sensor;
  document.title = `${model.name || app.start.sensor} - mtf live`;
  const stages = ["", ...model.stages];
  $("stage-label").hidden = model.stages.length === 0;
  if ($("stage").options.length !== stages.length) $("stage").replaceChildren(...stages.map((name) => new Option(name || "end of chain", name)));
  $("stage").value = state.stage;
  texts();
}

export const savedName = (path, otherwise) => `${(path.split("/").pop() || otherwise).replace(/\.toml$/, "")}-live.toml`;

/** The scene's file with the present camera. */
export async function sceneFile() {
  waiting += 1;
  try {
    sceneText = (await ask("scenefile", app.place.request())).text;
  } finally {
    waiting -= 1;
  }
  return sceneText;
}

export function texts() {
  const { model, start } = app;
  if (!model) return;
  const changed = [difference(start.text, model.text)];
  if (inSpace() && sceneText !== null) changed.push(difference(start.space.text, sceneText));
  $("difference").replaceChildren(...(changed.filter(Boolean).join("\n\n") || "no change").split("\n").map((line) => {
    const row = document.createElement("span");
    row.textContent = `${line}\n`;
    row.className = line.startsWith("+ ") ? "plus" : line.startsWith("- ") ? "minus" : "";
    return row;
  }));
  $("command").textContent = commandOf({
    start, file: savedName(start.sensor, "sensor.toml"), changed: model.text !== start.text, tolerance: state.tolerance, stage: state.stage, number: state.number,
    sequence: start.numbers.length > 0, seed: model.tables.flatMap((table) => table.rows).find((row) => row.name === "noise.seed")?.text,
    view: app.place?.request(), hasPath: model.tables.some((table) => table.name === "path" || table.name === "atmosphere"), air: app.frames[1]?.closures?.some(([name]) => name === "air"),
  });
  $("undo").disabled = !edits.canUndo();
  $("redo").disabled = !edits.canRedo();
}

/** What the pictures are, below them; `rate`: pictures a second. */
export function facts(tags, rate) {
  const frame = app.frames[edits.side() === 0 && app.frames[0] ? 0 : 1];
  const parts = [`${frame.full_width} × ${frame.full_height}`, `${shown(frame.ms, 3)} ms`];
  if (frame.preview) parts.unshift("PREVIEW while moving");
  parts.push(`promised ${shown(frame.promised, 2)}`, frame.method);
  if (frame.radiance_promised !== undefined) parts.push(`radiance within ${shown(frame.radiance_promised, 2)}`);
  if (frame.light_lags) parts.push("light of another time");
  if (rate > 0 && (state.running || moving())) parts.push(`${rate.toFixed(0)} frames/s`);
  if (state.running || state.number > 0) parts.push(`frame ${state.number}`);
  $("facts").textContent = parts.join("  ·  ");
  $("preview-tag").hidden = !(frame.preview || frame.light_lags);
  $("left-tag").textContent = tags[0] ?? "";
  $("right-tag").textContent = tags[1] ?? "";
  if (frame.warnings.length > 0) $("facts").append(Object.assign(document.createElement("p"), { className: "warn", textContent: frame.warnings.join("\n") }));
  showLeftOut($("left-out"), frame);
  app.place?.showClosures(frame.closures);
}

export function showTolerance() {
  $("tolerance-text").textContent = state.tolerance === null ? "default" : state.tolerance.toExponential(1);
  if (state.tolerance !== null) $("tolerance").value = 100 * Math.log10(state.tolerance);
}
