// SPDX-License-Identifier: Apache-2.0
// Forms, curves, budget and texts beside the pictures. Each follows the edits by requests of its own, one at a time.

import { ask, Gone, GONE_MS, Refused } from "./api.js";
import { $, app, editsOf, inSpace, moving, ofScene, state } from "./app.js";
import { baseOf, showBudget, showLeftOut, shown } from "./figures.js";
import { commandOf, difference } from "./files.js";
import * as edits from "./history.js";

const CALM_MS = 150; // curves follow a moving slider no more often: pictures come first
let asking = false, wanted = false, models = 0, shownModels = 0, waiting = 0, sceneText = null;
let baseline = {}; // by unit, direction and edits
let said = null; // what is wrong; words about an edit that is no more stay until something is changed
let follow = () => {};

export const isBusy = () => asking || wanted || waiting > 0 || shownModels < models;

/** `act` is called when an edit was refused and is no more: everything else follows. */
export function onRefusedEdit(act) { follow = act; }

/**
 * What cannot be, in the program's words, at the control that it is about. An edit that cannot be made goes, so that it
 * stands in the way of no other; one of a slider that moves may be made at its next place. `body`: of the request, for a
 * side of the divider.
 */
export function problem(error, body, side = edits.side()) {
  // The reader's words begin with the place in the file; the control shows what is wrong with it.
  let text = error.message.split("\n").map((line) => line.replace(/^\S+:\d+:\d+: error: /, "")).join("\n");
  const list = error.refused?.list, edit = app.dragging ? undefined : body?.[list]?.[error.refused?.index];
  if (edit) {
    const [kind, name, value] = edit;
    if (kind === "set" || kind === "unset") app.lastName = name;
    else [app.lastName, text] = [null, `${kind === "add" ? `${value} is not added` : `${name} stays as it is`}: ${text}`];
    edits.refuse(edit, list === "scene" ? edits.SCENE : side);
  }
  said = { text, name: app.lastName, stays: Boolean(edit) };
  say();
  $("said").scrollTop = 0;
  if (edit) follow();
}
/** The words, also at the control that they are about once it is there, and the way back where there is one. */
export function say() {
  $("problem").hidden = !said;
  if (!said) return;
  const text = said.text + (edits.isAstray() ? "\nEsc: back to the last picture without an error" : "");
  if ($("problem").textContent !== text) $("problem").textContent = text;
  for (const forms of [app.place, app.sceneControls, app.controls]) if (forms?.problem(said.name, text)) break;
}
/** `changed`: something else has been changed. */
export function clearProblem(changed = false) {
  if (said?.stays && !changed) return say();
  said = null;
  for (const forms of [app.place, app.sceneControls, app.controls]) forms?.clear();
  say();
}

/** What is asked of curves and budget, of the place that was clicked on. */
const aboutFigures = (list, angle, unit) => ({ edits: list, angle, unit, temperature: Number($("temperature").value), ...(state.place && { x_um: state.place[0], y_um: state.place[1] }) });

/** Curves and budget are those of a place in the focal plane, um; null: of the optical axis. */
export function setPlace(um) {
  state.place = um;
  figures();
}

/** Curves and budget follow the picture. */
export async function figures() {
  wanted = true;
  if (asking) return;
  asking = true;
  while (wanted) {
    wanted = false;
    const surface = $("temperature");
    if (surface.value.trim() === "") surface.value = 300;
    surface.toggleAttribute("aria-invalid", !surface.checkValidity());
    surface.title = surface.validationMessage || "temperature of the surface that the budget is for";
    try {
      if (surface.checkValidity()) showFigures(await ask("figures", aboutFigures(edits.current(), Number($("angle").value) || 0, $("unit").value)));
    } catch (error) {
      if (error instanceof Gone) {
        wanted = true;
        await new Promise((resolve) => setTimeout(resolve, GONE_MS));
      } else if (!(error instanceof Refused)) {
        asking = wanted = false;
        throw error;
      }
    }
    if (moving()) await new Promise((resolve) => setTimeout(resolve, CALM_MS));
  }
  asking = false;
}

/** The dashed curve: the other sensor, where there are two, else the start. */
const base = () => (state.left === "kept" ? { name: `system (${edits.side() === 1 ? "A" : "B"})`, list: editsOf(1 - edits.side()) } : { name: "system (start)", list: [] });

export function showFigures(next) {
  const { name, list } = base(), key = JSON.stringify([next.curves.unit, next.curves.angle_deg, state.place, list]);
  if (!baseline[key]) makeBaseline(key, next.curves, list);
  app.curves.show(next, baseline[key]?.curve, name);
  const { cutoff, q, unit, frequency } = next.curves;
  $("merits").textContent = (next.mtf50 ? `MTF50 of the system ${shown(next.mtf50, 4)} ${unit}` : `No MTF50 up to ${shown(frequency.at(-1), 4)} ${unit}`) + (cutoff ? `, cutoff ${shown(cutoff, 4)} ${unit}` : "") + (q ? `, Q ${shown(q, 3)}` : "");
  if (next.over_field && !next.place) state.place = null; // the detector no longer has it
  $("field").hidden = !next.over_field;
  $("field").title = `Changes over the field: ${next.over_field}`;
  $("field-text").textContent = next.place ? `Of the place ${next.place.x_px.toFixed(1)}, ${next.place.y_px.toFixed(1)} px, field point ${shown(next.place.x, 3)}, ${shown(next.place.y, 3)}.` : "Of the optical axis; the OTF changes over the field: click on the picture for another place.";
  $("axis").hidden = !next.place;
  app.view.draw();
  $("budget-panel").hidden = !next.budget;
  if (next.budget) showBudget($("budget"), next.budget);
  $("saturation").textContent = next.saturation ? `A surface of ${next.temperature} K: ${next.saturation}` : "";
  app.figures = next;
}

