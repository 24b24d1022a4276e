// SPDX-License-Identifier: Apache-2.0
// Opens `mtf live` in headless Chromium: every kind of control moved; the curves on the page are those of `mtf curve`,
// pixels those of `mtf simulate`, the saved file gives the same image; errors at their control; nothing on the console,
// no request to elsewhere. With --minutes N: random moves on two pages, watched for growth. Rates are printed, not judged.
// Usage: node check_live.mjs --modules DIR --chromium FILE --mtf FILE --work DIR [--minutes N]

import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { createInterface } from "node:readline";

const options = {};
for (let i = 2; i + 1 < process.argv.length; i += 2) options[process.argv[i].slice(2)] = process.argv[i + 1];
const { chromium } = createRequire(join(options.modules, "x.js"))("playwright-core");
const flags = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
  "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];
const work = join(options.work, options.minutes ? "endurance" : "page");
rmSync(work, { recursive: true, force: true });
mkdirSync(work, { recursive: true });
const mtf = (...words) => execFileSync(options.mtf, words, { cwd: work, encoding: "utf8", maxBuffer: 1 << 26, stdio: ["ignore", "pipe", "pipe"] });

async function serve(...words) {
  const child = spawn(options.mtf, ["live", "--no-browser", ...words], { cwd: work, stdio: ["ignore", "pipe", "inherit"] });
  const address = await new Promise((resolve, reject) => {
    createInterface({ input: child.stdout }).once("line", resolve);
    child.once("exit", (code) => reject(new Error(`mtf live ended with ${code}`)));
  });
  return { child, address, end: () => new Promise((resolve) => { child.once("exit", resolve); child.kill("SIGINT"); }) };
}

// A page with everything it says and asks for; nothing is intercepted, as the answers of a held request would be late.
async function open(context, address) {
  const page = await context.newPage(), said = [], asked = [];
  page.on("console", (message) => said.push(message.text()));
  page.on("pageerror", (error) => said.push(String(error)));
  page.on("request", (request) => { if (!/^(data|blob):/.test(request.url())) asked.push(request.url()); });
  await page.goto(address);
  await rest(page);
  await page.waitForFunction(() => window.mtfLive?.text);
  return { page, said, asked };
}
const rest = (page) => page.waitForFunction(() => window.mtfLive?.frame && window.mtfLive.figures && !window.mtfLive.busy, null, { timeout: 20000 });
const settle = async (page) => {
  await page.waitForTimeout(20);
  await rest(page);
  await page.waitForTimeout(20);
  await rest(page);
};
const slider = (page, name) => page.locator(`[data-name="${name}"] input[type=range]`);
const field = (page, name) => page.locator(`[data-name="${name}"] :is(input[type=text], select)`);
async function slide(page, name, share) {
  await slider(page, name).evaluate((element, t) => {
    for (const at of [t * 500, t * 800, t * 1000]) {
      element.value = at;
      element.dispatchEvent(new Event("input", { bubbles: true }));
    }
    element.dispatchEvent(new Event("change", { bubbles: true }));
  }, share);
  await settle(page);
}
const unfold = (page) => page.evaluate(() => { for (const each of document.querySelectorAll("#forms details")) each.open = true; });

function parseCsv(text) {
  const [head, ...lines] = text.trim().split("\n").map((line) => line.split(","));
  return Object.fromEntries(head.map((name, i) => [name, lines.map((line) => Number(line[i]))]));
}

