// SPDX-License-Identifier: Apache-2.0
// The page at work. One picture is asked for at a time; while it comes the latest values wait, older ones are forgotten.

import { ask, bytes, picture, Refused, stay, token } from "./api.js";
import { Controls } from "./controls.js";
import { baseOf, Curves, showBudget, showLeftOut, shown } from "./figures.js";
import { commandOf, difference, download } from "./files.js";
import * as edits from "./history.js";
import { names as palettes } from "./palettes.js";
import { View } from "./view.js";

const $ = (id) => document.getElementById(id);
const tab = Array.from(crypto.getRandomValues(new Uint32Array(2)), (n) => n.toString(36)).join("");
const CALM_MS = 150; // texts and curves follow a moving slider no more often: pictures come first
const SLOW_MS = 40; // a frame that takes longer is asked for at half size while a slider moves

const state = { tolerance: null, stage: "", number: 0, running: false, left: "scene", kept: null, palette: "white hot", theme: null };
let start = null, model = null, frame = null, generation = 0, dragging = false, lastName = null, lastMs = 0;
let asking = false, wanted = false, asking2 = false, wanted2 = false, leftKey = "", baseline = null, baseName = "start";
let told = 0; // when the texts below the picture were written
const rates = [];

const view = new View($("view"), () => {});
const curves = new Curves($("curves"));
const controls = new Controls($("forms"), {
  drag(name, text) { lastName = name; dragging = true; edits.drag(name, text); changed(); },
  drop() { dragging = false; edits.drop(); settled(); },
  set(name, text) { lastName = name; edits.set(name, text); settled(); },
  reset(name, text) { lastName = name; edits.reset(name, text); settled(); },
  add(edit) { lastName = edit[1]; edits.add(edit); settled(); },
});

function problem(error) {
  // The reader's words begin with the place in the file; the control shows what is wrong with it.
  const text = error.message.split("\n").map((line) => line.replace(/^\S+:\d+:\d+: error: /, "")).join("\n");
  controls.problem(lastName, text);
  $("problem").textContent = text;
  $("problem").hidden = false;
}
function clear() {
  controls.clear();
  $("problem").hidden = true;
}

const request = () => ({ edits: edits.current(), number: state.number, tolerance: state.tolerance, stage: state.stage });

/** Asks for pictures for as long as something has changed. */
async function pump() {
  wanted = true;
  if (asking) return;
  asking = true;
  while (wanted) {
    wanted = false;
    const half = dragging && lastMs > SLOW_MS;
    generation += 1;
    const begin = performance.now();
    try {
      const next = await picture("frame", { ...request(), tab, generation, every: half ? 2 : 1 });
      if (next.generation !== generation) continue;
      frame = next;
      lastMs = performance.now() - begin;
      const step = pixelStep(next);
      view.setPicture(1, next, step);
      rates.push(performance.now());
      if (rates.length > 30) rates.shift();
      clear();
      if (!(dragging || state.running) || performance.now() - told > CALM_MS) facts();
      if (half && !dragging) wanted = true; // the whole of it at rest
      if (state.running) step1();
    } catch (error) {
      if (!(error instanceof Refused)) { await new Promise((resolve) => setTimeout(resolve, 500)); wanted = true; continue; }
      if (error.status !== 409) problem(error);
      if (state.running && error.status !== 409) toggleRun();
    }
    await new Promise((resolve) => requestAnimationFrame(resolve));
  }
  asking = false;
}

const pixelStep = (next) => {
  const scene = view.scene ?? { pitch_x_um: 1, pitch_y_um: 1 };
  return [(next.step_x_um ?? scene.pitch_x_um) * next.every, (next.step_y_um ?? scene.pitch_y_um) * next.every];
};

/** The next noise, or the next file of a sequence. */
function step1() {
  if (start.numbers.length > 0) {
    const at = start.numbers.indexOf(state.number);
    state.number = start.numbers[(at + 1) % start.numbers.length];
    $("number").value = start.numbers.indexOf(state.number);
    showLeft();
  } else {
    state.number = (state.number + 1) % 2147483647;
  }
  wanted = true;
}

/** Curves and budget follow the picture, one request at a time as well. */
async function figures() {
  wanted2 = true;
  if (asking2) return;
  asking2 = true;
  while (wanted2) {
    wanted2 = false;
    try {
      const next = await ask("figures", { edits: edits.current(), angle: Number($("angle").value) || 0, unit: $("unit").value, temperature: Number($("temperature").value) });
      showFigures(next);
    } catch (error) {
      if (!(error instanceof Refused)) break;
    }
    if (dragging) await new Promise((resolve) => setTimeout(resolve, CALM_MS));
  }
  asking2 = false;
}