async function makeBaseline(key, { unit, angle_deg: angle }, list) {
  if (Object.keys(baseline).length > 20) baseline = {};
  baseline[key] = {}; // is being made
  try {
    const made = await ask("figures", aboutFigures(list, angle, unit));
    baseline[key] = { curve: baseOf(made) };
    if (app.figures) showFigures(app.figures);
  } catch { /* that sensor cannot be drawn: no dashes */ }
}

export async function showModel() {
  const turn = (models += 1), side = edits.side(), body = { edits: edits.current(), ...ofScene() };
  let model;
  try {
    model = await ask("model", body);
  } catch (error) {
    if (error instanceof Refused && (turn === models || error.refused)) problem(error, body, side);
    if (error instanceof Gone && turn === models) setTimeout(showModel, GONE_MS); // until then the page is at work
    else shownModels = Math.max(shownModels, turn);
    return;
  }
  if (turn !== models) return; // a later one is on its way
  shownModels = turn;
  app.model = model;
  app.controls.show(model);
  if (model.scene) app.sceneControls.show(model.scene);
  say();
  $("name").textContent = $("name").title = model.name || app.start.sensor;
  $("notes-panel").hidden = model.notes.length === 0;
  $("notes").replaceChildren(...model.notes.map((text) => Object.assign(document.createElement("li"), { textContent: text })));
  document.title = `${model.name || app.start.sensor} - mtf live`;
  const stages = ["", ...model.stages];
  $("stage-label").hidden = model.stages.length === 0;
  if ($("stage").options.length !== stages.length) $("stage").replaceChildren(...stages.map((name) => new Option(name || "end of chain", name)));
  $("stage").value = state.stage;
  texts();
}

/** A file in the folder of another one. */
const besides = (path, name) => path.replace(/[^/]*$/, name);
export const savedName = (path, otherwise) => `${(path.split("/").pop() || otherwise).replace(/\.toml$/, "")}-live.toml`;

/** The scene's file with the present camera and all changes. */
export async function sceneFile() {
  waiting += 1;
  try {
    sceneText = (await ask("scenefile", { ...ofScene(), ...app.place.request() })).text;
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
    view: app.place?.request(), changedScene: edits.current(edits.SCENE).length > 0 ? besides(start.scene, savedName(start.scene, "scene.toml")) : null, hasPath: model.tables.some((table) => table.name === "path" || table.name === "atmosphere"), air: app.frames[1]?.closures?.some(([name]) => name === "air"),
  });
  const saved = [model.text !== start.text && `the sensor file as ${savedName(start.sensor, "sensor.toml")}`, edits.current(edits.SCENE).length > 0 && `the scene file as ${savedName(start.scene, "scene.toml")} beside the scene`].filter(Boolean);
  $("save-first").textContent = saved.length > 0 ? `Save ${saved.join(", and ")} first.` : "";
  $("undo").disabled = !edits.canUndo();
  $("redo").disabled = !edits.canRedo();
}

/** What the pictures are, below them; `rate`: pictures a second. */
export function facts(tags, rate) {
  const frame = app.frames[edits.side() === 0 && app.frames[0] ? 0 : 1];
  const parts = [`${frame.full_width} × ${frame.full_height}`, `${shown(frame.ms, 3)} ms`];
  if (frame.preview) parts.unshift("PREVIEW while moving");
  parts.push(`predicted error ${shown(frame.promised, 2)}`, frame.method);
  if (frame.radiance_promised !== undefined) parts.push(`error of the radiance ${shown(frame.radiance_promised, 2)}`);
  if (frame.light_lags) parts.push("sunlight and sky are being updated");
  if (frame.correction_lags) parts.push("non-uniformity correction of earlier values");
  if (frame.solving) parts.push(`temperatures before the change; heat balance: ${frame.solving}`);
  if (rate > 0 && (state.running || moving())) parts.push(`${rate.toFixed(0)} frames/s`);
  $("first-frame").disabled = state.running || state.number === (app.start.numbers[0] ?? 0);
  if (state.running || state.number > 0) parts.push(`frame ${state.number}`);
  $("facts").textContent = parts.join("  ·  ");
  $("preview-tag").hidden = !(app.stale.some(Boolean) || frame.preview || frame.light_lags || frame.solving);
  $("preview-tag").textContent = app.stale.some(Boolean) ? "last picture without an error" : frame.solving ? `heat balance: ${frame.solving}` : "preview";
  $("left-tag").textContent = tags[0] ?? "";
  $("right-tag").textContent = tags[1] ?? "";
  if (frame.warnings.length > 0) $("facts").prepend(Object.assign(document.createElement("p"), { className: "warn", textContent: frame.warnings.join("\n") }));
  showLeftOut($("left-out-head"), $("left-out"), frame);
  app.place?.showClosures(frame.closures);
  if (frame.sun) app.place.showSun(frame.sun, frame.utc_s);
}

/** `moving`: by the slider itself, which has no rounded place. */
export function showTolerance(moving = false) {
  const text = state.tolerance === null ? "default" : state.tolerance.toExponential(1);
  $("tolerance-text").textContent = text;
  $("tolerance").setAttribute("aria-valuetext", text);
  $("tolerance").classList.toggle("unset", state.tolerance === null);
  if (state.tolerance !== null && !moving) $("tolerance").value = 100 * Math.log10(state.tolerance);
}
