// SPDX-License-Identifier: Apache-2.0
// The 3-D view of `mtf live`: the camera goes around and the picture follows; at rest it is that of the command line on the
// page, `mtf render` and `mtf simulate`; saved files give the same frame; what cannot be is said at its control.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { context, field, open, pixelsOnPage, places, press, settle, slide, slider, unfold } from "./helpers.mjs";
import { checkLooks } from "./looks.mjs";

// A box and a warm plate on soil, in changing temperatures, through air.
const SCENE = `schema = 1
[place]
latitude = "40 deg"
longitude = "0 deg"
altitude = "0 m"
[time]
start = 2026-06-21T12:00:00Z
end = 2026-06-21T14:00:00Z
step = "1 h"
[weather]
air_temperature = "288 K"
wind_speed = "2 m/s"
direct_normal = "700 W/m2"
diffuse_horizontal = "80 W/m2"
longwave_down = "320 W/m2"
vapour_pressure = "10 hPa"
[[material]]
name = "paint"
solar_absorptance = 0.7
emissivity = 0.85
layers = [{ conductivity = "45 W/m/K", density = "7800 kg/m3", heat_capacity = "480 J/kg/K", thickness = "2 mm" }]
[[mesh]]
name = "plates"
file = "plates.obj"
[[region]]
mesh = "plates"
group = "soil"
temperature = "290 K"
material = "paint"
[[region]]
mesh = "plates"
group = "target"
temperature = "warming.csv"
material = "paint"
[camera]
path = "flight.csv"                     # as mtf fly goes
[atmosphere]
model = "mid_latitude_summer"
`;
const FILES = {
  "plates.toml": SCENE,
  "plates.obj": "v -20 -20 0\nv 20 -20 0\nv 20 20 0\nv -20 20 0\nv -2 0 0.2\nv 2 0 0.2\nv 2 0.5 3.2\nv -2 0.5 3.2\ng soil\nf 1 2 3 4\ng target\nf 5 6 7 8\n",
  "warming.csv": "time (s),temperature (K)\n0,300\n7200,330\n",
  "flight.csv": "time (s),x (m),y (m),z (m),look_x (m),look_y (m),look_z (m)\n0,10,-60,15,0,0,1\n4,20,-60,15,0,0,1\n",
};

/** The five pixels against those of the command on the page, with the names that saved files have. */
async function compare(run, page, what, saved = {}) {
  await settle(page);
  const { command, frame } = await page.evaluate(() => {
    const { id, full_width, full_height, step_x_um, step_y_um, tolerance, radiance_promised, low, high, preview, light_lags } = window.mtfLive.frame;
    return { command: document.getElementById("command").textContent, frame: { id, full_width, full_height, step_x_um, step_y_um, tolerance, radiance_promised, low, high, preview, light_lags } };
  });
  assert.ok(!frame.preview && !frame.light_lags, `${what}: a picture at rest is whole`);
  writeFileSync(join(run.folder, "space-live.toml"), await page.evaluate(() => window.mtfLive.text));
  let line = command.replaceAll("space.toml", "space-live.toml");
  for (const [name, other] of Object.entries(saved)) line = line.replaceAll(name, other);
  const quiet = line.split(" && ").map((one) => `${one} --quiet`).join(" && ");
  await run.shell(quiet);
  const [pixels, reference] = await Promise.all([pixelsOnPage(page, frame), run.pixelsOf("out.exr", places(frame))]);
  // A count of rounding, the plan's tolerance, and tables of the air, which a moved camera has by two heights (1e-4).
  const allowed = 1.05 + 2 * frame.tolerance * (frame.high - frame.low) + 1e-4 * frame.high;
  pixels.forEach((value, i) => assert.ok(Math.abs(value - reference[i]) <= allowed, `${what}: pixel ${places(frame)[i]} is ${value}, not ${reference[i]}; allowed ${allowed}`));
  return { command, pixels, ends: [frame.low, frame.high, ...pixels] };
}

/** A small scene and camera in the folder of a check, without much noise, so that pixels can be compared. */
export async function writeScene(run) {
  for (const [name, text] of Object.entries(FILES)) writeFileSync(join(run.folder, name), text);
  await run.mtf("scene", "demo", "-o", "vehicle", "--quiet");
  const camera = readFileSync(join(run.folder, "vehicle/lwir.toml"), "utf8").replace("[512, 320]", "[96, 80]").replace('"85 mm"', '"10 mm"').replace('netd = "40 mK"', 'netd = "1 mK"');
  writeFileSync(join(run.folder, "space.toml"), camera);
}

