// SPDX-License-Identifier: Apache-2.0
// Buttons, menus and keys around the pictures, and the link in the address.

import { bytes, token } from "./api.js";
import { $, app, inSpace, state } from "./app.js";
import { download } from "./files.js";
import { shown } from "./figures.js";
import * as edits from "./history.js";
import { names as palettes } from "./palettes.js";
import { clearProblem, figures, problem, savedName, sceneFile, setPlace, showFigures, showModel, showTolerance, texts } from "./panels.js";
import { forgetLeft, pump, run } from "./pictures.js";

/** Something moves. */
export function changed() {
  clearProblem(true);
  pump();
  figures();
}
/** Something has come to rest: the forms, the texts and the link follow. */
export function settled() {
  clearProblem(true);
  follow();
}
/** An edit is no more: everything follows but the words about it. */
export function follow() {
  pump();
  figures();
  showModel();
  texts();
  remember();
}
/** The camera has come to rest, `before` is where it was, or the scene's file has changed: no number of the sensor has. */
export async function placed(before) {
  if (before) edits.moved(before);
  pump();
  remember();
  await sceneFile().catch(() => {});
  texts();
}

function remember() {
  const { tolerance, stage, palette, left, place } = state;
  const link = { edits: edits.current(1), kept: edits.current(0), scene: edits.current(edits.SCENE), number: state.number, tolerance, stage, palette, left, place, editing: edits.side(), view: app.place?.request() };
  history.replaceState(null, "", `${location.search}#${token}/${edits.encode(link)}`);
}

export function toggleRun() {
  state.running = !state.running;
  $("run").setAttribute("aria-pressed", String(state.running));
  $("run").textContent = state.running ? "Pause" : "Play";
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
  for (const id of ["edit-a", "edit-b"]) $(id).disabled = left !== "kept";
  if (left !== "kept") setEditing(1);
  forgetLeft();
}

/** Undo or redo, which may have moved the camera. */
function back(move) {
  move();
  settled();
  if (inSpace()) placed();
}

/** What the ends of the palette are, on the right; no more often than can be read. */
let scaled = "", calm = null;
function showScale() {
  if (calm) return;
  calm = setTimeout(() => {
    calm = null;
    const { view } = app, ends = view.shownEnds(1), text = ends ? ends.map((value) => shown(value, 4)) : ["", ""];
    const key = `${text} ${state.palette}`;
    if (key === scaled) return;
    scaled = key;
    [$("black").value, $("white").value] = [text[0], ends ? `${text[1]} ${app.frames[1]?.unit ?? ""}` : ""];
    const context = $("ramp").getContext("2d"), image = context.createImageData(64, 8);
    for (let i = 0; i < 64 * 8; i += 1) image.data.set(view.colours.subarray(4 * (i % 64) * 4, 4 * (i % 64) * 4 + 4), 4 * i);
    context.putImageData(image, 0, 0);
  }, 150);
}

/** Where the curves are of. */
function showMark() {
  const at = app.figures?.over_field && state.place ? app.view.onPage(state.place) : null;
  $("mark").hidden = !at;
  if (at) [$("mark").style.left, $("mark").style.top] = at.map((px) => `${px}px`);
}

export function bars() {
  const { view, controls } = app;
  view.changedScale = () => { showScale(); showMark(); };
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
  for (const id of ["contrast", "brightness"]) $(id).ondblclick = () => { $(id).value = 0; $(id).oninput(); };
  $("contrast").oninput = () => { view.contrast = Number($("contrast").value); view.draw(); };
  $("brightness").oninput = () => { view.brightness = Number($("brightness").value); view.draw(); };
  $("fit").onclick = () => view.fit();
  $("home").onclick = () => { app.place.home(); app.place.moved("camera.range"); };
  $("number").oninput = () => { state.number = app.start.numbers[Number($("number").value)]; changed(); texts(); };
  $("first-frame").onclick = () => { state.number = app.start.numbers[0] ?? 0; $("number").value = 0; settled(); };
  for (const id of ["angle", "unit", "temperature"]) $(id).onchange = figures;
  $("axis").onclick = () => setPlace(null);
  $("tolerance").oninput = () => { state.tolerance = Number((10 ** (Number($("tolerance").value) / 100)).toPrecision(2)); showTolerance(true); app.lastName = null; changed(); };
  $("tolerance").onchange = settled;
  $("tolerance-default").onclick = () => { state.tolerance = null; showTolerance(); settled(); };
  $("theme").onclick = () => { document.documentElement.dataset.theme = dark() ? "light" : "dark"; redraw(); };
  $("help").onclick = () => $("keys").showModal();
  $("find").oninput = () => { $("nothing").hidden = [controls, app.sceneControls].map((forms) => forms.filter($("find").value)).some(Boolean); };
  $("save").onclick = () => download(savedName(app.start.sensor, "sensor.toml"), [app.model.text], "application/toml");
  $("save-scene").onclick = async () => download(savedName(app.start.scene, "scene.toml"), [await sceneFile()], "application/toml");
  $("shot").onclick = async () => {
    const bar = 32, canvas = await view.copy(bar), pen = canvas.getContext("2d"), { width } = canvas, y = canvas.height - bar;
    pen.fillStyle = "#fff";
    pen.fillRect(0, y, width, bar);
    pen.drawImage($("ramp"), width / 4, y + 8, width / 2, 16);
    Object.assign(pen, { fillStyle: "#000", font: "14px sans-serif", textBaseline: "middle" });
    for (const [id, align, x] of [["black", "right", width / 4 - 8], ["white", "left", (3 * width) / 4 + 8]]) {
      pen.textAlign = align;
      pen.fillText($(id).textContent, x, y + bar / 2, width / 4 - 16);
    }
    download("picture.png", [await new Promise((resolve) => canvas.toBlob(resolve))], "image/png");
  };
  for (const format of ["png", "exr"]) $(format).onclick = async () => {
    const frame = () => app.frames[edits.side()], refused = () => app.stale[edits.side()] || !frame();
    while (!refused() && (frame().light_lags || frame().correction_lags || frame().solving || (frame().preview && inSpace()))) await new Promise((resolve) => setTimeout(resolve, 50)); // a preview is never saved
    if (refused()) return problem({ message: "There is no picture of the present values to save: mend what is refused first." });
    download(`frame.${format}`, [await bytes("file", { id: frame().id, format })], format === "png" ? "image/png" : "image/x-exr");
  };
  const copy = async (text, button) => {
    await navigator.clipboard.writeText(text);
    const words = button.textContent;
    button.textContent = "Copied";
    setTimeout(() => { button.textContent = words; }, 1200);
  };
  $("link").onclick = () => { remember(); copy(location.href, $("link")); };
  $("copy-command").onclick = () => copy($("command").textContent, $("copy-command"));
  $("copy-difference").onclick = () => copy($("difference").textContent, $("copy-difference"));
  document.addEventListener("keydown", keys);
}

function keys(event) {
  const typing = event.target.matches("input[type=text], input[type=search], input[type=number], select, textarea");
  const control = event.ctrlKey || event.metaKey, key = event.key.toLowerCase();
  // In a text that is being written the browser's own undo is meant.
  const writing = typing && event.target.matches("input") && event.target.value !== (event.target.dataset.shown ?? "");
  if (control && (key === "z" || key === "y") && !writing) {
    event.preventDefault();
    back(key === "y" || event.shiftKey ? edits.redo : edits.undo);
  }
  if (key === "escape" && !writing && app.stale.some(Boolean) && !document.querySelector("dialog[open], :popover-open")) return back(edits.toGood);
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