/** The page's curves, pixels and file against those of the other commands. */
async function compare(page, what, counts = 0) {
  const seen = await page.evaluate(() => ({ curves: window.mtfLive.curves, text: window.mtfLive.text, command: document.getElementById("command").textContent,
    tolerance: window.mtfLive.state.tolerance, budget: window.mtfLive.figures.budget }));
  writeFileSync(join(work, "seen.toml"), seen.text);
  const frequency = seen.curves.frequency;
  const json = JSON.parse(mtf("curve", "seen.toml", "--format", "json", "--unit", seen.curves.unit, "--freq", `0:${frequency.at(-1)}:${frequency.length}`, "--quiet"));
  const modulus = (c) => c.re.map((re, i) => Math.hypot(re, c.im[i]));
  let worst = 0;
  for (const { label, values } of [{ label: "system", values: modulus(json.system) }, ...json.components.map((c) => ({ label: c.label, values: modulus(c) }))])
    values.forEach((value, i) => { worst = Math.max(worst, Math.abs(value - seen.curves.columns[label][i])); });
  assert.ok(worst <= 1e-6, `${what}: curves differ by ${worst}`);
  // The command that the page shows, with the names that its files have here.
  const line = seen.command.replace(/^mtf demo && /, "").replace(/simulate \S+/, "simulate seen.toml").replace("out.", "again.");
  execFileSync("sh", ["-c", `${line} --quiet`], { cwd: work, env: { ...process.env, PATH: `${dirname(options.mtf)}:${process.env.PATH}` }, stdio: ["ignore", "pipe", "inherit"] });
  // Five pixels as the page asks for them, and as `mtf info` and the saved frame have them.
  const frame = await page.evaluate(() => {
    const { id, full_width, full_height, step_x_um, step_y_um, unit, tolerance, low, high } = window.mtfLive.frame;
    return { id, full_width, full_height, step_x_um, step_y_um, unit, tolerance, low, high };
  });
  const pixels = await pixelsOnPage(page, frame);
  const number = /--frames (\d+)/.exec(line);
  const name = number ? `again.${number[1].padStart(4, "0")}.exr` : "again.exr";
  const reference = pixelsOf(name, places(frame));
  // Another plan: errors within the tolerance, which take a count over a step of the converter now and then.
  const allowed = counts + 2 * frame.tolerance * (frame.high - frame.low);
  pixels.forEach((value, i) => assert.ok(Math.abs(value - reference[i]) <= allowed + 1e-12, `${what}: pixel ${places(frame)[i]} is ${value}, not ${reference[i]}`));
  return { worst, budget: seen.budget };
}
const pixelsOnPage = (page, frame) => page.evaluate(async ({ frame: { id, step_x_um, step_y_um }, wanted }) => {
  const head = { "X-Mtf-Token": location.hash.slice(1).split("/")[0], "Content-Type": "application/json" };
  const all = [];
  for (const [x, y] of wanted) {
    const body = JSON.stringify({ id, edits: window.mtfLive.edits, number: window.mtfLive.state.number, x_um: (x + 0.5) * step_x_um, y_um: (y + 0.5) * step_y_um });
    const answer = await (await fetch("/value", { method: "POST", headers: head, body })).json();
    all.push(answer.after?.value ?? answer.error);
  }
  return all;
}, { frame, wanted: places(frame) });
const places = ({ full_width: w, full_height: h }) => [[0, 0], [w - 1, h - 1], [Math.floor(w / 2), Math.floor(h / 2)], [Math.floor(w / 3), Math.floor(h / 5)], [Math.floor(w / 4), h - 2]];

/** Values of an uncompressed or ZIP-compressed scanline OpenEXR of one float channel; the other formats are not ours. */
function pixelsOf(name, wanted) {
  return execFileSync("/usr/bin/python3", ["-c", READ, join(work, name), ...wanted.flat()], { encoding: "utf8" }).trim().split("\n").map(Number);
}
const READ = `
import sys, struct, zlib
data = open(sys.argv[1], 'rb').read(); at = 8; a = {}
def z(i):
    e = data.index(b'\\0', i); return data[i:e].decode(), e + 1
while data[at]:
    n, at = z(at); t, at = z(at); size, = struct.unpack_from('<i', data, at); a[n] = data[at + 4:at + 4 + size]; at += 4 + size
at += 1
x0, y0, x1, y1 = struct.unpack('<4i', a['dataWindow']); w, h = x1 - x0 + 1, y1 - y0 + 1; c = a['compression'][0]
block = {0: 1, 2: 1, 3: 16}[c]
for X, Y in zip(map(int, sys.argv[2::2]), map(int, sys.argv[3::2])):
    off, = struct.unpack_from('<Q', data, at + 8 * (Y // block)); y, size = struct.unpack_from('<ii', data, off); raw = data[off + 8:off + 8 + size]
    lines = min(block, h - (Y // block) * block)
    if c and size < 4 * w * lines:
        d = bytearray(zlib.decompress(raw)); p = d[0]
        for i in range(1, len(d)):
            p = d[i] = (p + d[i] - 128) & 255
        half = (len(d) + 1) // 2; raw = bytearray(len(d)); raw[0::2] = d[:half]; raw[1::2] = d[half:]
    print(repr(struct.unpack_from('<f', raw, 4 * ((Y % block) * w + X))[0]))
`;

