// SPDX-License-Identifier: Apache-2.0
// Random moves on two pages of an image and one of a 3-D scene, watched for growth, errors, and pictures of values that
// are no longer there.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { writeScene } from "./check_space.mjs";
import { context, open, options, settle, unfold } from "./helpers.mjs";

const PATIENCE_MS = 15000, MOST_UNDONE = 100;
const GIVES_BACK_MS = 12000; // a server gives memory that it no longer needs back every five seconds
const memory = (server) => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${server.child.pid}/status`, "utf8"))[1]) / 1024;

/** A slider, by five places of which it rests at the last; now and then undo, play and pause, a way back. */
async function move(page, random) {
  const sliders = page.locator(".row input[type=range]");
  await sliders.nth(Math.floor(random() * (await sliders.count()))).evaluate((element, values) => {
    for (const value of values) {
      element.value = value;
      element.dispatchEvent(new Event("input", { bubbles: true }));
    }
    element.dispatchEvent(new Event("change", { bubbles: true }));
  }, Array.from({ length: 5 }, () => random() * 1000));
  if (random() < 0.3) await page.keyboard.press("Control+z");
  if (random() < 0.1) await page.keyboard.press("f");
  if (random() < 0.1) await page.keyboard.press("Escape");
  if (random() < 0.05) await page.keyboard.press("k");
  if (random() < 0.05) await page.locator("#home").click({ timeout: 100 }).catch(() => {});
}

const busy = (page) => page.evaluate(() => window.mtfLive.busy);

/**
 * All pages at rest. A random place of a slider may ask for minutes of work, such as thousands of flat frames: then a page
 * says that it computes, and undo ends it, so that soon all rest again.
 */
async function rest(pages) {
  for (const { page } of pages) if (await page.evaluate(() => window.mtfLive.state.running)) await page.keyboard.press("f");
  for (let undone = 0; undone < MOST_UNDONE; undone += 1) {
    const late = await Promise.all(pages.map(({ page }) => settle(page, PATIENCE_MS).then(() => null, () => page)));
    const waiting = late.filter(Boolean);
    if (waiting.length === 0) return undone;
    for (const page of waiting) {
      if (!(await busy(page))) continue; // since then
      // One picture may have given way to the next a moment ago: a page says what it does after a second.
      await page.waitForFunction(() => !window.mtfLive.busy || !document.getElementById("busy-tag").hidden, undefined, { timeout: 3000 }).catch(() => {});
      if (!(await busy(page))) continue;
      const says = await page.evaluate(() => (document.getElementById("busy-tag").hidden ? "" : document.getElementById("busy-tag").textContent));
      assert.match(says, /^computing, \d+ s$/, `a page that is not at rest says nothing: ${await describe(page)}`);
      await page.keyboard.press("Control+z");
    }
  }
  throw new Error(`not at rest after ${MOST_UNDONE} steps back: ${await Promise.all(pages.map(({ page }) => describe(page)))}`);
}
/** For the reader of a failure: what holds the page, and its whole state as a link. */
const describe = (page) => page.evaluate(() => JSON.stringify({ link: location.href, waits: window.mtfLive.waits, inWork: window.mtfLive.inWork, lags: window.mtfLive.frames.map((frame) => frame && [frame.preview, frame.light_lags, frame.correction_lags, frame.solving]), ...window.mtfLive.state, edits: window.mtfLive.edits, scene: window.mtfLive.sceneEdits, place: window.mtfLive.place?.request(), text: document.getElementById("said").textContent }));

/** The last picture is of the last state, unless that was refused. */
async function isFresh(page) {
  const { wrong, frame, number, utc_s } = await page.evaluate(() => ({ wrong: !document.getElementById("problem").hidden, frame: { ...window.mtfLive.frame }, number: window.mtfLive.state.number,
    utc_s: window.mtfLive.place?.utc_s }));
  if (wrong) return;
  assert.equal(frame.number, number);
  assert.equal(frame.preview, false);
  if (utc_s !== undefined) assert.equal(frame.utc_s, utc_s);
}

export async function endure(run, browser, minutes) {
  const servers = [await run.serve()], own = await context(browser);
  const pages = [await open(own, servers[0].address), await open(own, servers[0].address)];
  if (options.space !== "no") {
    await writeScene(run);
    servers.push(await run.serve("plates.toml", "space.toml"));
    pages.push(await open(own, servers[1].address));
  }
  let seed = Number(options.seed ?? 1), moves = 0, undone = 0, first = [];
  const random = () => ((seed = (seed * 48271) % 2147483647) / 2147483647);
  const end = Date.now() + minutes * 60000;
  for (const { page } of pages) await unfold(page);
  while (Date.now() < end) try {
    await move(pages[moves % pages.length].page, random);
    moves += 1;
    if (moves % 30 !== 0) continue;
    undone += await rest(pages);
    for (const { page } of pages) await isFresh(page);
    if (moves === 150) first = servers.map(memory);
    if (moves % 300 === 0) console.log(`${moves} moves: ${servers.map((server) => memory(server).toFixed(0)).join(" and ")} MiB, ${undone} long pictures ended`);
  } catch (error) {
    throw new Error(`${error.message}\nsaid: ${pages.map(({ said }) => said.filter((text) => !/status of 4(22|09|10)/.test(text)).join("; ")).join(" | ")}`);
  }
  await rest(pages);
  await new Promise((resolve) => setTimeout(resolve, GIVES_BACK_MS));
  for (const [i, server] of servers.entries()) {
    const grown = memory(server) - first[i];
    console.log(`server ${i}: ${moves} moves, memory grew by ${grown.toFixed(0)} MiB from ${first[i].toFixed(0)}`);
    assert.ok(grown < 100, `memory grew by ${grown} MiB`);
  }
  for (const { said } of pages) assert.deepEqual(said.filter((text) => !/status of 4(22|09|10)/.test(text)), []);
  for (const server of servers) assert.equal(await server.end(), 0);
}