/** Other weather and another surface: a heat balance beside pictures, which are then those of the command line. */
async function checkHeat(run, own) {
  const solved = SCENE.replace('temperature = "warming.csv"\n', "").replace('longwave_down', 'relative_humidity = "40 %"\nlongwave_down').replace('vapour_pressure = "10 hPa"\n', "");
  writeFileSync(join(run.folder, "heated.toml"), solved);
  await run.mtf("heat", "heated.toml", "-o", "known", "--quiet");
  const server = await run.serve("heated.toml", "space.toml", "--temperatures", "known", "--time", "2026-06-21T13:00:00Z");
  const { page, said } = await open(own, server.address);
  await page.evaluate(() => { for (const each of document.querySelectorAll("#scene-forms details")) each.open = true; });
  const solving = [];
  await page.exposeFunction("waits", (words) => solving.push(words));
  await page.evaluate(() => setInterval(() => window.mtfLive.frame.solving && window.waits(document.getElementById("preview-tag").textContent), 20));
  const first = await compare(run, page, "temperatures of a folder");
  for (const [name, text] of [["weather.wind_speed", "9 m/s"], ["material.paint.solar_absorptance", "0.2"]]) {
    await field(page, name).fill(text);
    await field(page, name).press("Enter");
    await settle(page);
  }
  assert.match(await page.locator("#difference").textContent(), /- solar_absorptance = 0\.7\n\+ solar_absorptance = 0\.2/);
  const [file] = await Promise.all([page.waitForEvent("download"), press(page, "Save", "#save-scene")]);
  writeFileSync(join(run.folder, "heated-live.toml"), readFileSync(await file.path(), "utf8"));
  const cold = await compare(run, page, "calm and white");
  assert.match(cold.command, /^mtf heat heated-live\.toml -o temperatures-live --force && mtf render heated-live\.toml /);
  assert.ok(cold.ends[1] < first.ends[1], `${cold.ends} after ${first.ends}`);
  assert.ok(solving.some((words) => /^heat balance: \w+/.test(words)), "the page says what is going on");
  // Out of range, and the name of a file: refused at the control.
  for (const text of ["-2 m/s", "/etc/passwd", "weather.csv"]) {
    await field(page, "weather.wind_speed").fill(text);
    await field(page, "weather.wind_speed").press("Enter");
    await page.waitForSelector("[data-name='weather.wind_speed'] .message:not([hidden])");
    await settle(page);
  }
  for (let i = 0; i < 2; i += 1) await page.locator("#undo").click();
  assert.deepEqual((await compare(run, page, "as it was")).ends, first.ends);
  assert.deepEqual(said, []);
  await page.close();
  assert.equal(await server.end(), 0);
}

/** While a heat balance is worked out the page says so, and an interrupt does not wait for it. */
async function checkWaiting(run, own) {
  const server = await run.serve("vehicle/scene.toml", "vehicle/lwir.toml"), page = await own.newPage();
  await page.goto(server.address);
  await page.waitForFunction(() => /heat balance is worked out first: \w+.* \d+ s so far/.test(document.getElementById("overlay").textContent));
  assert.ok(await page.locator("#overlay").isVisible());
  const begin = Date.now();
  assert.equal(await server.end(), 130);
  assert.ok(Date.now() - begin < 1000, `the interrupt took ${Date.now() - begin} ms`);
  await page.waitForFunction(() => /server has ended/.test(document.getElementById("overlay").textContent));
  await page.close();
}

