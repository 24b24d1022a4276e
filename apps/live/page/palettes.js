// SPDX-License-Identifier: Apache-2.0
// 256 colours from dark to bright, by straight lines between a few; each grows in lightness but for `rainbow`.

const STOPS = {
  "white hot": ["#000000", "#ffffff"],
  "black hot": ["#ffffff", "#000000"],
  iron: ["#000010", "#2b0a6b", "#8a0f87", "#c9326a", "#ee6a30", "#fbb124", "#fff6c8"],
  viridis: ["#440154", "#46327e", "#365c8d", "#277f8e", "#1fa187", "#4ac16d", "#a0da39", "#fde725"],
  rainbow: ["#10106a", "#1f5fd0", "#17b7c8", "#33c45a", "#c9d22b", "#f08a1d", "#c41c1c"],
};

export const names = Object.keys(STOPS);

export function lookup(name) {
  const stops = STOPS[name] ?? STOPS["white hot"];
  const channels = stops.map((hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16)));
  const colours = new Uint8Array(256 * 4);
  for (let n = 0; n < 256; n += 1) {
    const at = (n / 255) * (stops.length - 1), i = Math.min(Math.floor(at), stops.length - 2);
    for (let c = 0; c < 3; c += 1) colours[4 * n + c] = Math.round(channels[i][c] + (channels[i + 1][c] - channels[i][c]) * (at - i));
    colours[4 * n + 3] = 255;
  }
  return colours;
}
