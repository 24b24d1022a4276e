// SPDX-License-Identifier: Apache-2.0
// Random moves on two pages of one server, watched for growth, errors and pictures of values that are no longer there.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { context, open, settle, unfold } from "./helpers.mjs";

export async function endure(run, browser, minutes) {
  const server = await run.serve(), own = await context(browser);
  const pages = [await open(own, server.address), await open(own, server.address)];
  const memory = () => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${server.child.pid}/status`, "utf8"))[1]) / 1024;
  let seed = 1, moves = 0, first = 0, frames = 0;
  const random = () => ((seed = (seed * 48271) % 2147483647) / 2147483647);
  const end = Date.now() + minutes * 60000;
  for (const { page } of pages) await unfold(page);
  while (Date.now() < end) {
    const { page } = pages[moves % 2];
    const count = await page.locator("#forms .row input[type=range]").count();
    await page.locator("#forms .row input[type=range]").nth(Math.floor(random() * count)).evaluate((element, values) => {
      for (const value of values) {
        element.value = value;
        element.dispatchEvent(new Event("input", { bubbles: true }));
      }
      element.dispatchEvent(new Event("change", { bubbles: true }));
    }, Array.from({ length: 5 }, () => random() * 1000));
    if (random() < 0.3) await page.keyboard.press("Control+z");
    if (random() < 0.1) await page.keyboard.press("f");
    moves += 1;
    if (moves % 20 === 0) {
      for (const { page: each } of pages) {
        if (await each.evaluate(() => window.mtfLive.state.running)) await each.keyboard.press("f");
        await settle(each);
        // The last picture is of the last state.
        assert.deepEqual(await each.evaluate(() => window.mtfLive.frame.number === window.mtfLive.state.number), true);
      }
      if (moves === 100) first = memory();
    }
    frames = await page.evaluate(() => window.mtfLive.view.drawn);
  }
  const grown = memory() - first;
  console.log(`${moves} moves, ${frames} pictures on one page, memory grew by ${grown.toFixed(0)} MiB from ${first.toFixed(0)}`);
  assert.ok(grown < 100, `memory grew by ${grown} MiB`);
  for (const { said } of pages) assert.deepEqual(said.filter((text) => !/status of 4(22|09|10)/.test(text)), []);
  assert.equal(await server.end(), 0);
}
