// SPDX-License-Identifier: Apache-2.0
// Mouse and keys on the picture: divider, zoom and place of an image, camera of a 3-D scene; values under the cursor.

import { ask, Refused } from "./api.js";
import { $, app, inSpace, moving, state } from "./app.js";
import { shown } from "./figures.js";
import * as edits from "./history.js";
import { setPlace } from "./panels.js";

const STILL_PX = 3; // a click moves less
let asking = false, at = null, over = null; // over: where the mouse is on the picture
const show = (text) => { $("cursor").textContent = text; };

/** Values belong to the picture that is seen: none are shown while that changes, or without the mouse. */
async function values(um) {
  at = um;
  if (moving()) return show("");
  if (asking || !app.frames[1]) return;
  asking = true;
  while (at) {
    const [x, y] = at;
    at = null;
    const of = (side) => ask("value", { id: app.frames[side].id, edits: edits.current(1), number: state.number, x_um: x, y_um: y });
    const one = (what, unit) => (what ? `${shown(what.value, 6)} ${unit} at ${what.x}, ${what.y}` : "outside");
    try {
      const pair = state.left === "scene" || !app.frames[0] ? null : await of(0), found = await of(1);
      app.value = found;
      const left = pair ? `${state.left === "kept" ? "A" : "start"} ${one(pair.after, app.frames[0].unit)}   |   ${state.left === "kept" ? "B" : "image"}` : "image";
      if (over && !moving()) show(`scene ${one(found.before, app.scene?.unit ?? "")}   |   ${left} ${one(found.after, app.frames[1].unit)}`);
    } catch (error) {
      show("");
      if (!(error instanceof Refused)) break;
    }
  }
  asking = false;
}

export function setDivider(share) {
  app.view.divider = Math.min(Math.max(share, 0), 1);
  $("divider").value = app.view.divider * 1000;
  app.view.draw();
}

export function pointers() {
  const canvas = $("view"), { view } = app;
  app.cursor = view.changed = () => over && values(view.place(over));
  canvas.onpointerleave = () => {
    over = null;
    show("");
  };
  let held = null;
  const nearDivider = (event, box) => Math.abs((event.clientX - box.left) / box.width - view.divider) * box.width < 8;
  canvas.onpointerdown = (event) => {
    held = { x: event.clientX, y: event.clientY, divider: nearDivider(event, canvas.getBoundingClientRect()), pan: event.shiftKey || event.button !== 0 };
    canvas.setPointerCapture(event.pointerId);
    if (inSpace() && !held.divider) app.place.hold(true);
  };
  canvas.onpointermove = (event) => {
    const box = canvas.getBoundingClientRect(), ratio = canvas.width / box.width;
    canvas.style.cursor = nearDivider(event, box) ? "ew-resize" : inSpace() ? "move" : "crosshair";
    over = { clientX: event.clientX, clientY: event.clientY };
    values(view.place(event));
    if (!held) return;
    const x = event.clientX - held.x, y = event.clientY - held.y;
    if (held.divider) return setDivider((event.clientX - box.left) / box.width);
    if (!held.moved && Math.hypot(x, y) < STILL_PX) return;
    held = { ...held, x: event.clientX, y: event.clientY, moved: true };
    if (!inSpace()) view.moveBy(-x * ratio, -y * ratio);
    else if (held.pan) app.place.panBy(-x * ratio * view.scale(), y * ratio * view.scale());
    else app.place.orbitBy(-x * 0.4, y * 0.3);
  };
  canvas.onpointerup = canvas.onpointercancel = (event) => {
    const clicked = held && !held.divider && !held.pan && !held.moved && event.type === "pointerup";
    held = null;
    app.place?.hold(false);
    if (!clicked || !app.figures?.over_field) return;
    const um = view.place(event), { full_width, full_height, step_x_um, step_y_um } = app.frames[1];
    if (um[0] >= 0 && um[1] >= 0 && um[0] < full_width * step_x_um && um[1] < full_height * step_y_um) setPlace(um);
  };
  canvas.oncontextmenu = (event) => inSpace() && event.preventDefault();
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    if (inSpace() && !event.ctrlKey) app.place.nearBy(2 ** (event.deltaY / 500));
    else view.zoomBy(2 ** (event.deltaY / 300), view.place(event));
  }, { passive: false });
  canvas.onkeydown = (event) => {
    const act = { "[": () => setDivider(view.divider - 0.02), "]": () => setDivider(view.divider + 0.02), ...(inSpace() ? app.place.keys(event.shiftKey) : plainKeys(canvas)) }[event.key];
    if (!act || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    act();
  };
}

function plainKeys(canvas) {
  const step = canvas.width / 10, { view } = app;
  return {
    ArrowLeft: () => view.moveBy(-step, 0), ArrowRight: () => view.moveBy(step, 0), ArrowUp: () => view.moveBy(0, -step), ArrowDown: () => view.moveBy(0, step),
    "+": () => view.zoomBy(1 / 1.25), "=": () => view.zoomBy(1 / 1.25), "-": () => view.zoomBy(1.25), 0: () => view.fit(),
  };
}