function showFigures(next) {
  const base = baseline?.[`${next.curves.unit} ${next.curves.angle_deg}`];
  if (!base) makeBaseline(next.curves.unit, next.curves.angle_deg);
  curves.show(next.curves, base, baseName);
  const { nyquist, cutoff, q, unit } = next.curves;
  $("merits").textContent = `Nyquist ${shown(nyquist, 4)} ${unit}` + (cutoff ? `, cutoff ${shown(cutoff, 4)} ${unit}` : "") + (q ? `, Q ${shown(q, 3)}` : "");
  $("budget-panel").hidden = !next.budget;
  if (next.budget) showBudget($("budget"), next.budget);
  $("saturation").textContent = next.saturation ?? "";
  page.figures = next;
}

async function makeBaseline(unit, angle) {
  const list = state.left === "kept" && state.kept ? state.kept : [];
  baseName = state.left === "kept" && state.kept ? "kept" : "start";
  try {
    const made = await ask("figures", { edits: list, angle, unit, temperature: Number($("temperature").value) });
    baseline = { ...baseline, [`${unit} ${angle}`]: baseOf(made.curves) };
    if (page.figures) showFigures(page.figures);
  } catch { /* the kept sensor cannot be drawn: no dashes */ }
}

async function showModel() {
  try {
    model = await ask("model", { edits: edits.current() });
  } catch (error) {
    if (error instanceof Refused) problem(error);
    return;
  }
  controls.show(model);
  $("name").textContent = model.name || start.sensor;
  document.title = `${model.name || start.sensor} - mtf live`;
  const stages = ["", ...model.stages];
  $("stage-label").hidden = model.stages.length === 0;
  if ($("stage").options.length !== stages.length) $("stage").replaceChildren(...stages.map((name) => new Option(name || "end of chain", name)));
  $("stage").value = state.stage;
  texts();
}

const saved = () => `${(start.sensor.split("/").pop() || "sensor.toml").replace(/\.toml$/, "")}-live.toml`;

function texts() {
  if (!model) return;
  const changedText = difference(start.text, model.text);
  const place = $("difference");
  place.replaceChildren(...(changedText || "no change").split("\n").map((line) => {
    const row = document.createElement("span");
    row.textContent = `${line}\n`;
    row.className = line.startsWith("+ ") ? "plus" : line.startsWith("- ") ? "minus" : "";
    return row;
  }));
  $("command").textContent = commandOf({ start, file: saved(), changed: model.text !== start.text, tolerance: state.tolerance, stage: state.stage, number: state.number, sequence: start.numbers.length > 0, seed: model.tables.flatMap((table) => table.rows).find((row) => row.name === "noise.seed")?.text });
  $("undo").disabled = !edits.canUndo();
  $("redo").disabled = !edits.canRedo();
}

function facts() {
  told = performance.now();
  const rate = rates.length > 2 ? (1000 * (rates.length - 1)) / (rates.at(-1) - rates[0]) : 0;
  const parts = [`${frame.full_width} × ${frame.full_height}`, `${shown(frame.ms, 3)} ms`, `promised ${shown(frame.promised, 2)}`, frame.method];
  if (frame.every > 1) parts.push("half size while moving");
  if (rate > 0 && (state.running || dragging)) parts.push(`${rate.toFixed(0)} frames/s`);
  if (state.running || state.number > 0) parts.push(`frame ${state.number}`);
  $("facts").textContent = parts.join("  ·  ");
  $("right-tag").textContent = `${frame.quantity} [${frame.unit}]`;
  if (frame.warnings.length > 0) $("facts").append(Object.assign(document.createElement("p"), { className: "warn", textContent: frame.warnings.join("\n") }));
  showLeftOut($("left-out"), frame);
}

/** The picture on the left: the scene, or another sensor's. */
async function showLeft() {
  const key = JSON.stringify([state.left, state.left === "kept" ? state.kept : null, start.numbers.length > 0 || state.left !== "scene" ? state.number : 0, state.tolerance, state.stage]);
  if (key === leftKey) return;
  leftKey = key;
  try {
    if (state.left === "scene" || !view.scene) {
      const scene = await picture("scene", { edits: edits.current(), number: state.number });
      view.scene = { ...scene, pixels: null };
      view.setPicture(0, scene, [scene.step_x_um * scene.every, scene.step_y_um * scene.every]);
      $("left-tag").textContent = `scene: ${scene.quantity} [${scene.unit}]`;
    }
    if (state.left !== "scene") {
      const list = state.left === "kept" ? (state.kept ?? []) : [];
      const other = await picture("frame", { ...request(), edits: list, tab: `${tab}-left`, generation: (showLeft.count = (showLeft.count ?? 0) + 1), every: 1 });
      view.setPicture(0, other, pixelStep(other));
      $("left-tag").textContent = `${state.left === "kept" ? "kept sensor" : "start"}: ${other.quantity} [${other.unit}]`;
    }
  } catch (error) {
    leftKey = "";
    if (error instanceof Refused && error.status !== 409) problem(error);
  }
}

