// SPDX-License-Identifier: Apache-2.0
// Buttons, menus and keys around the pictures, and the link in the address.

import { bytes, token } from "./api.js";
import { $, app, inSpace, state } from "./app.js";
import { download } from "./files.js";
import * as edits from "./history.js";
import { names as palettes } from "./palettes.js";
import { figures, savedName, sceneFile, showFigures, showModel, showTolerance, texts } from "./panels.js";
import { forgetLeft, pump, run } from "./pictures.js";

/** Something moves. */
export function changed() {
  pump();
  figures();
}
/** Something has come to rest: the forms, the texts and the link follow. */
export function settled() {
  changed();
  showModel();
  texts();
  remember();
}
/** The camera has come to rest, `before` is where it was: no number of the sensor has changed. */
export async function placed(before) {
  if (before) edits.moved(before);
  pump();
  remember();
  await sceneFile().catch(() => {});
  texts();
}

function remember() {
  const { tolerance, stage, palette, left } = state;
  const link = { edits: edits.current(1), kept: edits.current(0), tolerance, stage, palette, left, editing: edits.side(), view: app.place?.request() };
  history.replaceState(null, "", `${location.search}#${token}/${edits.encode(link)}`);
}

export function toggleRun() {
  state.running = !state.running;
  $("run").setAttribute("aria-pressed", String(state.running));
  $("run").textContent = state.running ? "Freeze" : "Run";
  run(() => state.running && toggleRun());
  texts();
}

export function setPalette(name) {
  state.palette = name;
  $("palette").value = name;
  app.view.setPalette(name);
  remember();
}

const dark = () => (document.documentElement.dataset.theme ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light")) === "dark";
export function redraw() {
  if (app.figures) showFigures(app.figures);
  app.view.draw();
}

/** Which sensor the sliders edit. */
export function setEditing(side) {
  edits.edit(side);
  for (const [i, id] of ["edit-a", "edit-b"].entries()) $(id).setAttribute("aria-pressed", String(i === side));
}

export function setLeft(left) {
  state.left = $("left").value = left;
  $("sides").hidden = left !== "kept";
  if (left !== "kept") setEditing(1);
  forgetLeft();
}

/** Undo or redo, which may have moved the camera. */
function back(move) {
  move();
  settled();
  if (inSpace()) placed();
}

export function bars() {
  const { view, controls } = app;
  $("undo").onclick = () => back(edits.undo);
  $("redo").onclick = () => back(edits.redo);
  $("run").onclick = toggleRun;
  $("keep").onclick = () => { edits.keep(); setLeft("kept"); setEditing(1); settled(); };
  $("left").onchange = () => {
    if ($("left").value === "kept" && edits.current(0).length === 0) edits.keep();
    setLeft($("left").value);
    settled();
  };
  for (const [side, id] of ["edit-a", "edit-b"].entries()) $(id).onclick = () => { setEditing(side); settled(); };
  $("stage").onchange = () => { state.stage = $("stage").value; settled(); };
  $("palette").onchange = () => setPalette($("palette").value);
  $("range").onchange = () => { view.range = $("range").value; view.draw(); };
  $("contrast").oninput = () => { view.contrast = Number($("contrast").value); view.draw(); };
  $("brightness").oninput = () => { view.brightness = Number($("brightness").value); view.draw(); };
  $("fit").onclick = () => view.fit();
  $("home").onclick = () => { app.place.home(); app.place.moved("camera.range"); };
  $("number").oninput = () => { state.number = app.start.numbers[Number($("number").value)]; changed(); texts(); };
  for (const id of ["angle", "unit", "temperature"]) $(id).onchange = figures;
  $("tolerance").oninput = () => { state.tolerance = Number((10 ** (Number($("tolerance").value) / 100)).toPrecision(2)); showTolerance(); app.lastName = null; changed(); };
  $("tolerance").onchange = settled;
  $("tolerance-default").onclick = () => { state.tolerance = null; showTolerance(); settled(); };
  $("theme").onclick = () => { document.documentElement.dataset.theme = dark() ? "light" : "dark"; redraw(); };
  $("help").onclick = () => $("keys").showModal();
  $("find").oninput = () => controls.filter($("find").value);
  $("save").onclick = () => download(savedName(app.start.sensor, "sensor.toml"), [app.model.text], "application/toml");
  $("save-scene").onclick = async () => download(savedName(app.start.scene, "scene.toml"), [await sceneFile()], "application/toml");
  for (const format of ["png", "exr"]) $(format).onclick = async () => {
    const frame = () => app.frames[edits.side()];
    while (frame().light_lags || (frame().preview && inSpace())) await new Promise((resolve) => setTimeout(resolve, 50)); // a preview is never saved
    download(`frame.${format}`, [await bytes("file", { id: frame().id, format })], format === "png" ? "image/png" : "image/x-exr");
  };
  const copy = async (text, button) => {
    await navigator.clipboard.writeText(text);
    const words = button.textContent;
    button.textContent = "Copied";
    setTimeout(() => { button.textContent = words; }, 1200);
  };
  $("link").onclick = () => copy(location.href, $("link"));
  $("copy-command").onclick = () => copy($("command").textContent, $("copy-command"));
  $("copy-difference").onclick = () => copy($("difference").textContent, $("copy-difference"));
  document.addEventListener("keydown", keys);
}

function keys(event) {
  const typing = event.target.matches("input[type=text], input[type=search], input[type=number], select, textarea");
  const control = event.ctrlKey || event.metaKey, key = event.key.toLowerCase();
  if (control && (key === "z" || key === "y") && !typing) {
    event.preventDefault();
    back(key === "y" || event.shiftKey ? edits.redo : edits.undo);
  }
  if (control || event.altKey || typing) return;
  const act = {
    f: toggleRun, k: () => $("keep").click(), p: () => setPalette(palettes[(palettes.indexOf(state.palette) + 1) % palettes.length]),
    i: () => setPalette(state.palette === "black hot" ? "white hot" : "black hot"), "/": () => $("find").focus(),
    a: () => state.left === "kept" && $("edit-a").click(), b: () => state.left === "kept" && $("edit-b").click(),
  }[key];
  if (!act) return;
  if (key === "/") event.preventDefault();
  act();
}

/** What is on the page for a 3-D scene alone, or for an image alone. */
export function showKind() {
  for (const each of document.querySelectorAll("[data-for]")) each.hidden = (each.dataset.for === "space") !== inSpace();
}
