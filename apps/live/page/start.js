// SPDX-License-Identifier: Apache-2.0
// The page at work: what it is made of, what a link restores, what tests read.

import { Gone, ask, stay } from "./api.js";
import { $, app, inSpace, state } from "./app.js";
import { bars, changed, follow, placed, redraw, setEditing, setLeft, setPalette, settled, showKind } from "./bars.js";
import { Controls } from "./controls.js";
import { Curves } from "./figures.js";
import * as edits from "./history.js";
import * as panels from "./panels.js";
import { Place } from "./place.js";
import * as pictures from "./pictures.js";
import { pointers, setDivider } from "./pointers.js";
import { View } from "./view.js";

const PATIENCE_MS = 500;
const starting = ask("start", {}); // is answered while the page is put together
starting.catch(() => {});
app.view = new View($("view"), () => {});
app.curves = new Curves($("curves"), $("legend"));
app.controls = new Controls($("forms"), {
  drag(name, text) { app.lastName = name; app.dragging = true; edits.drag(name, text); changed(); },
  drop() { app.dragging = false; edits.drop(); settled(); },
  set(name, text) { app.lastName = name; edits.set(name, text); settled(); },
  unset(name) { app.lastName = name; edits.unset(name); settled(); },
  reset(name, text) { app.lastName = name; edits.reset(name, text); settled(); },
  add(edit) { app.lastName = edit[1]; edits.add(edit); settled(); },
  stay: settled,
}, ["optics"]);
// Another heat balance takes seconds: pictures follow once a slider is let go.
let held = null;
const sceneEdit = (name) => { app.lastName = name; return edits.SCENE; };
app.sceneControls = new Controls($("scene-forms"), {
  drag(name, text) { held = [name, text]; },
  drop() { if (held) this.set(...held); held = null; },
  set(name, text) { edits.set(name, text, sceneEdit(name)); settled(); placed(); },
  unset(name) { edits.unset(name, sceneEdit(name)); settled(); placed(); },
  reset(name, text) { edits.reset(name, text, sceneEdit(name)); settled(); placed(); },
  stay: settled,
}, ["weather"]);

/** What tests read: the page's own state, nothing computed for them. */
window.mtfLive = {
  state,
  get view() { return app.view; },
  get place() { return app.place; },
  get figures() { return app.figures; },
  get value() { return app.value; },
  get frame() { return app.frames[1]; },
  get frames() { return app.frames; },
  get edits() { return edits.current(); },
  get sceneEdits() { return edits.current(edits.SCENE); },
  get waits() { return { start: !app.start, pictures: pictures.isBusy(), panels: panels.isBusy(), dragging: app.dragging, camera: Boolean(app.place?.moving) }; },
  get inWork() { return pictures.inWork(); },
  get busy() { return Object.values(this.waits).some(Boolean); },
  get text() { return app.model?.text; },
  get curves() { return app.curves.values; },
};

function restore() {
  const link = location.hash.slice(1).split("/")[1], restored = link ? edits.decode(link) : null;
  if (!restored) return;
  edits.restore(restored.kept, restored.edits, restored.scene);
  for (const key of ["tolerance", "stage", "palette", "left", "number", "place"]) state[key] = restored[key] ?? state[key];
  app.place?.restore(restored.view);
  if (state.left === "kept" && restored.editing === 0) setEditing(0);
}

const ENDED = "The server has ended. The sensor file can still be saved here; then start mtf live again and open its new address.";
const overlay = (text) => { $("overlay").textContent = text; $("overlay").hidden = text === ""; };

async function begin() {
  let start = await starting;
  for (; start.waiting !== undefined; start = await ask("start", {})) overlay(start.waiting); // answered late: no loop without rest
  app.start = start;
  overlay(inSpace() ? "The first picture is being made." : "");
  state.tolerance = app.start.tolerance;
  if (inSpace()) {
    app.place = new Place($("place"), app.start.space, () => pictures.pump(), placed);
    edits.follow(() => app.place.request(), (view) => app.place.restore(view), () => app.place.moving && app.place.rest());
  }
  showKind();
  restore();
  if (app.start.numbers.length > 0) {
    const { numbers } = app.start;
    if (!numbers.includes(state.number)) [state.number] = numbers;
    $("number-label").hidden = false;
    $("number").max = numbers.length - 1;
    $("number").value = numbers.indexOf(state.number);
  }
  const side = edits.side();
  setLeft(state.left);
  if (state.left === "kept") setEditing(side);
  bars();
  $("divider").oninput = () => setDivider(Number($("divider").value) / 1000);
  setPalette(state.palette);
  panels.showTolerance();
  panels.onRefusedEdit(follow);
  // Pictures come first, forms and curves when the first is there, or takes its time.
  await Promise.race([pictures.pump(), new Promise((resolve) => setTimeout(resolve, PATIENCE_MS))]);
  app.view.useGraphicsCard();
  pointers();
  ask("model", { edits: [] }).then((first) => {
    app.controls.remember(first);
    if (first.scene) app.sceneControls.remember(first.scene);
    return panels.showModel();
  });
  panels.figures();
  stay(() => overlay(ENDED), () => overlay(""));
}

begin().catch((error) => overlay(error.status === 403 ? "This address has no valid token: open the one that mtf live has printed." : error instanceof Gone ? ENDED : error.message));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