/** Something moves. */
function changed() {
  pump();
  figures();
}
/** Something has come to rest: the forms, the texts and the link follow. */
function settled() {
  changed();
  showModel();
  showLeft();
  texts();
  remember();
}

function remember() {
  const { tolerance, stage, palette, left, kept } = state;
  history.replaceState(null, "", `#${token}/${edits.encode({ edits: edits.current(), tolerance, stage, palette, left, kept })}`);
}

function toggleRun() {
  state.running = !state.running;
  $("run").setAttribute("aria-pressed", String(state.running));
  $("run").textContent = state.running ? "Freeze" : "Run";
  rates.length = 0;
  if (state.running) pump();
  texts();
}

function setPalette(name) {
  state.palette = name;
  $("palette").value = name;
  view.setPalette(name);
  remember();
}
function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  if (page.figures) showFigures(page.figures);
  view.draw();
}

let valueAsking = false, valueAt = null;
async function values(um) {
  valueAt = um;
  if (valueAsking || !frame) return;
  valueAsking = true;
  while (valueAt) {
    const [x, y] = valueAt;
    valueAt = null;
    try {
      const found = await ask("value", { id: frame.id, edits: edits.current(), number: state.number, x_um: x, y_um: y });
      const one = (what, unit) => (what ? `${shown(what.value, 6)} ${unit} at ${what.x}, ${what.y}` : "outside");
      page.value = found;
      $("cursor").textContent = `scene ${one(found.before, view.scene?.unit ?? "")}   |   image ${one(found.after, frame.unit)}`;
    } catch (error) {
      if (!(error instanceof Refused)) break;
    }
  }
  valueAsking = false;
}

function pointers() {
  const canvas = $("view");
  let held = null;
  const setDivider = (share) => {
    view.divider = Math.min(Math.max(share, 0), 1);
    $("divider").value = view.divider * 1000;
    view.draw();
  };
  canvas.onpointerdown = (event) => {
    const box = canvas.getBoundingClientRect(), x = (event.clientX - box.left) / box.width;
    held = { x: event.clientX, y: event.clientY, divider: Math.abs(x - view.divider) * box.width < 8 };
    canvas.setPointerCapture(event.pointerId);
  };
  canvas.onpointermove = (event) => {
    const box = canvas.getBoundingClientRect();
    if (held?.divider) setDivider((event.clientX - box.left) / box.width);
    else if (held) {
      const ratio = canvas.width / box.width;
      view.moveBy((held.x - event.clientX) * ratio, (held.y - event.clientY) * ratio);
      held = { ...held, x: event.clientX, y: event.clientY };
    }
    canvas.style.cursor = Math.abs((event.clientX - box.left) / box.width - view.divider) * box.width < 8 ? "ew-resize" : "crosshair";
    values(view.place(event));
  };
  canvas.onpointerup = canvas.onpointercancel = () => { held = null; };
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    view.zoomBy(2 ** (event.deltaY / 300), view.place(event));
  }, { passive: false });
  canvas.onkeydown = (event) => {
    const step = canvas.width / 10;
    const act = {
      ArrowLeft: () => view.moveBy(-step, 0), ArrowRight: () => view.moveBy(step, 0), ArrowUp: () => view.moveBy(0, -step), ArrowDown: () => view.moveBy(0, step),
      "+": () => view.zoomBy(1 / 1.25), "=": () => view.zoomBy(1 / 1.25), "-": () => view.zoomBy(1.25), 0: () => view.fit(),
      "[": () => setDivider(view.divider - 0.02), "]": () => setDivider(view.divider + 0.02),
    }[event.key];
    if (!act || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    act();
  };
  $("divider").oninput = () => setDivider(Number($("divider").value) / 1000);
}

