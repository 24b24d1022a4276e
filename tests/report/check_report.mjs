// SPDX-License-Identifier: Apache-2.0
// Opens reports in headless Chromium: nothing asked of the network, nothing on the console, charts drawn, values those
// of designs.csv, filters and themes at work, print as vectors. Times are printed, not judged.
// Usage: node check_report.mjs --modules DIR --chromium FILE --mtf FILE --python FILE --work DIR

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync, statSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { promisify } from "node:util";

const options = {};
for (let i = 2; i + 1 < process.argv.length; i += 2) options[process.argv[i].slice(2)] = process.argv[i + 1];
const { chromium } = createRequire(join(options.modules, "x.js"))("playwright-core");
const maker = join(dirname(fileURLToPath(import.meta.url)), "make_sweep.py");
const flags = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync"];

// RFC 4180.
function parseCsv(text) {
  const rows = [[]];
  for (let i = 0; i < text.length;) {
    let cell = "";
    if (text[i] === '"') {
      for (i += 1; !(text[i] === '"' && text[i + 1] !== '"'); i += 1) {
        if (text[i] === '"') i += 1;
        cell += text[i];
      }
      i += 1;
    } else {
      const end = text.slice(i).search(/[,\n]/);
      cell = text.slice(i, i + end);
      i += end;
    }
    rows.at(-1).push(cell);
    if (text[i] === "\n" && i + 1 < text.length) rows.push([]);
    i += 1;
  }
  return rows;
}

const run = promisify(execFile);
async function makeReport(kind, points) {
  const folder = join(options.work, kind + points);
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  await run(options.python, [maker, folder, "--kind", kind, "--points", String(points)]);
  await run(options.mtf, ["report", folder, "--quiet"]);
  return folder;
}

// A page with everything it says and asks for.
async function openPage(context, file) {
  const page = await context.newPage();
  const said = [], asked = [];
  page.on("console", (message) => { if (["error", "warning"].includes(message.type())) said.push(message.text()); });
  page.on("pageerror", (error) => said.push(String(error)));
  page.on("request", (request) => { if (!request.url().startsWith("data:")) asked.push(request.url()); });
  await page.goto(pathToFileURL(file).href);
  return { page, said, asked };
}

const chartIds = ["scatter", "parallel", "map", "curves", "noise", "indices", "accuracy"];

async function checkCharts(page, expected) {
  for (const id of expected) {
    const marks = await page.evaluate((chart) => {
      const view = document.querySelector(`#${chart} .view`);
      const canvas = view.querySelector("canvas");
      if (canvas) {
        const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
        return pixels.filter((value, i) => i % 4 === 3 && value > 0).length;
      }
      return view.querySelectorAll(".vega-embed svg .role-mark path, .vega-embed svg .role-mark line").length;
    }, id);
    assert.ok(marks > 2, `chart ${id} has ${marks} marks`);
  }
}

async function checkValues(page, folder) {
  const csv = parseCsv(readFileSync(join(folder, "designs.csv"), "utf8"));
  const [header, ...rows] = csv;
  const data = JSON.parse(await page.locator("#data").textContent());
  assert.deepEqual(data.columns.map((column) => column.name), header.slice(1));
  data.design.forEach((design, i) => {
    assert.equal(rows[design][0], String(design));
    data.columns.forEach((column, c) => {
      const value = data.cells[c][i], cell = rows[design][c + 1];
      assert.ok(cell === "" ? value === null : typeof value === "number" ? value === Number(cell) : value === cell,
        `design ${design} ${column.name}: ${value} in the page, ${cell} in the file`);
    });
  });
  // What is seen: the table of the chosen designs.
  const seen = await page.evaluate(() => {
    const table = document.querySelector('[aria-label="Values of the chosen designs"] table');
    const designs = [...table.querySelectorAll("thead .key")].map((key) => key.dataset.design);
    return [...table.querySelectorAll("tbody tr")].map((row) => ({
      name: (row.querySelector("th abbr") ?? row.querySelector("th").firstChild).textContent.trim(),
      cells: [...row.querySelectorAll("td")].map((cell, i) => [designs[i], cell.querySelector("data")?.value, cell.textContent]),
    }));
  });
  let compared = 0;
  for (const { name, cells } of seen) {
    const column = header.indexOf(name);
    for (const [design, value, text] of cells) {
      if (column < 0 || value === undefined) continue;
      const cell = rows[Number(design)][column];
      assert.equal(value, cell);
      assert.ok(Math.abs(Number(text) - Number(cell)) <= 6e-5 * Math.abs(Number(cell)) + 1e-8, `${name}: ${text} for ${cell}`);
      compared += 1;
    }
  }
  assert.ok(compared >= seen[0].cells.length * 5, `only ${compared} values were compared`);
  return { header, rows, data };
}