async function checkPage(browser) {
  mtf("demo", "-o", "mtf-demo");
  const begin = Date.now();
  const server = await serve("mtf-demo/sensor.toml", "mtf-demo/scene.exr", "--tolerance", "1e-4");
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, acceptDownloads: true, permissions: ["clipboard-read", "clipboard-write"] });
  const { page, said, asked } = await open(context, server.address);
  console.log(`first picture ${Date.now() - begin} ms after the command, ${await page.evaluate(() => window.mtfLive.view.kind)}`);
  await unfold(page);

  // Each kind of slider: a length, an angle, a plain number, a focal length; a word; a typed value in another unit.
  for (const [name, share] of [["jitter.rms", 0.8], ["optics.f_number", 0.7], ["frame.focal_length", 0.3], ["frame.pitch", 0.55]]) {
    await slide(page, name, share);
    const { worst } = await compare(page, name);
    console.log(`${name}: curves within ${worst.toExponential(1)}`);
  }
  await field(page, "jitter.rms").fill("0.012 mrad");
  await field(page, "jitter.rms").press("Enter");
  await settle(page);
  await compare(page, "a typed value");
  await field(page, "scene.border").selectOption("periodic");
  await settle(page);
  await compare(page, "a word");

  // Components come, go, and are switched off and on; undo takes all of it back.
  await page.locator("select[aria-label='Add to After sampling']").selectOption("unsharp");
  await settle(page);
  await unfold(page);
  assert.ok(await page.evaluate(() => window.mtfLive.text.includes('kind = "unsharp"')));
  await compare(page, "added");
  await page.getByRole("checkbox", { name: "jitter on" }).uncheck();
  await settle(page);
  assert.ok(await page.evaluate(() => window.mtfLive.text.includes("#- kind = \"jitter\"")));
  await compare(page, "switched off");
  await page.getByRole("checkbox", { name: "jitter on" }).check();
  await settle(page);
  await page.getByRole("button", { name: "Remove footprint" }).click();
  await settle(page);
  await compare(page, "removed");
  for (let i = 0; i < 20 && !(await page.locator("#undo").isDisabled()); i += 1) {
    await page.keyboard.press("Control+z");
    await settle(page);
  }
  assert.equal(await page.evaluate(() => window.mtfLive.text), readFileSync(join(work, "mtf-demo/sensor.toml"), "utf8"));
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
  await page.keyboard.press("Escape");
  await page.locator("#undo").click();
  await settle(page);
  assert.ok(await page.locator("#problem").isHidden());
  await page.locator("select[aria-label='Add to Before sampling']").selectOption("defocus");
  await page.waitForSelector("#problem:not([hidden])");
  assert.match(await page.locator("#problem").textContent(), /pupil/);
  await page.locator("#undo").click();
  await settle(page);

  // A link restores the state; files are what the page says.
  const link = page.url();
  const other = await open(context, link);
  assert.deepEqual(await other.page.evaluate(() => window.mtfLive.edits), await page.evaluate(() => window.mtfLive.edits));
  assert.equal(await other.page.evaluate(() => window.mtfLive.text), await page.evaluate(() => window.mtfLive.text));
  assert.deepEqual(other.said, []);
  await other.page.close();
  const [file] = await Promise.all([page.waitForEvent("download"), page.locator("#save").click()]);
  assert.equal(readFileSync(await file.path(), "utf8"), await page.evaluate(() => window.mtfLive.text));
  const [picture] = await Promise.all([page.waitForEvent("download"), page.locator("#exr").click()]);
  assert.equal(readFileSync(await picture.path()).readUInt32LE(0), 20000630);

  // The keyboard alone, and the value under the cursor.
  await slider(page, "jitter.rms").focus();
  const before = await page.evaluate(() => window.mtfLive.text);
  await page.keyboard.press("ArrowRight");
  await settle(page);
  assert.notEqual(await page.evaluate(() => window.mtfLive.text), before);
  await page.locator("#view").hover({ position: { x: 200, y: 200 } });
  await page.waitForFunction(() => window.mtfLive.value);
  const unnamed = await page.evaluate(() => [...document.querySelectorAll("button, input, select")].filter((e) => !e.hidden && !(e.getAttribute("aria-label") || e.labels?.length || e.textContent.trim())).map((e) => e.outerHTML));
  assert.deepEqual(unnamed, []);
  const sizes = await page.evaluate(() => performance.getEntriesByType("resource").filter((e) => /\.(js|css)$/.test(e.name)).reduce((sum, e) => sum + e.decodedBodySize, 0));
  console.log(`page: ${(sizes / 1000).toFixed(0)} kB of scripts and style`);
  assert.ok(sizes < 195000);
  assert.deepEqual(said, []);
  for (const url of asked) assert.ok(url.startsWith(server.address.split("#")[0]), url);
  await page.close();
  assert.equal(await server.end(), 0);
  return context;
}