export async function checkSpace(run, browser) {
  await writeScene(run);
  const own = await context(browser);
  await checkWaiting(run, own);
  await checkHeat(run, own);
  const server = await run.serve("plates.toml", "space.toml", "--time", "2026-06-21T12:30:00Z");
  const { page, said, asked } = await open(own, server.address);
  await unfold(page);
  const first = await compare(run, page, "3-D, at the start");
  assert.match(first.command, /^mtf render plates\.toml .*--time 2026-06-21T12:30:00Z --position 10,-60,15 --look-at 0,0,1/);

  // Around by the mouse: pictures while it moves, another one at rest.
  const box = await page.locator("#view").boundingBox(), [x, y] = [box.x + box.width * 0.3, box.y + box.height / 2];
  const shown = () => page.evaluate(() => window.mtfLive.frame.id);
  const before = await shown();
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; i <= 5; i += 1) await page.mouse.move(x + 12 * i, y + 6 * i);
  await page.waitForFunction((id) => window.mtfLive.frame.id > id + 1 && window.mtfLive.frame.preview, before);
  assert.ok(await page.locator("#preview-tag").isVisible());
  await page.mouse.up();
  const around = await compare(run, page, "after dragging");
  assert.notDeepEqual(around.ends, first.ends);
  await page.waitForSelector("#preview-tag", { state: "hidden" });
  await page.mouse.wheel(0, -300);
  await page.waitForFunction(() => window.mtfLive.place.range < 55);
  const nearer = await compare(run, page, "after the wheel");
  assert.notDeepEqual(nearer.ends, around.ends);

  // Undo takes the camera back, one move at a time, and with it what the command line says.
  const placeOf = () => page.evaluate(() => window.mtfLive.place.request());
  const moved = await placeOf();
  for (const step of ["undo", "undo"]) await page.locator(`#${step}`).click();
  assert.deepEqual((await compare(run, page, "two moves undone")).ends, first.ends);
  assert.ok(await page.locator("#undo").isDisabled());
  for (const step of ["redo", "redo"]) await page.locator(`#${step}`).click();
  assert.deepEqual(await placeOf(), moved);
  assert.deepEqual((await compare(run, page, "and done again")).ends, nearer.ends);

  // Keys, sliders, typed values; time and sensor with them.
  await page.locator("#view").focus();
  for (const key of ["ArrowUp", "Shift+ArrowLeft", "PageUp", "-"]) await page.keyboard.press(key);
  await slide(page, "camera.time", 0.75);
  await slide(page, "jitter.rms", 0.7);
  const later = await compare(run, page, "keys, time and a sensor's number");
  assert.match(later.command, /--time 2026-06-21T13:30:00Z/);
  // The equation of time is -1.9 min in June.
  assert.match(await page.locator("#sun").textContent(), /^Local 13:30 \(UTC\+0 by longitude\), solar 13:28\nSun \d\d\.\d° above the horizon: day$/);
  await checkLooks(run, page, "camera");
  await field(page, "camera.range").fill("0.08 km");
  await field(page, "camera.range").press("Enter");
  await settle(page);
  assert.ok(Math.abs(await page.evaluate(() => window.mtfLive.place.range) - 80) < 1e-9);

  // What cannot be: the program's words at the control, the last good picture stays.
  const kept = await placeOf();
  for (const [name, text, words] of [["camera.elevation", "-60 deg", /below the ground/], ["camera.look_at", "0, 0, 5000", /sees no facet/], ["camera.range", "-3 m", /above 0 belongs/], ["camera.time", "2027-01-01", /a time from/]]) {
    const last = await shown();
    await field(page, name).fill(text);
    await field(page, name).press("Enter");
    await page.waitForSelector(`[data-name='${name}'] .message:not([hidden])`);
    assert.match(await page.locator(`[data-name='${name}'] .message`).textContent(), words);
    assert.equal(await shown(), last, name);
    if (name === "camera.elevation") await checkLooks(run, page, "refused");
    await page.keyboard.press("Escape");
    await settle(page);
    assert.deepEqual(await placeOf(), kept, `${name}: one key goes back`);
    await page.waitForSelector("#problem", { state: "hidden" });
  }

  // A link restores the camera; the saved files reproduce the frame.
  await slide(page, "camera.azimuth", 0.6);
  const there = await compare(run, page, "before saving");
  const other = await open(own, page.url());
  assert.deepEqual(await other.page.evaluate(() => window.mtfLive.place.request()), await page.evaluate(() => window.mtfLive.place.request()));
  assert.deepEqual(other.said, []);
  await other.page.close();
  const [file] = await Promise.all([page.waitForEvent("download"), press(page, "Save", "#save-scene")]);
  const saved = readFileSync(await file.path(), "utf8");
  assert.ok(saved.includes("[camera]\nposition = [") && !saved.includes("path =") && saved.includes("[atmosphere]"), saved);
  writeFileSync(join(run.folder, "plates-live.toml"), saved);
  const again = await compare(run, page, "the saved scene", { "plates.toml": "plates-live.toml", [/--position \S+ --look-at \S+/.exec(there.command)[0]]: "" });
  assert.deepEqual(again.pixels, there.pixels);

  // Two sensors, one camera.
  await page.locator("#keep").click();
  await settle(page);
  assert.ok(await slider(page, "jitter.rms").isVisible());
  await page.locator("#edit-a").click();
  await slide(page, "jitter.rms", 0.2);
  const [left, right] = await page.evaluate(() => window.mtfLive.frames);
  assert.equal(left.utc_s, right.utc_s);
  assert.notEqual(left.id, right.id);
  assert.match(await page.locator("#left-tag").textContent(), /^A: /);
  assert.deepEqual(said, []);
  for (const url of asked) assert.ok(url.startsWith(server.address.split("#")[0]), url);
  await page.close();
  assert.equal(await server.end(), 0);
}
