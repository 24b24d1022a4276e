// SPDX-License-Identifier: Apache-2.0
// The pictures on both sides of the divider. Each follows from a key: all that it depends on. One picture is asked for
// at a time, of the values of that moment; what has changed meanwhile is asked for next, and older values never are.

import { ask as post, Gone, GONE_MS, picture, Refused } from "./api.js";
import { $, app, editsOf, inSpace, moving, state, wanted } from "./app.js";
import * as edits from "./history.js";
import { clearProblem, facts, problem, say } from "./panels.js";

const SLOW_MS = 40; // a frame that takes longer is asked for as a preview while a slider moves
const CALM_MS = 150; // texts follow a moving slider no more often: pictures come first
const HEAT_MS = 400; // while a heat balance is worked out
const shown = [{}, {}]; // of each side: key of what is shown, whether it is for the moment, keys on the way and refused, turn
let asking = false, generation = 0, turn = 0, told = 0, fullMs = 0, timed = null, stepped = null;
const rates = [];

/** Edits that the scene's values depend on. */
const ofScene = () => edits.current(1).filter((edit) => edit[0] !== "set" || /^(scene|frame)\./.test(edit[1]));

/** What a side should show: a place to ask, its body, and the key of both; null where another answer brings it. */
function wish(side) {
  if (side === 0 && state.left === "scene") {
    if (inSpace()) return null;
    const body = { edits: edits.current(1), number: app.start.numbers.length > 0 ? state.number : 0 };
    return { from: "scene", body, key: JSON.stringify(["scene", ofScene(), body.number]) };
  }
  const body = { edits: editsOf(side), ...wanted() };
  if (inSpace()) Object.assign(body, { may_lag: true, before: side === 1 && state.left === "scene" });
  return { from: "frame", body, key: JSON.stringify(body) };
}

function needs(side) {
  const now = wish(side), last = shown[side];
  if (!now || now.key === last.refused || now.key === last.coming) return null;
  if (now.from === "scene" && app.dragging && last.key) return null; // no slider of the scene waits for it
  if (now.key !== last.key || (last.passing && !moving())) return now;
  return null;
}

/** The side whose turn it is. */
function next() {
  const order = edits.side() === 0 && state.left === "kept" ? [0, 1] : [1, 0];
  if (shown[order[0]].turn > (shown[order[1]].turn ?? 0) && needs(order[1])) order.reverse();
  if (!app.scene && !inSpace()) order.splice(0, 2, 0, 1); // the scene says how large pixels are
  for (const side of order) {
    const now = needs(side);
    if (now) return [side, now];
  }
  return null;
}

/** For the reader of a failed test: what is on its way, and what is wanted next. */
export const inWork = () => ({ asking, turn, shown, next: next() });

export const isBusy = () => asking || Boolean(app.start && app.view && next());

const stepOf = (picture) => [(picture.step_x_um ?? app.scene?.pitch_x_um ?? 1) * picture.every, (picture.step_y_um ?? app.scene?.pitch_y_um ?? 1) * picture.every];

const named = ({ quantity, unit }) => (quantity === unit ? quantity : `${quantity} [${unit}]`);

function showScene(scene, pixels) {
  app.scene = { ...app.scene, ...scene, pixels: null };
  app.view.setPicture(0, { ...scene, pixels }, stepOf(scene));
  shown[0].tag = `scene: ${named(scene)}`;
}

function showFrame(side, made, asked) {
  if (side === 1 && !app.frames[1]) $("overlay").hidden = true;
  const name = state.left === "kept" ? (side === 0 ? "A: " : "B: ") : side === 0 ? "start: " : "";
  app.frames[side] = { ...made, pixels: null, more: null };
  app.view.setPicture(side, made, stepOf(made));
  shown[side].tag = `${name}${named(made)}`;
  if (made.before) showScene(made.before, new Uint16Array(made.more, 0, made.before.width * made.before.height));
  if (side !== 1) return;
  if (!asked.preview) fullMs = asked.ms;
  rates.push(performance.now());
  if (rates.length > 30) rates.shift();
}

const rate = () => (rates.length > 2 ? (1000 * (rates.length - 1)) / (rates.at(-1) - rates[0]) : 0);

/** What is asked for now may be quicker and coarser. */
const inHaste = () => moving() && (fullMs > SLOW_MS || Boolean(app.place?.moving));

