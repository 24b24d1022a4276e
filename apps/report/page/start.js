// SPDX-License-Identifier: Apache-2.0
// Draws everything, from the top of the page down. A chart that fails keeps its static figure.

const starts = [startDesigns, startMaps, startCurves, startNoise, startIndices, startAccuracy];

async function drawAll(first) {
  for (const start of starts) {
    try {
      await start();
    } catch (error) {
      console.error(start.name, error);
    }
    if (first) document.documentElement.dataset.first ??= String(Math.round(performance.now()));
    await new Promise((done) => setTimeout(done));  // the page stays alive between charts
  }
  if (first) document.documentElement.dataset.ready = String(Math.round(performance.now()));
}

function setKeys() {
  for (const key of document.querySelectorAll(".key[data-design]"))
    key.style.setProperty("--key", designColour(Number(key.dataset.design)));
}

// The style sheet follows the reader's setting by itself; the button overrules that.
const darkRule = [...document.styleSheets[0].cssRules].find((rule) => rule.media?.mediaText.includes("prefers-color-scheme"));

function setTheme(theme) {
  darkRule.media.mediaText = theme === "dark" ? "all" : "not all";
  document.documentElement.dataset.theme = theme;
  document.getElementById("theme").textContent = theme === "dark" ? "Light" : "Dark";
  setKeys();
}

const themeButton = document.getElementById("theme");
themeButton.hidden = false;
themeButton.addEventListener("click", () => {
  setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  for (const controls of document.querySelectorAll(".chart .controls, #filters")) controls.textContent = "";
  filters.clear();
  only.feasible = only.front = false;
  drawAll(false);
});
setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
drawAll(true);
