// SPDX-License-Identifier: Apache-2.0
// What tests of the live view's page share: the server, a page at rest, its controls, pixels of the page and of files.
// Options: --modules DIR --chromium FILE --mtf FILE --work DIR [--minutes N] [--seed N] [--space no]

import { execFile, spawn } from "node:child_process";
import { mkdirSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { createInterface } from "node:readline";
import { promisify } from "node:util";

export const options = {};
for (let i = 2; i + 1 < process.argv.length; i += 2) options[process.argv[i].slice(2)] = process.argv[i + 1];
const { chromium } = createRequire(join(options.modules, "x.js"))("playwright-core");
const flags = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"];
const run = promisify(execFile);
export const context = (browser) => browser.newContext({ viewport: { width: 1280, height: 800 }, acceptDownloads: true, permissions: ["clipboard-read", "clipboard-write"] });

/** A check with a folder of its own, so that several run beside each other: programs there, and values of their files. */
export function job(name) {
  const folder = join(options.work, name);
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  const env = { ...process.env, PATH: `${dirname(options.mtf)}:${process.env.PATH}` };
  const output = async (program, words) => (await run(program, words, { cwd: folder, env, encoding: "utf8", maxBuffer: 1 << 26 })).stdout;
  return {
    folder,
    mtf: (...words) => output(options.mtf, words),
    shell: (line) => output("sh", ["-c", line]),
    serve: (...words) => serve(folder, words),
    pixelsOf: async (file, wanted) => (await output("/usr/bin/python3", ["-c", READ, join(folder, file), ...wanted.flat()])).trim().split("\n").map(Number),
  };
}

export const launch = () => chromium.launch({ executablePath: options.chromium, args: flags });

async function serve(folder, words) {
  const child = spawn(options.mtf, ["live", "--no-browser", ...words], { cwd: folder, stdio: ["ignore", "pipe", "ignore"] });
  const address = await new Promise((resolve, reject) => {
    createInterface({ input: child.stdout }).once("line", resolve);
    child.once("exit", (code) => reject(new Error(`mtf live ended with ${code}`)));
  });
  return { child, address, end: () => new Promise((resolve) => { child.once("exit", resolve); child.kill("SIGINT"); }) };
}

// A page with everything it says and asks for; nothing is intercepted, as the answers of a held request would be late.
export async function open(context, address) {
  const page = await context.newPage(), said = [], asked = [];
  // Reading pixels back, which tests do, is slow; Chromium says so.
  page.on("console", (message) => /GPU stall due to ReadPixels/.test(message.text()) || said.push(message.text()));
  page.on("pageerror", (error) => said.push(String(error)));
  page.on("request", (request) => { if (!/^(data|blob):/.test(request.url())) asked.push(request.url()); });
  await page.goto(address);
  await rest(page);
  await page.waitForFunction(() => window.mtfLive?.text);
  return { page, said, asked };
}
// A picture of the largest format that sliders reach takes long.
export const rest = (page, timeout = 60000) => page.waitForFunction(() => window.mtfLive?.frame && window.mtfLive.figures && !window.mtfLive.busy, null, { timeout });
/** At rest, and still at rest when what that has begun is over. */
export const settle = async (page, timeout) => {
  await page.waitForTimeout(10);
  await rest(page, timeout);
  await page.waitForTimeout(10);
  await rest(page, timeout);
};
export const slider = (page, name) => page.locator(`[data-name="${name}"] input[type=range]`);
export const field = (page, name) => page.locator(`[data-name="${name}"] :is(input[type=text], select):not(.end)`);
export async function slide(page, name, share) {
  await slider(page, name).evaluate((element, t) => {
    for (const at of [t * 500, t * 800, t * 1000]) {
      element.value = at;
      element.dispatchEvent(new Event("input", { bubbles: true }));
    }
    element.dispatchEvent(new Event("change", { bubbles: true }));
  }, share);
  await settle(page);
}
/** A button of one of the menus Save and Share. */
export async function press(page, menu, button) {
  if (!(await page.locator(button).isVisible())) await page.getByRole("button", { name: menu, exact: true }).click();
  await page.locator(button).click();
}
export const unfold = (page) => page.evaluate(() => { for (const each of document.querySelectorAll("#forms details")) each.open = true; });

export const pixelsOnPage = (page, frame) => page.evaluate(async ({ frame: { id, step_x_um, step_y_um }, wanted }) => {
  const head = { "X-Mtf-Token": location.hash.slice(1).split("/")[0], "Content-Type": "application/json" };
  const all = [];
  for (const [x, y] of wanted) {
    const body = JSON.stringify({ id, edits: window.mtfLive.edits, number: window.mtfLive.state.number, x_um: (x + 0.5) * step_x_um, y_um: (y + 0.5) * step_y_um });
    const answer = await (await fetch("/value", { method: "POST", headers: head, body })).json();
    all.push(answer.after?.value ?? answer.error);
  }
  return all;
}, { frame, wanted: places(frame) });
export const places = ({ full_width: w, full_height: h }) => [[0, 0], [w - 1, h - 1], [Math.floor(w / 2), Math.floor(h / 2)], [Math.floor(w / 3), Math.floor(h / 5)], [Math.floor(w / 4), h - 2]];

/** Values of an uncompressed or ZIP-compressed scanline OpenEXR of one float channel; the other formats are not ours. */
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
