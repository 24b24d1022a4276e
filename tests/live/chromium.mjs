// SPDX-License-Identifier: Apache-2.0
// Chromium as its user has it, but without a window: with no other flags than that needs, and driven through the DevTools
// protocol over a pipe. A driver such as Playwright hides scroll bars and hears of every request, so that pages take
// another time with it.

import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const UI_HEIGHT = 87; // of the window, beside the page

export const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

/** Starts it. `page(address)` opens a page in it, and gives a function that says what an expression is there. */
export async function launch(executable, { width, height }) {
  const profile = mkdtempSync(join(tmpdir(), "mtfkit-chromium-"));
  const flags = ["--headless=new", "--no-sandbox", "--no-first-run", `--window-size=${width},${height + UI_HEIGHT}`, `--user-data-dir=${profile}`, "--remote-debugging-pipe"];
  const child = spawn(executable, [...flags, "about:blank"], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
  const ended = new Promise((resolve) => child.once("exit", resolve));
  const asked = new Map();
  let count = 0, rest = "";
  child.stdio[4].setEncoding("utf8").on("data", (text) => {
    const messages = (rest + text).split("\0");
    rest = messages.pop();
    for (const { id, result, error } of messages.map(JSON.parse)) {
      const [keep, fail] = asked.get(id) ?? [];
      asked.delete(id);
      if (error) fail?.(new Error(error.message));
      else keep?.(result);
    }
  });
  const send = (method, params = {}, sessionId = undefined) => new Promise((keep, fail) => {
    asked.set(count += 1, [keep, fail]);
    child.stdio[3].write(`${JSON.stringify({ id: count, method, params, sessionId })}\0`);
  });
  await send("Browser.getVersion");
  return {
    async page(address) {
      const { targetId } = await send("Target.createTarget", { url: address });
      const { sessionId } = await send("Target.attachToTarget", { targetId, flatten: true });
      return async (expression) => {
        const { result, exceptionDetails } = await send("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true }, sessionId);
        if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
        return result.value;
      };
    },
    async close() {
      send("Browser.close").catch(() => {});
      await ended;
      rmSync(profile, { recursive: true, force: true });
    },
  };
}

/** Until an expression is true on a page that is perhaps not there yet. */
export async function until(page, expression) {
  const end = Date.now() + 60000;
  while (!(await page(expression).catch(() => false))) {
    if (Date.now() > end) throw new Error(`not true within a minute: ${expression}`);
    await sleep(10);
  }
}
