// SPDX-License-Identifier: Apache-2.0
// The edits of the sensor file, which everything else follows from: what the server is told, undo, the link. There are
// two lists, one for each side of the divider, of which the sliders edit one, and one of the file of a 3-D scene. Moves
// of the camera of a 3-D scene are steps of the same undo.

export const SCENE = 2;
const past = [], future = []; // { of, list }: a list as it was; { view }: camera and time as they were
const lists = [[], [], []];
let editing = 1;
let camera = null; // { get, set, rest } of the view
let before = null; // a drag at work: the edits as they were when it began
let good = null; // lists and view that the last picture without an error was of

const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

/** Values of parameters may stand in another order. */
const sameValues = (a, b) => same(a, b) || (a.every(ofValue) && b.every(ofValue) && same(a.toSorted(), b.toSorted()));

export const side = () => editing;
export const current = (of = editing) => lists[of];
export const canUndo = () => past.length > 0;
export const canRedo = () => future.length > 0;

export function edit(of) {
  drop();
  editing = of;
}

const ofValue = (edit) => edit[0] === "set" || edit[0] === "unset";

/** Without those that a later one of the same parameter makes void; none moves across a table that comes or goes. */
function withoutValues(list, name) {
  const result = list.slice();
  for (let i = result.length - 1; i >= 0 && ofValue(result[i]); i -= 1)
    if (result[i][1] === name) result.splice(i, 1);
  return result;
}
const withSet = (list, name, value) => [...withoutValues(list, name), ["set", name, value]];

function remember(step) {
  past.push(step);
  if (past.length > 500) past.shift();
  future.length = 0;
}

function take(next, of = editing) {
  if (same(next, lists[of])) return;
  remember({ of, list: lists[of] });
  lists[of] = next;
}

/** `rest`: brings to rest what moves, which is a step of its own. */
export function follow(get, set, rest) { camera = { get, set, rest }; }
/** The camera has come to rest somewhere else than where it was, `view`. */
export function moved(view) { remember({ view }); }

/** A value while its slider moves: no step of its own for undo. */
export function drag(name, value) {
  before ??= lists[editing];
  lists[editing] = withSet(lists[editing], name, value);
}

export function drop() {
  if (before === null) return;
  const after = lists[editing];
  lists[editing] = before;
  before = null;
  take(after);
}

export function set(name, value, of = editing) {
  drop();
  take(withSet(lists[of], name, value), of);
}

export function add(one) {
  drop();
  take([...lists[editing], one]);
}

/** A parameter that the file no longer states. */
export function unset(name, of = editing) {
  drop();
  take([...withoutValues(lists[of], name), ["unset", name]], of);
}

/** A parameter as it was at the start, null: not given; its edits go where nothing after them depends on them. */
export function reset(name, value, of = editing) {
  drop();
  const list = lists[of], owner = name.slice(0, name.lastIndexOf(".") + 1);
  // A key of the same table may have taken the place of another one.
  if (list.every((one) => ofValue(one) && (one[1] === name || !one[1].startsWith(owner)))) return take(list.filter((one) => one[1] !== name), of);
  if (value !== null) return take(withSet(list, name, value), of);
  const next = withoutValues(list, name), stated = next.some((one) => one[0] === "set" && one[1] === name);
  return take(stated ? [...next, ["unset", name]] : next, of);
}

/** An edit of a list that the program refuses is as if it had never been: what it made void counts again. */
export function refuse(edit, of) {
  if (!lists[of].includes(edit)) return;
  const earlier = past.filter((step) => step.of === of && !step.list.includes(edit)).at(-1)?.list ?? [];
  const former = ofValue(edit) ? earlier.filter((one) => ofValue(one) && one[1] === edit[1]).at(-1) : undefined;
  const without = (list) => (list.includes(edit) ? list.map((one) => (one === edit ? former : one)).filter(Boolean) : list);
  lists[of] = without(lists[of]);
  if (before && of === editing) before = without(before);
  for (const steps of [past, future]) for (const step of steps) if (step.of === of) step.list = without(step.list);
  // Steps that now lead to what is there anyway.
  for (let i = past.length - 1, next = lists[of]; i >= 0; i -= 1) {
    if (past[i].of !== of) continue;
    if (sameValues(past[i].list, next)) past.splice(i, 1);
    else next = past[i].list;
  }
}

/** The left side becomes what the right one is. */
export function keep() {
  drop();
  take(lists[1], 0);
}

function move(from, to) {
  drop();
  camera?.rest();
  if (from.length === 0) return;
  const { of, list, view } = from.pop();
  if (view) {
    to.push({ view: camera.get() });
    camera.set(view);
    return;
  }
  to.push({ of, list: lists[of] });
  lists[of] = list;
}
export const undo = () => move(past, future);
export const redo = () => move(future, past);

const now = () => ({ lists: lists.slice(), view: camera?.get() });
/** A picture without an error has come of what is now. */
export function markGood() { good = now(); }
export const isAstray = () => good !== null && !same(good, now());
/** Back to that picture, which undo takes back. */
export function toGood() {
  drop();
  camera?.rest();
  for (const [of, list] of good.lists.entries()) take(list, of);
  if (same(good.view, camera?.get())) return;
  moved(camera.get());
  camera.set(good.view);
}

export function restore(...saved) {
  for (const [of, list] of saved.entries()) if (Array.isArray(list)) lists[of] = list;
}

/** Text for a fragment, and back. */
export function encode(state) {
  const text = JSON.stringify(state);
  return btoa(String.fromCharCode(...new TextEncoder().encode(text))).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}
export function decode(text) {
  try {
    const bytes = Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0));
    return JSON.parse(new TextDecoder().decode(bytes));
  } catch {
    return null;
  }
}