// The whole chain: noise of the same plan, seed and frame is the same; a drag at half size ends with the full frame.
async function checkChain(context) {
  const server = await serve();
  const { page, said } = await open(context, server.address);
  await unfold(page);
  const { budget } = await compare(page, "demo", 1.05);
  const terms = JSON.parse(mtf("budget", "seen.toml", "--format", "json", "--quiet")).terms;
  for (const row of budget) if (row.value !== null) assert.equal(row.value, terms[row.name].value, row.name);
  for (const [name, share] of [["detector.read_noise", 0.7], ["noise.seed", 0.3], ["adc.bits", 0.4], ["optics.temperature", 0.6]]) {
    await slide(page, name, share);
    await compare(page, name, 1.05);
  }
  await page.getByRole("checkbox", { name: "[vignetting] on" }).uncheck();
  await settle(page);
  await compare(page, "without vignetting", 1.05);
  await page.locator("#run").click();
  await page.waitForFunction(() => window.mtfLive.state.number > 5);
  await page.locator("#run").click();
  await settle(page);
  await compare(page, "a later frame of the noise", 1.05);
  assert.deepEqual(said, []);
  await page.close();
  assert.equal(await server.end(), 0);

  // The saved file by the same plan: the same noise, digit for digit, as the command's frame of that number.
  const again = await serve("seen.toml", "mtf-demo/thermal.exr");
  const fresh = await open(context, again.address);
  const frame = await fresh.page.evaluate(() => ({ ...window.mtfLive.frame, pixels: null, id: window.mtfLive.frame.id }));
  writeFileSync(join(work, "frames.csv"), "frame,parameter,value\n0,noise.shot,true\n");
  mtf("simulate", "seen.toml", "mtf-demo/thermal.exr", "-o", "same.%04d.exr", "--schedule", "frames.csv", "--frames", "0:0", "--quiet");
  assert.deepEqual(await pixelsOnPage(fresh.page, frame), pixelsOf("same.0000.exr", places(frame)));
  await fresh.page.close();
  assert.equal(await again.end(), 0);
}

async function endure(browser, minutes) {
  mtf("demo", "-o", "mtf-demo");
  const server = await serve();
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 } });
  const pages = [await open(context, server.address), await open(context, server.address)];
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

const browser = await chromium.launch({ executablePath: options.chromium, args: flags });
try {
  if (options.minutes) await endure(browser, Number(options.minutes));
  else await checkChain(await checkPage(browser));
  console.log("live: ok");
} finally {
  await browser.close();
}
