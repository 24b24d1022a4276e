// SPDX-License-Identifier: Apache-2.0
// Prints the licences of what the report's charts are built from: every package that vega, vega-lite and vega-embed may
// bundle, those of one licence text together. Usage: node notices.mjs FOLDER, which holds node_modules

import { existsSync, readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";

const folder = join(process.argv[2], "node_modules");
// Only the command-line tools of these packages use them; they are not in the bundles.
const tools = new Set(["yargs", "commander", "iconv-lite", "rw", "@types/estree", "@types/geojson"]);

const seen = new Map();
const waiting = ["vega", "vega-lite", "vega-embed"];
while (waiting.length > 0) {
  const name = waiting.pop();
  if (seen.has(name) || tools.has(name)) continue;
  const at = join(folder, name);
  const about = JSON.parse(readFileSync(join(at, "package.json"), "utf8"));
  const file = readdirSync(at).find((f) => /^(licen[sc]e|copying)/i.test(f));
  const text = file ? readFileSync(join(at, file), "utf8").trim() : "";
  seen.set(name, { version: about.version, licence: about.license ?? "", text });
  for (const dependency of Object.keys(about.dependencies ?? {}))
    if (existsSync(join(folder, dependency))) waiting.push(dependency);
}

// Texts that differ in white space and copyright lines only are one.
const groups = new Map();
for (const [name, { version, licence, text }] of [...seen].sort()) {
  const lines = text.split("\n").map((line) => line.trim());
  const holders = lines.filter((line) => /^copyright (\(c\)|\d)/i.test(line));
  const body = lines.filter((line) => !/^copyright (\(c\)|\d)/i.test(line)).join(" ").replace(/\s+/g, " ").trim();
  const key = body || licence;
  if (!groups.has(key)) groups.set(key, { licence, body, packages: [] });
  groups.get(key).packages.push(`${name} ${version}${holders.length ? ": " + holders.join("; ") : ""}`);
}
for (const { licence, body, packages } of groups.values()) console.log(`${licence}\n${packages.join("\n")}\n${body}\n`);
