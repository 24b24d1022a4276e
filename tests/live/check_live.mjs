// SPDX-License-Identifier: Apache-2.0
// Opens `mtf live` in headless Chromium: every kind of control moved; the curves on the page are those of `mtf curve`,
// pixels those of `mtf simulate`, the saved file gives the same image; errors at their control; nothing on the console,
// no request to elsewhere. With --minutes N: random moves on two pages, watched for growth. Rates are printed, not judged.
// Usage: node check_live.mjs --modules DIR --chromium FILE --mtf FILE --work DIR [--minutes N]

import assert from "node:assert/strict";
import { copyFileSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { checkSpace } from "./check_space.mjs";
import { endure } from "./endurance.mjs";
import { context, field, job, launch, open, options, pixelsOnPage, places, press, settle, slide, slider, unfold } from "./helpers.mjs";
import { checkLooks, placesOf } from "./looks.mjs";

/** The page's curves, pixels and file against those of the other commands. */
async function compare(run, page, what, counts = 0) {
  const seen = await page.evaluate(() => ({ curves: window.mtfLive.curves, at: window.mtfLive.figures.place, text: window.mtfLive.text, command: document.getElementById("command").textContent,
    tolerance: window.mtfLive.state.tolerance, budget: window.mtfLive.figures.budget }));
  writeFileSync(join(run.folder, "seen.toml"), seen.text);
  const frequency = seen.curves.frequency;
  // The command that the page shows, with the names that its files have here.
  const line = seen.command.replace(/^\[ -d mtf-demo \] \|\| mtf demo && /, "").replace(/simulate \S+/, "simulate seen.toml").replace("out.", "again.");
  const [text] = await Promise.all([run.mtf("curve", "seen.toml", "--format", "json", ...(seen.at ? ["--field", `${seen.at.x_px}px,${seen.at.y_px}px`] : []), "--unit", seen.curves.unit, "--freq", `0:${frequency.at(-1)}:${frequency.length}`, "--quiet"), run.shell(`${line} --quiet`)]);
  const json = JSON.parse(text);
  const modulus = (c) => c.re.map((re, i) => Math.hypot(re, c.im[i]));
  let worst = 0;
  for (const { label, values } of [{ label: "system", values: modulus(json.system) }, ...json.components.map((c) => ({ label: c.label, values: modulus(c) }))])
    values.forEach((value, i) => { worst = Math.max(worst, Math.abs(value - seen.curves.columns[label][i])); });
  assert.ok(worst <= 1e-6, `${what}: curves differ by ${worst}`);
  // Five pixels as the page asks for them, and as `mtf info` and the saved frame have them.
  const frame = await page.evaluate(() => {
    const { id, full_width, full_height, step_x_um, step_y_um, unit, tolerance, low, high } = window.mtfLive.frame;
    return { id, full_width, full_height, step_x_um, step_y_um, unit, tolerance, low, high };
  });
  const number = /--frames (\d+)/.exec(line);
  const name = number ? `again.${number[1].padStart(4, "0")}.exr` : "again.exr";
  const [pixels, reference] = await Promise.all([pixelsOnPage(page, frame), run.pixelsOf(name, places(frame))]);
  // Another plan: errors within the tolerance, which take a count over a step of the converter now and then.
  const allowed = counts + 2 * frame.tolerance * (frame.high - frame.low);
  pixels.forEach((value, i) => assert.ok(Math.abs(value - reference[i]) <= allowed + 1e-12, `${what}: pixel ${places(frame)[i]} is ${value}, not ${reference[i]}`));
  return { worst, budget: seen.budget };
}
/** Colours of the canvas at 64 places, right after it was drawn. */
const coloursOf = (page) => page.evaluate(() => new Promise((resolve) => {
  const { view } = window.mtfLive, { canvas } = view, gl = view.kind === "webgl2" ? canvas.getContext("webgl2") : null;
  view.draw();
  requestAnimationFrame(() => {
    const { width, height } = canvas, all = gl ? new Uint8Array(4 * width * height) : canvas.getContext("2d").getImageData(0, 0, width, height).data;
    gl?.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, all);
    resolve(Array.from({ length: 64 }, (_, i) => {
      const x = Math.floor(((i % 8) + 0.37) / 8 * width), y = Math.floor((Math.floor(i / 8) + 0.61) / 8 * height), at = 4 * ((gl ? height - 1 - y : y) * width + x);
      return [...all.slice(at, at + 3)];
    }));
  });
}));

