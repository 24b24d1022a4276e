// SPDX-License-Identifier: Apache-2.0
// The edits of the sensor file, which everything else follows from: what the server is told, undo, the link.

const past = [], future = [];
let edits = [];
let before = null; // a drag at work: the edits as they were when it began

const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

export const current = () => edits;
export const canUndo = () => past.length > 0;
export const canRedo = () => future.length > 0;

/** Without those that a later one of the same parameter makes void; none moves across a table that comes or goes. */
function withSet(list, name, value) {
  const result = list.slice();
  for (let i = result.length - 1; i >= 0 && result[i][0] === "set"; i -= 1)
    if (result[i][1] === name) result.splice(i, 1);
  result.push(["set", name, value]);
  return result;
}

function take(next) {
  if (same(next, edits)) return;
  past.push(edits);
  if (past.length > 500) past.shift();
  future.length = 0;
  edits = next;
}

/** A value while its slider moves: no step of its own for undo. */
export function drag(name, value) {
  before ??= edits;
  edits = withSet(edits, name, value);
}

export function drop() {
  if (before === null) return;
  const after = edits;
  edits = before;
  before = null;
  take(after);
}

export function set(name, value) {
  drop();
  take(withSet(edits, name, value));
}

export function add(edit) {
  drop();
  take([...edits, edit]);
}

/** A parameter as it was at the start: its edits go where nothing after them depends on them. */
export function reset(name, value) {
  drop();
  const next = edits.filter((edit) => !(edit[0] === "set" && edit[1] === name));
  take(edits.every((edit) => edit[0] === "set") ? next : withSet(edits, name, value));
}

export function undo() {
  drop();
  if (past.length === 0) return;
  future.push(edits);
  edits = past.pop();
}

export function redo() {
  drop();
  if (future.length === 0) return;
  past.push(edits);
  edits = future.pop();
}

export function restore(list) {
  if (Array.isArray(list)) edits = list;
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
