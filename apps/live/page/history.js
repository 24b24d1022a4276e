// SPDX-License-Identifier: Apache-2.0
// The edits of the sensor file, which everything else follows from: what the server is told, undo, the link. There are
// two lists, one for each side of the divider; the sliders edit one of them. Moves of the camera of a 3-D scene are
// steps of the same undo.

const past = [], future = []; // { side, list }: a list as it was; { view }: camera and time as they were
const lists = [[], []];
let editing = 1;
let camera = null; // { get, set, rest } of the view
let before = null; // a drag at work: the edits as they were when it began

const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

export const side = () => editing;
export const current = (of = editing) => lists[of];
export const canUndo = () => past.length > 0;
export const canRedo = () => future.length > 0;

export function edit(of) {
  drop();
  editing = of;
}

/** Without those that a later one of the same parameter makes void; none moves across a table that comes or goes. */
function withSet(list, name, value) {
  const result = list.slice();
  for (let i = result.length - 1; i >= 0 && result[i][0] === "set"; i -= 1)
    if (result[i][1] === name) result.splice(i, 1);
  result.push(["set", name, value]);
  return result;
}

function remember(step) {
  past.push(step);
  if (past.length > 500) past.shift();
  future.length = 0;
}

function take(next, of = editing) {
  if (same(next, lists[of])) return;
  remember({ side: of, list: lists[of] });
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

export function set(name, value) {
  drop();
  take(withSet(lists[editing], name, value));
}

export function add(one) {
  drop();
  take([...lists[editing], one]);
}

/** A parameter as it was at the start: its edits go where nothing after them depends on them. */
export function reset(name, value) {
  drop();
  const list = lists[editing];
  const next = list.filter((one) => !(one[0] === "set" && one[1] === name));
  take(list.every((one) => one[0] === "set") ? next : withSet(list, name, value));
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
  const { side: of, list, view } = from.pop();
  if (view) {
    to.push({ view: camera.get() });
    camera.set(view);
    return;
  }
  to.push({ side: of, list: lists[of] });
  lists[of] = list;
}
export const undo = () => move(past, future);
export const redo = () => move(future, past);

export function restore(right, left) {
  if (Array.isArray(right)) lists[1] = right;
  if (Array.isArray(left)) lists[0] = left;
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