/** Colours of the whole picture, of a part of it with places outside, and with much contrast. */
async function drawings(page) {
  const all = [await coloursOf(page)];
  await page.evaluate(() => { const { view } = window.mtfLive; view.zoomBy(0.3, view.size().map((um, i) => um * (0.1 + 0.9 * i))); });
  all.push(await coloursOf(page));
  await page.evaluate(() => { window.mtfLive.view.contrast = 100; });
  all.push(await coloursOf(page));
  await page.evaluate(() => { const { view } = window.mtfLive; view.contrast = 0; view.fit(); });
  return all.flat();
}

async function checkPage(run, browser) {
  await run.mtf("demo", "-o", "mtf-demo");
  const begin = Date.now();
  const server = await run.serve("mtf-demo/sensor.toml", "mtf-demo/scene.exr", "--tolerance", "1e-4");
  const own = await context(browser);
  const { page, said, asked } = await open(own, server.address);
  console.log(`first picture ${Date.now() - begin} ms after the command, ${await page.evaluate(() => window.mtfLive.view.kind)}`);
  await unfold(page);

  // Each kind of slider: a length, an angle, a plain number, a focal length; a word; a typed value in another unit.
  for (const [name, share] of [["jitter.rms", 0.8], ["optics.f_number", 0.7], ["frame.focal_length", 0.3], ["frame.pitch", 0.55]]) {
    await slide(page, name, share);
    const { worst } = await compare(run, page, name);
    console.log(`${name}: curves within ${worst.toExponential(1)}`);
  }
  // A handle that is let go where it began: no `change` comes from the browser then.
  const jitter = page.locator('[data-name="jitter.rms"] input[type="range"]');
  await jitter.scrollIntoViewIfNeeded();
  const [x, y] = await jitter.evaluate((slider) => {
    const box = slider.getBoundingClientRect();
    return [box.left + 8 + ((box.width - 16) * slider.value) / 1000, box.top + box.height / 2];
  });
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (const to of [x + 12, x]) await page.mouse.move(to, y);
  assert.ok(await page.evaluate(() => window.mtfLive.busy));
  await page.mouse.up();
  await settle(page);
  assert.ok(await page.evaluate(() => !window.mtfLive.frame.preview && document.getElementById("preview-tag").hidden));
  // Words about a value go with it, and the pictures stay where they are when words come.
  const place = await page.locator("#stagebox").boundingBox();
  await field(page, "jitter.rms").fill("bad");
  await field(page, "jitter.rms").press("Enter");
  await page.locator("#problem").waitFor();
  assert.deepEqual(await page.locator("#stagebox").boundingBox(), place);
  await field(page, "jitter.rms").press("Escape");
  await settle(page);
  assert.ok(await page.evaluate(() => document.getElementById("problem").hidden && document.querySelector(".row.wrong") === null));
  await field(page, "jitter.rms").fill("0.012 mrad");
  await field(page, "jitter.rms").press("Enter");
  await settle(page);
  await compare(run, page, "a typed value");
  await field(page, "scene.border").selectOption("periodic");
  await settle(page);
  await compare(run, page, "a word");

  // A number that changes over the field has a slider for each term, and curves of the place that is clicked on.
  await field(page, "jitter.rms").fill('{ 1 = "10 urad", r2 = "30 urad" }');
  await field(page, "jitter.rms").press("Enter");
  await settle(page);
  const onAxis = await page.evaluate(() => window.mtfLive.figures.mtf50);
  await slide(page, "jitter.rms.r2", 0.8);
  assert.equal(await page.evaluate(() => window.mtfLive.figures.mtf50), onAxis);
  await compare(run, page, "a term over the field");
  const canvas = await page.locator("#view").boundingBox();
  await page.mouse.click(canvas.x + canvas.width / 2 + 100, canvas.y + canvas.height / 2 + 60);
  await settle(page);
  const { place: clicked, mtf50 } = await page.evaluate(() => window.mtfLive.figures);
  assert.ok(Math.hypot(clicked.x, clicked.y) > 0.1 && mtf50 < onAxis, "the place that was clicked on");
  const box = await page.locator("#mark").boundingBox();
  assert.ok(Math.hypot(box.x + box.width / 2 - canvas.x - canvas.width / 2 - 100, box.y + box.height / 2 - canvas.y - canvas.height / 2 - 60) < 2, "the mark");
  await compare(run, page, "a place in the field");
  await page.locator("#axis").click();
  await settle(page);
  assert.ok(await page.evaluate(() => !window.mtfLive.figures.place && document.getElementById("mark").hidden));

  // Components come, go, and are switched off and on; undo takes all of it back.
  await page.locator("select[aria-label='Add to After sampling']").selectOption("unsharp");
  await settle(page);
  await unfold(page);
  assert.ok(await page.evaluate(() => window.mtfLive.text.includes('kind = "unsharp"')));
  await compare(run, page, "added");
  const colours = () => page.evaluate(() => [...document.querySelectorAll("#legend tbody tr")].map((row) => `${row.cells[1].textContent} ${row.querySelector("span").style.borderTopColor}`));
  const all = await colours();
  await page.getByRole("checkbox", { name: "jitter on" }).uncheck();
  await settle(page);
  assert.deepEqual(await colours(), all.filter((text) => !text.startsWith("jitter ")), "a component keeps its colour");
  assert.ok(await page.evaluate(() => window.mtfLive.text.includes("#- kind = \"jitter\"")));
  await compare(run, page, "switched off");
  await page.getByRole("checkbox", { name: "jitter on" }).check();
  await settle(page);
  await page.getByRole("button", { name: "Remove footprint" }).click();
  await settle(page);
  await compare(run, page, "removed");
  for (let i = 0; i < 20 && !(await page.locator("#undo").isDisabled()); i += 1) {
    await page.keyboard.press("Control+z");
    await settle(page);
  }
  assert.equal(await page.evaluate(() => window.mtfLive.text), readFileSync(join(run.folder, "mtf-demo/sensor.toml"), "utf8"));
  await page.locator("#redo").click();
  await settle(page);
  assert.notEqual(await page.locator("#difference").textContent(), "no change\n");

  // What cannot be: the reader's words at the control, the last good picture stays.
  const shown = await page.evaluate(() => window.mtfLive.frame.id);
  await field(page, "optics.f_number").fill("0.001");
  await field(page, "optics.f_number").press("Enter");
  await page.waitForSelector("[data-name='optics.f_number'] .message:not([hidden])");
  assert.match(await page.locator("[data-name='optics.f_number'] .message").textContent(), /is outside \[0\.1, 1/);
  assert.equal(await page.evaluate(() => window.mtfLive.frame.id), shown);
  // It stands in the way of nothing: no edit, no step of undo, words until something else is changed.
  const edits = () => page.evaluate(() => window.mtfLive.edits), kept = await edits();
  assert.ok(!JSON.stringify(kept).includes("0.001"));
  await page.locator("select[aria-label='Add to Before sampling']").selectOption("defocus");
  await page.waitForFunction(() => /^defocus is not added: .*pupil/.test(document.getElementById("problem").textContent));
  assert.deepEqual(await edits(), kept);
  await field(page, "optics.aperture").fill("30 mm");  // in place of the f-number, which excludes it
  await field(page, "optics.aperture").press("Enter");
  await settle(page);
  await page.waitForSelector("#problem", { state: "hidden" });
  assert.ok(await page.evaluate(() => /^aperture = "30 mm"$/m.test(window.mtfLive.text) && !/^f_number/m.test(window.mtfLive.text)));
  await compare(run, page, "an aperture");
  await field(page, "optics.aperture").press("Control+z");
  await settle(page);
  assert.deepEqual(await edits(), kept);
  assert.match(await field(page, "optics.f_number").inputValue(), /\d/);

  // A link restores the state, but for what cannot be; files are what the page says.
  const link = page.url();
  const wrong = await open(own, await page.evaluate(() => {
    const [address, state] = location.href.split(/\/(?=[^/]*$)/), read = JSON.parse(atob(state.replaceAll("-", "+").replaceAll("_", "/")));
    read.edits.push(["set", "optics.f_number", "x"]);
    return `${address}/${btoa(JSON.stringify(read))}`;
  }));
  await wrong.page.waitForSelector("[data-name='optics.f_number'] .message:not([hidden])");
  await settle(wrong.page);
  assert.deepEqual(await wrong.page.evaluate(() => window.mtfLive.edits), kept);
  await wrong.page.close();
  const other = await open(own, link);
  assert.deepEqual(await other.page.evaluate(() => window.mtfLive.edits), await page.evaluate(() => window.mtfLive.edits));
  assert.equal(await other.page.evaluate(() => window.mtfLive.text), await page.evaluate(() => window.mtfLive.text));
  assert.deepEqual(other.said, []);
  await other.page.close();
  // WebGL and the canvas, which a page takes by itself without a graphics card, have the same colours.
  const wanted = await drawings(page);
  assert.ok(new Set(wanted.map(String)).size > 5);
  for (const [query, kind] of [["plain", "canvas"], ["webgl", "webgl2"]]) {
    const drawn = await open(own, link.replace("/#", `/?${query}#`));
    await drawn.page.waitForFunction((name) => window.mtfLive.view.kind === name, kind);
    (await drawings(drawn.page)).forEach((colour, i) => assert.ok(colour.every((part, c) => Math.abs(part - wanted[i][c]) <= 1), `${query}, place ${i}: ${colour} instead of ${wanted[i]}`));
    assert.deepEqual(drawn.said, []);
    await drawn.page.close();
  }
  const [file] = await Promise.all([page.waitForEvent("download"), press(page, "Save", "#save")]);
  assert.equal(readFileSync(await file.path(), "utf8"), await page.evaluate(() => window.mtfLive.text));
  const [seen] = await Promise.all([page.waitForEvent("download"), press(page, "Save", "#shot")]);
  const png = readFileSync(await seen.path());
  assert.equal(png.subarray(1, 4).toString(), "PNG");
  assert.ok(png.readUInt32BE(20) === 32 + (await page.evaluate(() => window.mtfLive.view.canvas.height)) && png.length > 20000, "picture, palette and scale");
  const [picture] = await Promise.all([page.waitForEvent("download"), press(page, "Save", "#exr")]);
  assert.equal(readFileSync(await picture.path()).readUInt32LE(0), 20000630);

  // The keyboard alone, and the value under the cursor.
  await slider(page, "jitter.rms").focus();
  const before = await page.evaluate(() => window.mtfLive.text);
  await page.keyboard.press("ArrowRight");
  await settle(page);
  assert.notEqual(await page.evaluate(() => window.mtfLive.text), before);
  // Shift makes a tenth of the step. An end that is typed stays; one that the value is beyond does not.
  const placeOf = () => slider(page, "jitter.rms").evaluate((element) => Number(element.value)), at = await placeOf();
  await page.keyboard.press("Shift+ArrowRight");
  await settle(page);
  assert.ok(Math.abs(await placeOf() - at - 1) < 0.3, `a step from ${at} to ${await placeOf()}`);
  const end = page.locator("[data-name='jitter.rms'] .end").last(), [number, unit] = (await end.inputValue()).split(" ");
  for (const [text, good] of [["wide", false], [`1e-9 ${unit}`, false], [`${Math.round(number / 2)} ${unit}`, true]]) {
    await end.fill(text);
    await end.press("Enter");
    assert.equal(await end.evaluate((element) => element.validity.valid), good, text);
  }
  await slider(page, "jitter.rms").press("ArrowRight");
  await settle(page);
  assert.equal(parseFloat(await end.inputValue()), Math.round(number / 2));
  await page.locator("#view").hover({ position: { x: 200, y: 200 } });
  await page.waitForFunction(() => window.mtfLive.value);
  // Values under a mouse that rests follow the picture, and are those of both sensors where there are two.
  await page.keyboard.press("k");
  const cursor = () => page.locator("#cursor").textContent();
  await page.waitForFunction(() => /\| +A .+ \| +B /.test(document.getElementById("cursor").textContent));
  await settle(page);
  await page.waitForTimeout(300);  // the window has settled too
  const [, a] = (await cursor()).split("|");
  await page.locator("#find").fill("jitter.rms");
  await slider(page, "jitter.rms").focus();
  for (let i = 0; i < 3; i += 1) await page.keyboard.press("PageUp");
  await settle(page);
  await page.waitForFunction((text) => ![undefined, text.slice(3)].includes(document.getElementById("cursor").textContent.split("|")[2]?.slice(3)), a);
  assert.equal((await cursor()).split("|")[1], a);
  // Without the mouse there are none, which pictures to come would make wrong.
  await page.locator("#find").hover();
  assert.equal(await cursor(), "");
  await page.locator("#find").fill("no such thing");
  await page.waitForSelector("#nothing:not([hidden])");
  const unnamed = await page.evaluate(() => [...document.querySelectorAll("button, input, select")].filter((e) => !e.hidden && !(e.getAttribute("aria-label") || e.labels?.length || e.textContent.trim())).map((e) => e.outerHTML));
  assert.deepEqual(unnamed, []);
  const sizes = await page.evaluate(() => performance.getEntriesByType("resource").filter((e) => /\.(js|css)$/.test(e.name)).reduce((sum, e) => sum + e.decodedBodySize, 0));
  console.log(`page: ${(sizes / 1000).toFixed(0)} kB of scripts and style`);
  assert.ok(sizes < 195000);
  assert.deepEqual(said, []);
  for (const url of asked) assert.ok(url.startsWith(server.address.split("#")[0]), url);
  await page.close();
  assert.equal(await server.end(), 0);
}

// The whole chain: noise of the same plan, seed and frame is the same; a drag at half size ends with the full frame.
/** What B is refused and A has too stays in A; the way back to a state of which there was a picture. */
async function checkHistory({ folder }) {
  const copy = join(folder, "history.mjs");  // Node takes .js for something else
  copyFileSync(new URL("../../apps/live/page/history.js", import.meta.url), copy);
  const history = await import(copy);
  history.set("jitter.rms", "20 urad");
  history.keep();
  const [edit] = history.current(1);
  history.refuse(edit, 1);
  assert.deepEqual([history.current(0), history.current(1)], [[edit], []]);
  history.set("jitter.rms", "30 urad");
  history.markGood();
  assert.ok(!history.isAstray());
  history.undo();
  history.set("jitter.rms", "-1 urad");
  assert.ok(history.isAstray());
  history.toGood();
  assert.deepEqual([history.current(0), history.current(1)], [[edit], [["set", "jitter.rms", "30 urad"]]]);
}

async function checkChain(run, browser) {
  const [server] = await Promise.all([run.serve(), run.mtf("demo", "-o", "mtf-demo")]);
  const own = await context(browser);
  const { page, said } = await open(own, server.address);
  await unfold(page);
  const { budget } = await compare(run, page, "demo", 1.05);
  await checkLooks(run, page, "demo");
  // The legend's values are those of `mtf curve`, the system's first.
  const { curves: { nyquist }, mtf50 } = await page.evaluate(() => window.mtfLive.figures);
  const { system } = JSON.parse(await run.mtf("curve", "seen.toml", "--freq", `${nyquist},${mtf50}`, "--format", "json", "--quiet")), [atNyquist, half] = system.re.map((re, i) => Math.hypot(re, system.im[i]));
  assert.deepEqual((await page.locator("#legend tbody tr").first().locator("td").allTextContents()).slice(1), ["system", atNyquist.toFixed(3), ""]);
  assert.ok(Math.abs(half - 0.5) < 1e-5, `${half} at the MTF50`);
  await page.locator("#curves .u-over").hover();
  await page.waitForFunction(() => /^0\.\d{3}$/.test(document.querySelector("#legend tbody tr").cells[3].textContent));
  const { terms } = JSON.parse(await run.mtf("budget", "seen.toml", "--format", "json", "--quiet"));
  for (const row of budget) if (row.value !== null) assert.equal(row.value, terms[row.name].value, row.name);
  for (const pair of [[["detector.read_noise", 0.7], ["noise.seed", 0.3]], [["adc.bits", 0.4], ["optics.temperature", 0.6]]]) {
    for (const [name, share] of pair) await slide(page, name, share);
    await compare(run, page, pair.map(([name]) => name).join(" and "), 1.05);
  }
  await page.getByRole("checkbox", { name: "[vignetting] on" }).uncheck();
  await settle(page);
  await page.locator("#run").click();
  await page.waitForFunction(() => window.mtfLive.state.number > 5);
  await page.locator("#run").click();
  await settle(page);
  await compare(run, page, "a later frame of the noise", 1.05);

  // Nothing jumps when what there is to say and to press changes.
  const parts = await placesOf(page);
  assert.ok(await page.locator("#first-frame").isEnabled());
  await page.keyboard.press("k");
  await settle(page);
  await field(page, "adc.bits").fill("99");
  await field(page, "adc.bits").press("Enter");
  await page.waitForSelector("[data-name='adc.bits'] .message:not([hidden])");
  await checkLooks(run, page, "two-sensors");
  assert.deepEqual(await placesOf(page), parts);
  await field(page, "adc.bits").press("Escape");
  await page.locator("#first-frame").click();
  await page.locator("#left").selectOption("scene");
  await settle(page);
  assert.deepEqual(await placesOf(page), parts);

  // A picture of half a minute that nobody wants any more is not waited for.
  await page.evaluate(() => {
    window.widths = new Set();
    const view = window.mtfLive.view, set = view.setPicture;
    view.setPicture = function (...all) { window.widths.add(window.mtfLive.frame.full_width); return set.apply(this, all); };
  });
  const width = await page.evaluate(() => window.mtfLive.frame.full_width);
  await field(page, "frame.pitch").fill("0.8 um");
  await field(page, "frame.pitch").press("Enter");
  await page.waitForSelector("#busy-tag:not([hidden])");
  await page.locator("#undo").click();
  await settle(page);
  assert.deepEqual(await page.evaluate((own) => [...window.widths].filter((one) => one !== own), width), []);
  await compare(run, page, "after a picture that was ended", 1.05);
  assert.deepEqual(said, []);
  await page.close();
  assert.equal(await server.end(), 0);

  // The saved file by the same plan: the same noise, digit for digit, as the command's frame of that number.
  const again = await run.serve("seen.toml", "mtf-demo/thermal.exr");
  const fresh = await open(own, again.address);
  const frame = await fresh.page.evaluate(() => ({ ...window.mtfLive.frame, pixels: null, id: window.mtfLive.frame.id }));
  writeFileSync(join(run.folder, "frames.csv"), "frame,parameter,value\n0,noise.shot,true\n");
  await run.mtf("simulate", "seen.toml", "mtf-demo/thermal.exr", "-o", "same.%04d.exr", "--schedule", "frames.csv", "--frames", "0:0", "--quiet");
  assert.deepEqual(await pixelsOnPage(fresh.page, frame), await run.pixelsOf("same.0000.exr", places(frame)));
  await fresh.page.close();
  assert.equal(await again.end(), 0);
}

const browser = await launch();
try {
  const began = Date.now();
  const timed = async (name, check) => {
    await check(job(name), browser);
    console.log(`${name}: ${((Date.now() - began) / 1000).toFixed(1)} s`);
  };
  if (options.minutes) await endure(job("endurance"), browser, Number(options.minutes));
  else await Promise.all([timed("history", checkHistory), timed("page", checkPage), timed("chain", checkChain), ...(options.space === "no" ? [] : [timed("3-D", checkSpace)])]);
  console.log("live: ok");
} finally {
  await browser.close();
}