// No text of a chart reaches beyond the chart, where it would be cut off.
async function checkText(page) {
  const cut = await page.evaluate(() => [...document.querySelectorAll(".view svg")].flatMap((svg) => {
    const around = svg.getBoundingClientRect();
    return [...svg.querySelectorAll("text")].filter((text) => {
      const box = text.getBoundingClientRect();
      return box.width > 0 && (box.left < around.left - 1 || box.right > around.right + 1 || box.top < around.top - 1 || box.bottom > around.bottom + 1);
    }).map((text) => text.textContent);
  }));
  assert.deepEqual(cut, []);
}

// Filters by keyboard, picking a design, other columns, the other theme.
async function checkInteraction(page, { header, rows, data }) {
  const feasible = header.indexOf("feasible");
  await page.locator("#filters summary").focus();
  await page.keyboard.press("Enter");
  await page.getByLabel("feasible only").focus();
  await page.keyboard.press("Space");
  const wanted = data.design.filter((design) => rows[design][feasible] === "1").length;
  await page.waitForFunction((n) => document.querySelector("#filters output").textContent.startsWith(`${n} of `), wanted);
  const low = await page.locator('#filters input[type="number"]').first();
  const column = header.indexOf(data.axes[0].column);
  const middle = (Math.min(...rows.map((row) => Number(row[column]))) + Math.max(...rows.map((row) => Number(row[column])))) / 2;
  await low.fill(String(middle));
  const left = data.design.filter((design) => rows[design][feasible] === "1" && Number(rows[design][column]) >= middle).length;
  assert.ok(left > 0 && left < wanted);
  await page.waitForFunction((n) => document.querySelector("#filters output").textContent.startsWith(`${n} of `), left);

  const chosen = data.chosen.find((one) => Number(rows[one.design][column]) >= middle).design;
  await page.evaluate((design) => pick(design), chosen);
  const shown = await page.locator("#picked dd").allTextContents();
  const cells = data.columns.map((one, c) => ({ ...one, cell: rows[chosen][c + 1] })).filter((one) => !one.gap);
  assert.deepEqual(shown.map((text, i) => (cells[i].cell === "" ? text === "–" : Number(text) === Number(cells[i].cell))), cells.map(() => true));

  await page.locator("#scatter select").first().selectOption({ index: 2 });
  await page.locator("#curves select").first().selectOption({ index: 1 });
  await page.locator("#curves select").nth(1).selectOption("cy/px");
  await page.waitForTimeout(300);
  await page.locator("#theme").click();
  await page.waitForFunction(() => document.documentElement.dataset.theme === "dark");
  await page.waitForTimeout(500);  // charts are drawn again
  await checkDark(page);
}

