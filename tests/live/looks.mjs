// SPDX-License-Identifier: Apache-2.0
// How the page looks in two sizes of window, light and dark: no text is cut, no control reaches out of its panel, and
// none stands on another. Screenshots stay in the folder of the check.

import assert from "node:assert/strict";
import { join } from "node:path";
import { settle } from "./helpers.mjs";

const flaws = (page) => page.evaluate(() => {
  const wrong = [], name = (e) => `${e.tagName.toLowerCase()}${e.id && `#${e.id}`} '${(e.value || e.textContent).trim().slice(0, 40)}'`;
  const seen = (selector, from = document) => [...from.querySelectorAll(selector)].filter((e) => e.checkVisibility({ contentVisibilityAuto: true }) && e.getBoundingClientRect().width > 1);
  for (const e of seen("body *")) {
    const text = e.matches("input:not([type=range], [type=checkbox]), select, button") || [...e.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
    if (!text || e.matches(".skip, option")) continue;
    const scrolls = /auto|scroll/.test(getComputedStyle(e).overflowY), box = e.getBoundingClientRect();
    if (e.clientWidth > 0 && (e.scrollWidth > e.clientWidth + 1 || (!scrolls && e.scrollHeight > e.clientHeight + 1 && !e.matches("input, select")))) wrong.push(`${name(e)} is cut`);
    const outer = e.parentElement.closest("header, .panel, .section, .scroll, #scroll, #under, #said, #stagebox, .bar, [popover], body"), left = outer.getBoundingClientRect().left + outer.clientLeft;
    if (box.left < left - 1 || box.right > left + outer.clientWidth + 1) wrong.push(`${name(e)} reaches out`);
  }
  for (const group of [seen("header, #sensor, #picture > *, .panel"), seen("header .bar > *, h1"), seen("#picture > .bar > *, #under .bar > *"), seen(".tag"), ...seen(".row").map((row) => seen(":scope > *, .track > *", row).filter((e) => !e.matches(".track")))]) {
    const boxes = group.map((e) => e.getBoundingClientRect());
    for (const [i, a] of boxes.entries()) for (const [k, b] of boxes.entries())
      if (i < k && Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1) wrong.push(`${name(group[i])} and ${name(group[k])} overlap`);
  }
  if (document.documentElement.scrollWidth > innerWidth || document.documentElement.scrollHeight > innerHeight) wrong.push("the page scrolls");
  return wrong;
});

export async function checkLooks(run, page, what) {
  const first = page.viewportSize();
  for (const size of [{ width: 1280, height: 800 }, { width: 1920, height: 1080 }])
    for (const colorScheme of ["light", "dark"]) {
      await page.setViewportSize(size);
      await page.emulateMedia({ colorScheme });
      await settle(page);
      const name = `${what}-${size.width}-${colorScheme}`;
      await page.screenshot({ path: join(run.folder, `${name}.png`) });
      assert.deepEqual(await flaws(page), [], name);
    }
  await page.setViewportSize(first);
  await page.emulateMedia({ colorScheme: null });
}

/** Where the parts of the page are that stay in their places, whatever comes or goes. */
export const placesOf = (page) => page.evaluate(() => ["header", "#stagebox", "#under", "#said"].map((part) => { const { x, y, width, height } = document.querySelector(part).getBoundingClientRect(); return [x, y, width, height]; }));
