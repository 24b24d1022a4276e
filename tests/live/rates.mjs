// SPDX-License-Identifier: Apache-2.0
// Frame rates of `mtf live` in Chromium without a window, 1280 x 1024: a slider that moves every 8 ms, as a mouse does.
// Prints rounds of 3 s, what a picture costs each process (ms of one core: on a machine that others share it tells
// more than the rate), and when the first picture is there after the command in a browser that runs, beside a page of
// one canvas; nothing is judged. Run by hand on a quiet machine.
// Usage: node rates.mjs --chromium FILE --mtf FILE [--slider NAME,...] [--rounds N] [--sensor FILE --scene FILE] [--query plain|webgl]
//        of a 3-D scene: --scene scene.toml --sensor camera.toml --temperatures DIR [--time UTC], and sliders as
//        camera.azimuth too; camera.azimuth,jitter.rms moves both

import { spawn } from "node:child_process";
import { readFileSync, readdirSync } from "node:fs";
import { loadavg } from "node:os";
import { createInterface } from "node:readline";
import { launch, sleep, until } from "./chromium.mjs";

const STARTED_MS = 2500; // a browser has other things to do when it begins
const options = { slider: "jitter.rms", rounds: "8" };
for (let i = 2; i + 1 < process.argv.length; i += 2) options[process.argv[i].slice(2)] = process.argv[i + 1];

const KINDS = { server: /mtf\0live/, page: /--type=renderer/, painting: /--type=gpu/, network: /--utility-sub-type=network/, browser: /chromium\0/ };
/** Processor time of each kind of process, ms. */
function processorTimes() {
  const ms = Object.fromEntries(Object.keys(KINDS).map((kind) => [kind, 0]));
  for (const id of readdirSync("/proc").filter((name) => /^\d+$/.test(name))) try {
    const command = readFileSync(`/proc/${id}/cmdline`, "utf8"), kind = Object.keys(KINDS).find((one) => KINDS[one].test(command));
    const fields = readFileSync(`/proc/${id}/stat`, "utf8").replace(/^.*\) /, "").split(" ");
    if (kind) ms[kind] += 10 * (Number(fields[11]) + Number(fields[12]));
  } catch { /* it has ended */ }
  return ms;
}

const browser = await launch(options.chromium, { width: 1280, height: 1024 });
const measure = async (name) => {
  const sliders = name.split(",").map((one) => document.querySelector(`[data-name="${one}"] input[type=range]`)), asked = new Map(), fetching = window.fetch;
  if (sliders.includes(null)) throw new Error(`there is no slider of ${name}: ${[...document.querySelectorAll("[data-name]")].map((row) => row.dataset.name).join(" ")}`);
  // A value is as old as the request that took it along.
  window.fetch = (place, options) => {
    if (place === "/frame") asked.set(JSON.parse(options.body).generation, performance.now());
    return fetching(place, options);
  };
  const at = { step: 0, last: window.mtfLive.frame.id };
  setInterval(() => {
    at.step = (at.step + 37) % 600;
    for (const slider of sliders) {
      slider.value = 200 + at.step;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    }
  }, 8);
  window.round = async () => {
    const delays = [], server = [], start = performance.now();
    while (performance.now() - start < 3000) {
      while (window.mtfLive.frame.id === at.last && performance.now() - start < 3000) await new Promise((resolve) => setTimeout(resolve, 1));
      const { id, generation, ms } = window.mtfLive.frame;
      if (id === at.last) break;
      at.last = id;
      server.push(ms);
      requestAnimationFrame(() => delays.push(performance.now() - asked.get(generation)));
    }
    await new Promise((resolve) => requestAnimationFrame(resolve));
    if (server.length === 0) throw new Error("no picture within 3 s: are all values refused?");
    for (const list of [delays, server]) list.sort((a, b) => a - b);
    const middle = (list) => list[Math.floor(list.length / 2)];
    return { pictures: server.length, median: middle(delays), worst: delays.at(-1), server: middle(server), preview: window.mtfLive.frame.preview };
  };
};

let child = null;
try {
  await sleep(STARTED_MS);
  let begin = Date.now();
  const blank = await browser.page(`data:text/html,<canvas id=c width=600 height=800></canvas><script>c.getContext("2d").fillRect(0,0,9,9);requestAnimationFrame(()=>{window.drawn=true})</script>`);
  await until(blank, "window.drawn");
  const alone = Date.now() - begin;
  await sleep(500);

  begin = Date.now();
  const space = options.scene?.endsWith(".toml");
  const files = space ? [options.scene, options.sensor, ...(options.temperatures ? ["--temperatures", options.temperatures] : []), ...(options.time ? ["--time", options.time] : [])]
    : options.sensor ? [options.sensor, options.scene] : [];
  child = spawn(options.mtf, ["live", "--no-browser", ...files], { stdio: ["ignore", "pipe", "inherit"] });
  const address = await new Promise((resolve, reject) => { createInterface({ input: child.stdout }).once("line", resolve); child.once("exit", (code) => reject(new Error(`mtf live ended with ${code}`))); });
  const ready = Date.now() - begin;
  const page = await browser.page(options.query ? address.replace("/#", `/?${options.query}#`) : address);
  await until(page, "window.mtfLive?.view.drawn > 0 && Boolean(window.mtfLive.frame)");
  console.log(`address after ${ready} ms, first picture after ${Date.now() - begin} ms, of a canvas alone ${alone} ms; load ${loadavg()[0].toFixed(1)}`);
  await sleep(2000);
  await page(`for (const details of document.querySelectorAll("#forms details")) details.open = true; (${measure})(${JSON.stringify(options.slider)})`);
  for (let k = 0; k < Number(options.rounds); k += 1) {
    const before = processorTimes(), { pictures, median, worst, server, preview } = await page("round()"), after = processorTimes();
    const costs = Object.keys(KINDS).map((kind) => `${kind} ${((after[kind] - before[kind]) / pictures).toFixed(0)}`);
    console.log(`${(pictures / 3).toFixed(1)} frames/s, value to picture ${median.toFixed(0)} ms median, ${worst.toFixed(0)} ms worst; server ${server.toFixed(1)} ms; ${preview ? "preview" : "full"}; core ms a picture: ${costs.join(", ")}; load ${loadavg()[0].toFixed(1)}`);
  }
} finally {
  await browser.close();
  child?.kill("SIGINT");
}
