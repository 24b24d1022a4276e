// SPDX-License-Identifier: Apache-2.0
// Makes the animated picture of the README, notebooks-data/live.png (APNG): the page while two sliders move.
// Usage: node make_picture.mjs --modules DIR --chromium FILE --mtf FILE --sensor FILE --scene FILE --out FILE
// with the node_modules of the report's packages and the sensor.toml and scene.exr of `mtf demo`.

import { spawn } from "node:child_process";
import { writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { createInterface } from "node:readline";

const options = {};
for (let i = 2; i + 1 < process.argv.length; i += 2) options[process.argv[i].slice(2)] = process.argv[i + 1];
const { chromium } = createRequire(join(options.modules, "x.js"))("playwright-core");
const MOVES = [["jitter.rms", 0.5], ["jitter.rms", 0.66], ["jitter.rms", 0.78], ["jitter.rms", 0.62], ["jitter.rms", 0.5], ["optics.f_number", 0.62], ["optics.f_number", 0.78], ["optics.f_number", 0.6]];
const DELAY_MS = 700;

const crc = (bytes) => {
  let c = ~0;
  for (const byte of bytes) {
    c ^= byte;
    for (let k = 0; k < 8; k += 1) c = c & 1 ? (c >>> 1) ^ 0xedb88320 : c >>> 1;
  }
  return ~c >>> 0;
};
const numbers = (...values) => {
  const out = Buffer.alloc(4 * values.length);
  values.forEach((value, i) => out.writeUInt32BE(value, 4 * i));
  return out;
};
const chunk = (type, data) => {
  const body = Buffer.concat([Buffer.from(type), data]);
  return Buffer.concat([numbers(data.length), body, numbers(crc(body))]);
};
const chunksOf = (png) => {
  const all = [];
  for (let at = 8; at < png.length;) {
    const length = png.readUInt32BE(at);
    all.push({ type: png.toString("latin1", at + 4, at + 8), data: png.subarray(at + 8, at + 8 + length) });
    at += 12 + length;
  }
  return all;
};

/** Screenshots of one size as one animated PNG. */
function animated(shots) {
  const frames = shots.map(chunksOf), head = frames[0].find(({ type }) => type === "IHDR").data;
  const out = [shots[0].subarray(0, 8), chunk("IHDR", head), chunk("acTL", numbers(frames.length, 0))];
  let sequence = 0;
  frames.forEach((chunks, i) => {
    const timing = Buffer.from([DELAY_MS >> 8, DELAY_MS & 255, 1000 >> 8, 1000 & 255, 0, 0]);
    out.push(chunk("fcTL", Buffer.concat([numbers(sequence++, head.readUInt32BE(0), head.readUInt32BE(4), 0, 0), timing])));
    for (const { type, data } of chunks)
      if (type === "IDAT") out.push(i === 0 ? chunk("IDAT", data) : chunk("fdAT", Buffer.concat([numbers(sequence++), data])));
  });
  return Buffer.concat([...out, chunk("IEND", Buffer.alloc(0))]);
}

const child = spawn(options.mtf, ["live", "--no-browser", options.sensor, options.scene], { stdio: ["ignore", "pipe", "inherit"] });
const address = await new Promise((resolve) => createInterface({ input: child.stdout }).once("line", resolve));
const browser = await chromium.launch({ executablePath: options.chromium, args: ["--no-sandbox"] });
const page = await (await browser.newContext({ viewport: { width: 1080, height: 600 }, colorScheme: "dark" })).newPage();
await page.goto(address);
const rest = async () => {
  await page.waitForTimeout(300);
  await page.waitForFunction(() => window.mtfLive?.text && window.mtfLive.figures && !window.mtfLive.busy);
  await page.waitForTimeout(200);
};
await rest();
const shots = [];
for (const [name, share] of MOVES) {
  await page.locator(`[data-name="${name}"] input[type=range]`).evaluate((slider, at) => {
    slider.value = 1000 * at;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    slider.dispatchEvent(new Event("change", { bubbles: true }));
  }, share);
  await rest();
  shots.push(await page.screenshot());
}
writeFileSync(options.out, animated(shots));
await browser.close();
child.kill("SIGINT");
