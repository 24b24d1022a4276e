// SPDX-License-Identifier: Apache-2.0
// What a user saves and shares: files by the browser's own download, the command line, the difference of the sensor file.

export function download(name, parts, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob(parts, { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

const word = (text) => (/^[\w./%@:=+,-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);

/** The picture of a 3-D scene: `view` is the camera, `changedScene` its file as it is saved, null where it is that of the start. */
function renderOf({ start, sensor, view, changedScene }) {
  const { space } = start, time = new Date(view.utc_s * 1000).toISOString().replace(/\.\d+Z$/, "Z");
  const scene = word(changedScene ?? start.scene);
  const words = ["mtf", "render", scene, sensor, "--time", time, "--position", view.position.join(","), "--look-at", view.look_at.join(",")];
  // Temperatures of the whole run, as the page has them.
  const solved = changedScene ? space.solvable : space.solved;
  if (solved) words.push("--temperatures", "temperatures-live");
  else if (space.temperatures) words.push("--temperatures", word(space.temperatures));
  if (space.no_air) words.push("--no-air");
  const before = solved ? `mtf heat ${scene} -o temperatures-live --force && ` : "";
  return `${before}${[...words, "-o", "radiance.exr"].join(" ")} && `;
}

/** The command that makes the picture on the page; `file`: the sensor file as it is saved, `seed` of its noise, `air`: the path is in the picture. */
export function commandOf({ start, file, changed, tolerance, stage, number, sequence, seed, view, changedScene, hasPath, air }) {
  const sensor = word(changed ? file : start.sensor);
  const words = ["mtf", "simulate", sensor, view ? "radiance.exr" : word(start.scene)];
  let before = start.before + (view ? renderOf({ start, sensor, view, changedScene }) : "");
  if (sequence) {
    words.push("-o", "out.%04d.exr", "--frames", `${number}:${number}`);
  } else if (number > 0 && seed !== undefined) {
    // One scene has frames where a schedule says so: this one changes nothing.
    before += `printf 'frame,parameter,value\\n0,noise.seed,${seed}\\n' > frames.csv && `;
    words.push("-o", "out.%04d.exr", "--schedule", "frames.csv", "--frames", `${number}:${number}`);
  } else {
    words.push("-o", "out.exr");
  }
  if (start.nan !== "refuse") words.push("--nan", start.nan);
  if (tolerance !== null) words.push("--tolerance", String(tolerance));
  if (stage) words.push("--stage", stage);
  if (view && hasPath && air) words.push("--without-path");
  return before + words.join(" ");
}

/** Lines of `b` against those of `a`, with two lines around each change; "" where both are the same. */
export function difference(a, b) {
  if (a === b) return "";
  const left = a.split("\n"), right = b.split("\n");
  let head = 0, tail = 0;
  while (head < Math.min(left.length, right.length) && left[head] === right[head]) head += 1;
  while (tail < Math.min(left.length, right.length) - head && left.at(-1 - tail) === right.at(-1 - tail)) tail += 1;
  const old = left.slice(head, left.length - tail), now = right.slice(head, right.length - tail);
  // Longest common subsequence of what is between.
  const best = Array.from({ length: old.length + 1 }, () => new Uint16Array(now.length + 1));
  for (let i = old.length - 1; i >= 0; i -= 1)
    for (let j = now.length - 1; j >= 0; j -= 1)
      best[i][j] = old[i] === now[j] ? best[i + 1][j + 1] + 1 : Math.max(best[i + 1][j], best[i][j + 1]);
  const lines = left.slice(Math.max(0, head - 2), head).map((line) => `  ${line}`);
  let kept = [];
  const flush = () => {
    if (kept.length > 5) kept = [...kept.slice(0, 2), "  …", ...kept.slice(-2)];
    lines.push(...kept);
    kept = [];
  };
  for (let i = 0, j = 0; i < old.length || j < now.length;) {
    if (i < old.length && j < now.length && old[i] === now[j]) {
      kept.push(`  ${old[i]}`);
      i += 1;
      j += 1;
      continue;
    }
    flush();
    if (i < old.length && (j >= now.length || best[i + 1][j] >= best[i][j + 1])) lines.push(`- ${old[i++]}`);
    else lines.push(`+ ${now[j++]}`);
  }
  flush();
  lines.push(...right.slice(right.length - tail, right.length - tail + 2).map((line) => `  ${line}`));
  return lines.join("\n");
}