/** `begun` hears when the answer begins; the picture is shown once the promise `before` is kept. */
async function ask(side, { from, body, key }, begun, before) {
  if (inSpace() && timed !== app.lastName) [timed, fullMs] = [app.lastName, 0]; // most sensor sliders leave the view as it is
  const begin = performance.now(), preview = inHaste();
  app.view.moving = moving() || state.running;
  const every = preview ? Math.max(inSpace() && !app.view.coarse ? 1 : 2, app.view.drawsEvery(side)) : 1;
  const request = from === "scene" ? body : { ...body, tab: `${app.tab}-${side}`, side: side === 0 ? "left" : "right", generation: (generation += 1), preview, every };
  Object.assign(shown[side], { coming: key, turn: (turn += 1) });
  const ticking = setInterval(() => {
    $("busy-tag").textContent = `computing, ${Math.round((performance.now() - begin) / 1000)} s`;
    $("busy-tag").hidden = false;
    // What is no longer wanted is not waited for.
    if (from === "frame" && !moving() && wish(side)?.key !== key) post("stop", { tab: request.tab, generation: request.generation }).catch(() => {});
  }, 1000);
  try {
    const made = await picture(from, request, begun);
    await before;
    Object.assign(shown[side], { key, passing: from === "frame" && (made.preview || made.light_lags || made.correction_lags || made.solving) });
    if (from === "scene") showScene(made, made.pixels);
    else showFrame(side, made, { preview, ms: performance.now() - begin });
    if (from === "frame" && app.view.moving) requestAnimationFrame(() => app.view.lagged(performance.now() - begin - made.ms));
    settleProblem();
    app.cursor();
    if (app.frames[1] && (!(moving() || state.running) || performance.now() - told > CALM_MS)) {
      told = performance.now();
      facts(shown.map((one) => one.tag), rate());
    }
    if (side === 1 && state.running) step();
    // The light of now, or the temperatures, are being made: until then the same picture comes again and again.
    if ((made.light_lags || made.solving) && !moving()) return new Promise((resolve) => setTimeout(resolve, made.solving ? HEAT_MS : CALM_MS));
  } catch (error) {
    if (error instanceof Gone) return new Promise((resolve) => setTimeout(resolve, GONE_MS));
    if (!(error instanceof Refused)) throw error;
    if (error.status === 409) return undefined;
    await before;
    Object.assign(shown[side], { refused: key, error });
    if (side === 1) $("overlay").hidden = true; // the words stand at the control, which has to be within reach
    problem(error, body, from === "scene" ? 1 : side);
    settleStale();
    if (!app.frames[1] && app.place?.toStart()) $("problem").textContent = `The camera of the link: ${error.message}`;
    if (state.running) stepped?.();
  } finally {
    clearInterval(ticking);
    $("busy-tag").hidden = true;
    if (shown[side].coming === key) shown[side].coming = null;
  }
  return undefined;
}

async function askAll() {
  let drawn = null, last = null;
  if (!inSpace() && !shown[0].key && !shown[1].key) await Promise.all([0, 1].map((side) => ask(side, wish(side)))); // the first ones
  for (let now = next(); now; now = next()) {
    const before = last;
    await new Promise((begun) => { last = ask(...now, begun, before).finally(begun); });
    await before;
    if (!(inSpace() && inHaste())) await last; // of a moving 3-D scene the next one is made while this one is on its way
    await drawn;
    drawn = new Promise((resolve) => requestAnimationFrame(resolve));
    if (!next()) await last;
  }
}

/** Asks for pictures for as long as something has changed; the next one is made while the last one is drawn. */
export async function pump() {
  if (asking) return;
  asking = true;
  try {
    await askAll();
  } finally {
    asking = false;
  }
  if (!moving()) {
    app.view.rest();
    if (![0, 1].some(isRefused)) edits.markGood();
  }
  settleProblem();
}

const isRefused = (side) => Boolean(shown[side].refused) && wish(side)?.key === shown[side].refused;

/** What was wrong is so no longer where nothing that is wanted was refused. */
function settleProblem() {
  const side = [1, 0].find(isRefused);
  if (side === undefined) clearProblem();
  else if ($("problem").hidden) problem(shown[side].error);
  else say();
  settleStale();
}

/** Whether the pictures are of other values. */
function settleStale() {
  const stale = [0, 1].map(isRefused);
  if (String(app.stale) === String(stale)) return;
  app.stale = stale;
  if (app.frames[1]) facts(shown.map((one) => one.tag), rate());
}

/** The left side has become another kind of picture. */
export function forgetLeft() {
  shown[0] = {};
  shown[1].key = inSpace() ? null : shown[1].key;
}

/** The next noise, or the next file of a sequence. */
function step() {
  const { numbers } = app.start;
  if (numbers.length > 0) state.number = numbers[(numbers.indexOf(state.number) + 1) % numbers.length];
  else state.number = (state.number + 1) % 2147483647;
  const slider = document.getElementById("number");
  if (numbers.length > 0) slider.value = numbers.indexOf(state.number);
}

/** `stop` is called where a run cannot go on. */
export function run(stop) {
  stepped = stop;
  rates.length = 0;
  if (state.running) step();
  pump();
}
