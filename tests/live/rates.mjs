// SPDX-License-Identifier: Apache-2.0
// Frame rates of `mtf live` in headless Chromium, 1280 x 1024: a slider that moves every 8 ms, as a mouse does. Prints
// rounds of 3 s, and when the first picture is there, beside a page of one canvas in a browser of its own; nothing is
// judged. Run by hand on a quiet machine. Without a graphics card Chromium runs WebGL in software GL and puts the page
// together itself; --gl page makes it put the page together in software GL too, which costs more than all else.
// Usage: node rates.mjs --modules DIR --chromium FILE --mtf FILE --slider NAME [--sensor FILE --scene FILE] [--rounds N] [--gl page] [--query plain|webgl]
//        of a 3-D scene: --scene scene.toml --sensor camera.toml --temperatures DIR, and sliders as camera.azimuth too;
//        camera.azimuth,jitter.rms moves both

import { spawn } from "node:child_process";
import { createRequire } from "node:module";
import { loadavg } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";

const options = { slider: "jitter.rms", rounds: "8", gl: "canvas" };
for (let i = 2; i + 1 < process.argv.length; i += 2) options[process.argv[i].slice(2)] = process.argv[i + 1];
const { chromium } = createRequire(join(options.modules, "x.js"))("playwright-core");
const flags = ["--no-sandbox", "--disable-quic"];
if (options.gl === "page") flags.push("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist");
const launch = () => chromium.launch({ executablePath: options.chromium, args: flags });
const viewport = { width: 1280, height: 1024 };

/** Until a page of one canvas has drawn, ms. */
async function canvasAlone() {
  const browser = await launch(), begin = Date.now();
  const page = await (await browser.newContext({ viewport })).newPage();
  await page.goto(`data:text/html,<canvas id=c width=600 height=800></canvas><script>const gl=c.getContext("webgl2");requestAnimationFrame(()=>{gl.clear(gl.COLOR_BUFFER_BIT);window.drawn=true})</script>`);
  await page.waitForFunction(() => window.drawn, null, { polling: 10 });
  const ms = Date.now() - begin;
  await browser.close();
  return ms;
}
const alone = await canvasAlone();

const browser = await launch();
const begin = Date.now();
const space = options.scene?.endsWith(".toml");
const files = space ? [options.scene, options.sensor, ...(options.temperatures ? ["--temperatures", options.temperatures] : []), ...(options.time ? ["--time", options.time] : [])]
  : options.sensor ? [options.sensor, options.scene] : [];
const child = spawn(options.mtf, ["live", "--no-browser", ...files], { stdio: ["ignore", "pipe", "inherit"] });
const address = await new Promise((resolve) => createInterface({ input: child.stdout }).once("line", resolve));
const ready = Date.now() - begin;
const page = await (await browser.newContext({ viewport })).newPage();
await page.goto(options.query ? address.replace("/#", `/?${options.query}#`) : address);
await page.waitForFunction(() => window.mtfLive?.view.drawn > 0 && window.mtfLive.frame, null, { polling: 10 });
console.log(`address after ${ready} ms, first picture after ${Date.now() - begin} ms, of a canvas alone ${alone} ms; load ${loadavg()[0].toFixed(1)}`);
await page.waitForTimeout(1500);
const rounds = await page.evaluate(async ({ name, count }) => {
  for (const details of document.querySelectorAll("#forms details")) details.open = true;
  const sliders = name.split(",").map((one) => document.querySelector(`[data-name="${one}"] input[type=range]`)), out = [], asked = new Map(), fetching = window.fetch;
  // A value is as old as the request that took it along.
  window.fetch = (place, options) => {
    if (place === "/frame") asked.set(JSON.parse(options.body).generation, performance.now());
    return fetching(place, options);
  };
  let at = 0, last = window.mtfLive.frame.id;
  const moving = setInterval(() => {
    at = (at + 37) % 600;
    for (const slider of sliders) {
      slider.value = 200 + at;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    }
  }, 8);
  for (let round = 0; round < count; round += 1) {
    const delays = [], server = [], start = performance.now();
    while (performance.now() - start < 3000) {
      while (window.mtfLive.frame.id === last) await new Promise((resolve) => setTimeout(resolve, 1));
      const { id, generation, ms } = window.mtfLive.frame;
      last = id;
      server.push(ms);
      requestAnimationFrame(() => delays.push(performance.now() - asked.get(generation)));
    }
    for (const list of [delays, server]) list.sort((a, b) => a - b);
    const middle = (list) => list[Math.floor(list.length / 2)];
    out.push({ fps: server.length / 3, median: middle(delays), worst: delays.at(-1), server: middle(server), preview: window.mtfLive.frame.preview });
  }
  clearInterval(moving);
  for (const slider of sliders) slider.dispatchEvent(new Event("change", { bubbles: true }));
  return out;
}, { name: options.slider, count: Number(options.rounds) });
for (const { fps, median, worst, server, preview } of rounds)
  console.log(`${fps.toFixed(1)} frames/s, value to picture ${median.toFixed(0)} ms median, ${worst.toFixed(0)} ms worst; server ${server.toFixed(1)} ms; ${preview ? "preview" : "full"}; load ${loadavg()[0].toFixed(1)}`);
await browser.close();
child.kill("SIGINT");