// Dark paper, and on it text with the contrast of WCAG 2 for text, lines with that for graphics.
async function checkDark(page) {
  const contrast = await page.evaluate(() => {
    const luminance = (colour) => {
      const [r, g, b] = colour.match(/\w\w/g).map((two) => parseInt(two, 16) / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
      return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const style = getComputedStyle(document.documentElement), of = (name) => luminance(style.getPropertyValue(name).trim());
    const against = (name) => (of(name) + 0.05) / (of("--paper") + 0.05);
    return { paper: getComputedStyle(document.body).backgroundColor, text: ["--ink", "--soft", "--accent"].map(against),
      lines: ["--s0", "--s1", "--s2", "--s3", "--s4", "--s5", "--s6", "--s7", "--bar", "--warn"].map(against) };
  });
  assert.ok(contrast.paper.match(/\d+/g).every((part) => Number(part) < 40), contrast.paper);
  assert.ok(contrast.text.every((ratio) => ratio >= 4.5), contrast.text.join());
  assert.ok(contrast.lines.every((ratio) => ratio >= 3), contrast.lines.join());
}

// The best designs are read before anything is scrolled: values with units, limits in words, conditions, the date.
async function checkFirstScreen(page, { header, rows, data }, sweep) {
  const answers = await page.locator(".answer").all();
  assert.equal(answers.length, sweep.best.length);
  for (const [i, best] of sweep.best.entries()) {
    const box = await answers[i].boundingBox(), text = (await answers[i].textContent()).replace(/\u00a0/g, " ");
    assert.ok(box.y + box.height < 900, `answer ${i} ends at ${box.y + box.height}`);
    const cells = await answers[i].locator("data").evaluateAll((all) => all.map((one) => one.value));
    const asked = [data.objectives[i].column, ...data.axes.map((axis) => axis.column), ...sweep.constraints.flatMap((one) => one.columns)];
    for (const name of asked) {
      const { unit } = data.columns.find((one) => one.name === name), cell = rows[best.design][header.indexOf(name)];
      assert.ok(cells.includes(cell) || (cell.startsWith("[") && text.includes(cell)), `${name} is not in: ${text}`);
      assert.ok(text.includes(unit), `${unit} is not in: ${text}`);
    }
    for (const limit of best.limits) assert.ok(text.includes(`${limit.text} (${limit.state})`), text);
  }
  for (const line of sweep.conditions.lines) assert.ok((await page.locator(".conditions").textContent()).includes(line));
  assert.ok((await page.locator("header").textContent()).includes(sweep.date));
}

// Every column that varies has an axis with its unit; an axis that is turned round says so.
async function checkParallel(page, { rows, data }) {
  const texts = await page.locator("#parallel svg text").allTextContents();
  const shown = data.columns.map((column, c) => ({ ...column, cells: new Set(rows.map((row) => row[c + 1])) }))
    .filter((one) => one.cells.size > 1 && one.levels.length === 0 && ["axis", "metric", "objective", "link", "yield"].includes(one.role));
  for (const unit of new Set(shown.map((one) => one.unit).filter(Boolean)))
    assert.equal(texts.filter((text) => text === `(${unit})`).length, shown.filter((one) => one.unit === unit).length, unit);
  const turned = await page.locator("#parallel").evaluate((chart) => chart.textContent.split("turned round").length - 1);
  assert.equal(turned, data.objectives.filter((one) => !one.maximize).length);
}

// Every value has its own colour, also beyond the best feasible one; lines stand where neighbours differ in a limit.
async function checkMap(page, { header, rows, data }) {
  const name = await page.evaluate(() => map.value.name);
  const values = rows.map((row) => row[header.indexOf(name)]).filter((cell) => cell !== "").map(Number);
  assert.deepEqual(await page.evaluate(() => drawn.get("map").view.scale("color").domain()), [Math.min(...values), Math.max(...values)]);
  if (!await page.evaluate(() => isGrid)) return;
  const [xs, ys] = data.axes.map((axis) => axis.values), keeps = { "<": (v, limit) => v < limit, ">": (v, limit) => v > limit };
  let borders = 0;
  for (const { columns: [column], limit, relation } of data.constraints) {
    const kept = rows.map((row) => keeps[relation](Number(row[header.indexOf(column)]), limit));
    for (let i = 0; i < xs.length; ++i)
      for (let j = 0; j < ys.length; ++j) {
        if (i + 1 < xs.length && kept[i * ys.length + j] !== kept[(i + 1) * ys.length + j]) borders += 1;
        if (j + 1 < ys.length && kept[i * ys.length + j] !== kept[i * ys.length + j + 1]) borders += 1;
      }
  }
  assert.equal(await page.locator("#map .mark-rule line").count(), 2 * borders);  // each with a halo
}

// Numbers of designs cover neither rings nor diamonds.
async function checkLabels(page) {
  const [texts, covered] = await page.evaluate(() => {
    const boxes = (marks) => [...document.querySelectorAll(`#scatter .role-mark.${marks}`)].map((one) => one.getBoundingClientRect());
    const texts = boxes("mark-text text:not([opacity='0'])"), symbols = boxes("mark-symbol:not(.layer_0_marks) path");
    const meet = (a, b) => a.left < b.right - 2 && b.left < a.right - 2 && a.top + 3 < b.bottom && b.top < a.bottom - 3;
    return [texts.length, texts.filter((text) => symbols.some((symbol) => meet(text, symbol))).length];
  });
  assert.ok(texts > 0 && covered === 0, `${covered} of ${texts} numbers cover marks`);
}

// A single design: every column with its unit and, of metrics, the error; nothing of a space of designs.
async function checkDataSheet(page, folder) {
  const [header, cells] = parseCsv(readFileSync(join(folder, "designs.csv"), "utf8"));
  const error = Number(cells[header.indexOf("error")]);
  const seen = await page.evaluate(() => [...document.querySelectorAll('[aria-label="Values of the chosen designs"] tbody tr')].map((row) =>
    [row.querySelector(".unit")?.textContent ?? "", ...[...row.children].map((cell) => cell.querySelector("data")?.value ?? cell.textContent)]));
  const wanted = JSON.parse(readFileSync(join(folder, "sweep.json"), "utf8")).columns.filter((one) => !one.gap);
  assert.deepEqual(seen.map(([unit]) => unit), wanted.map(({ unit }) => unit));
  for (const [i, { name, role, unit }] of wanted.entries()) {
    if (role !== "metric") continue;
    const [, , value, spread] = seen[i], bound = error * (unit === "" && Math.abs(Number(value)) <= 1 ? 1 : Math.abs(Number(value)));
    assert.equal(value, cells[header.indexOf(name)]);
    assert.ok(Math.abs(Number(spread) - bound) <= 0.05 * bound, `${name} ${spread} for ${bound}`);
  }
  for (const id of ["scatter", "parallel", "map", "indices"]) assert.equal(await page.locator(`#${id}`).count(), 0, id);
}

async function checkPrint(page) {
  const canvases = await page.locator(".view canvas").count();
  await page.evaluate(() => dispatchEvent(new Event("beforeprint")));
  assert.equal(await page.locator(".view .print svg").count(), canvases, "every canvas prints as an SVG");
  await page.evaluate(() => dispatchEvent(new Event("afterprint")));
  assert.equal(await page.locator(".view .print").count(), 0);
  const pdf = await page.pdf({ format: "A4" });
  assert.equal(pdf.subarray(0, 5).toString(), "%PDF-");
  assert.ok(pdf.length > 30_000, `a PDF of ${pdf.length} bytes`);
  assert.ok(pdf.toString("latin1").match(/\/Type\s*\/Page\b/g).length >= 3);
}

const profile = mkdtempSync(join(tmpdir(), "mtfkit_report_"));
const context = await chromium.launchPersistentContext(profile, { executablePath: options.chromium, headless: true, args: flags,
  colorScheme: "light", viewport: { width: 1280, height: 900 } });
try {
  const kinds = [["grid", 400, []], ["sobol", 3000, []], ["sobol", 300, []], ["levels", 40, ["map"]], ["infeasible", 100, []], ["one", 1, ["scatter", "parallel", "map", "indices"]], ["grid", 25000, []]];
  // Each report is made while the page before it is looked at.
  const made = kinds.slice(0, 1).map(([kind, points]) => makeReport(kind, points));
  for (const [i, [kind, points, missing]] of kinds.entries()) {
    const folder = await made[i];
    if (i + 1 < kinds.length) {
      made.push(makeReport(kinds[i + 1][0], kinds[i + 1][1]));
      made.at(-1).catch(() => {});  // is said when its turn comes
    }
    const file = join(folder, "report.html");
    const size = statSync(file).size;
    assert.ok(size < 2e6, `${file} has ${size} bytes`);
    const { page, said, asked } = await openPage(context, file);
    await page.waitForFunction(() => document.documentElement.dataset.ready);
    const times = await page.evaluate(() => ({ first: document.documentElement.dataset.first, all: document.documentElement.dataset.ready,
      paint: Math.round(performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? NaN) }));
    console.log(`${kind} ${points}: ${size} bytes, first paint ${times.paint} ms, designs drawn ${times.first} ms, all charts ${times.all} ms`);
    await checkCharts(page, chartIds.filter((id) => !missing.includes(id)));
    await checkText(page);
    if (kind === "one") {
      await checkDataSheet(page, folder);
    } else {
      const values = await checkValues(page, folder);
      await checkFirstScreen(page, values, JSON.parse(readFileSync(join(folder, "sweep.json"), "utf8")));
      if (!missing.includes("map") && points < 1000) await checkMap(page, values);
      if (points < 5000) {
        await checkParallel(page, values);
        await checkLabels(page);
      }
      assert.deepEqual(await page.evaluate(() => drawn.get("indices").view.scale("x").domain()), [0, 1]);
      if (kind === "grid") await checkInteraction(page, values);
    }
    await checkPrint(page);
    assert.deepEqual(said, []);
    // The policy holds: text cannot become code, nothing can be fetched.
    const session = await context.newCDPSession(page);  // page.evaluate itself stands above the policy
    const { result } = await session.send("Runtime.evaluate", { allowUnsafeEvalBlockedByCSP: false, returnByValue: true,
      expression: "(() => { try { return new Function('return 1')(); } catch (error) { return error.name; } })()" });
    assert.equal(result.value, "EvalError");
    assert.equal(await page.evaluate(() => fetch("data:text/plain,x").then(() => "fetched", (error) => error.name)), "TypeError");
    assert.deepEqual(asked, [pathToFileURL(file).href]);
    await page.close();
  }
} finally {
  await context.close();
  rmSync(profile, { recursive: true, force: true });
}

// Without scripts: the static charts, dark for readers who have set that.
const browser = await chromium.launch({ executablePath: options.chromium, headless: true, args: flags });
try {
  const still = await browser.newContext({ javaScriptEnabled: false, colorScheme: "dark" });
  const { page } = await openPage(still, join(options.work, "grid400", "report.html"));
  assert.ok(await page.locator("svg.static").count() >= 6);
  assert.ok(await page.locator("svg.static").first().isVisible());
  await checkText(page);
  assert.equal(await page.locator("body").evaluate((body) => getComputedStyle(body).backgroundColor), "rgb(20, 24, 29)");
} finally {
  await browser.close();
}
console.log("report page: ok");