function bars() {
  $("undo").onclick = () => { edits.undo(); settled(); };
  $("redo").onclick = () => { edits.redo(); settled(); };
  $("run").onclick = toggleRun;
  $("keep").onclick = () => { state.kept = edits.current(); state.left = $("left").value = "kept"; baseline = null; settled(); };
  $("left").onchange = () => {
    if ($("left").value === "kept" && !state.kept) state.kept = edits.current();
    state.left = $("left").value;
    baseline = null;
    settled();
  };
  $("stage").onchange = () => { state.stage = $("stage").value; settled(); };
  $("palette").onchange = () => setPalette($("palette").value);
  $("range").onchange = () => { view.range = $("range").value; view.draw(); };
  $("contrast").oninput = () => { view.contrast = Number($("contrast").value); view.draw(); };
  $("brightness").oninput = () => { view.brightness = Number($("brightness").value); view.draw(); };
  $("fit").onclick = () => view.fit();
  $("number").oninput = () => { state.number = start.numbers[Number($("number").value)]; changed(); showLeft(); texts(); };
  for (const id of ["angle", "unit", "temperature"]) $(id).onchange = figures;
  $("tolerance").oninput = () => { state.tolerance = Number((10 ** (Number($("tolerance").value) / 100)).toPrecision(2)); showTolerance(); lastName = null; changed(); };
  $("tolerance").onchange = settled;
  $("tolerance-default").onclick = () => { state.tolerance = null; showTolerance(); settled(); };
  $("theme").onclick = () => setTheme(dark() ? "light" : "dark");
  $("help").onclick = () => $("keys").showModal();
  $("find").oninput = () => controls.filter($("find").value);
  $("save").onclick = () => download(saved(), [model.text], "application/toml");
  for (const format of ["png", "exr"]) $(format).onclick = async () => download(`frame.${format}`, [await bytes("file", { id: frame.id, format })], format === "png" ? "image/png" : "image/x-exr");
  const copy = async (text, button) => {
    await navigator.clipboard.writeText(text);
    const words = button.textContent;
    button.textContent = "Copied";
    setTimeout(() => { button.textContent = words; }, 1200);
  };
  $("link").onclick = () => copy(location.href, $("link"));
  $("copy-command").onclick = () => copy($("command").textContent, $("copy-command"));
  $("copy-difference").onclick = () => copy($("difference").textContent, $("copy-difference"));
  document.addEventListener("keydown", (event) => {
    const typing = event.target.matches("input[type=text], input[type=search], input[type=number], select, textarea");
    const control = event.ctrlKey || event.metaKey, key = event.key.toLowerCase();
    if (control && (key === "z" || key === "y") && !typing) {
      event.preventDefault();
      if (key === "y" || event.shiftKey) edits.redo();
      else edits.undo();
      settled();
    }
    if (control || event.altKey || typing) return;
    if (key === "f") toggleRun();
    if (key === "k") $("keep").click();
    if (key === "p") setPalette(palettes[(palettes.indexOf(state.palette) + 1) % palettes.length]);
    if (key === "i") setPalette(state.palette === "black hot" ? "white hot" : "black hot");
    if (key === "/") { event.preventDefault(); $("find").focus(); }
  });
}

const dark = () => (document.documentElement.dataset.theme ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light")) === "dark";
function showTolerance() {
  $("tolerance-text").textContent = state.tolerance === null ? "default" : state.tolerance.toExponential(1);
  if (state.tolerance !== null) $("tolerance").value = 100 * Math.log10(state.tolerance);
}

/** What tests read: the page's own state, nothing computed for them. */
const page = (window.mtfLive = {
  figures: null, value: null, state, view,
  get frame() { return frame; },
  get edits() { return edits.current(); },
  get busy() { return asking || asking2 || wanted || wanted2 || dragging; },
  get text() { return model?.text; },
  get curves() { return curves.values; },
});

async function begin() {
  start = await ask("start", {});
  state.tolerance = start.tolerance;
  const link = location.hash.slice(1).split("/")[1];
  const restored = link ? edits.decode(link) : null;
  if (restored) {
    edits.restore(restored.edits);
    for (const key of ["tolerance", "stage", "palette", "left", "kept"]) state[key] = restored[key] ?? state[key];
  }
  if (start.numbers.length > 0) {
    state.number = start.numbers[0];
    $("number-label").hidden = false;
    $("number").max = start.numbers.length - 1;
  }
  $("left").value = state.left;
  pointers();
  bars();
  setPalette(state.palette);
  showTolerance();
  await showLeft();
  pump();
  ask("model", { edits: [] }).then((first) => {
    controls.remember(first);
    return showModel();
  });
  figures();
  stay(() => { $("overlay").textContent = "The server has ended. Start mtf live again and open its new address."; $("overlay").hidden = false; }, () => { $("overlay").hidden = true; });
}

begin().catch((error) => {
  $("overlay").textContent = error.status === 403 ? "This address has no valid token: open the one that mtf live has printed." : error.message;
  $("overlay").hidden = false;
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { if (page.figures) showFigures(page.figures); view.draw(); });
