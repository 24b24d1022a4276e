// SPDX-License-Identifier: Apache-2.0
// What the modules of the page share: its state, what the server has last said, the helpers that all of them use.
// Side 0 is left of the divider, side 1 right of it.

import * as edits from "./history.js";

export const $ = (id) => document.getElementById(id);

/** What a link restores, with the lists of edits. `place`: in the focal plane, um, whose curves are shown; null: the axis. */
export const state = { tolerance: null, stage: "", number: 0, running: false, left: "scene", palette: "white hot", place: null };

export const app = {
  tab: Array.from(crypto.getRandomValues(new Uint32Array(2)), (n) => n.toString(36)).join(""),
  start: null, // answer of `start`
  model: null, // of the sensor that the sliders edit
  frames: [null, null], // facts of the pictures that are shown
  scene: null, // facts of the scene
  figures: null,
  value: null, // under the cursor
  view: null, curves: null, controls: null, sceneControls: null, place: null,
  dragging: false, // a slider
  stale: [false, false], // the picture of a side is not of the present values, which are refused
  cursor: () => {}, // asks for the values under the cursor once more
  lastName: null, // of the control that was used last: what is wrong is said there
};

export const inSpace = () => Boolean(app.start?.space);
/** While something moves pictures may be quicker and coarser. */
export const moving = () => app.dragging || Boolean(app.place?.moving);

/** Edits of a side: of the left one, where it shows a sensor. */
export const editsOf = (side) => (side === 1 || state.left === "kept" ? edits.current(side) : []);

/** Edits of the file of a 3-D scene, as a part of a request. */
export const ofScene = () => (inSpace() ? { scene: edits.current(edits.SCENE) } : {});

/** What every request of a frame says beside its edits. */
export const wanted = () => ({ number: state.number, tolerance: state.tolerance, stage: state.stage, ...ofScene(), ...app.place?.request() });
