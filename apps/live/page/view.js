// SPDX-License-Identifier: Apache-2.0
// Two pictures on both sides of a divider, in the same place and scale: positions are um in the focal plane, from the
// corner that scene and detector share. Contrast and palette are applied in drawing, so that they need no request.

import { lookup } from "./palettes.js";

const SLOW_MS = 24; // for a picture on its way to the screen: more than a frame of the screen and a half

const VERTEX = `#version 300 es
void main() { vec2 p = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2); gl_Position = vec4(p * 2.0 - 1.0, 0.0, 1.0); }`;

// One side of the divider: each is drawn by itself into its own rectangle, with nothing to decide for a pixel.
const FRAGMENT = `#version 300 es
precision highp float; precision highp int; precision highp usampler2D;
uniform usampler2D picture; uniform sampler2D palette;
uniform vec2 corner, per_pixel, map; uniform float height;
out vec4 colour;
void main() {
  ivec2 at = ivec2(corner + vec2(gl_FragCoord.x, height - gl_FragCoord.y) * per_pixel);
  float t = clamp(float(texelFetch(picture, at, 0).r) * map.x + map.y, 0.0, 1.0);
  colour = texelFetch(palette, ivec2(int(t * 255.0 + 0.5), 0), 0);
}`;

function shader(gl, type, text) {
  const made = gl.createShader(type);
  gl.shaderSource(made, text);
  gl.compileShader(made);
  return made;
}

class Gpu {
  constructor(gl) {
    this.gl = gl;
    const program = gl.createProgram();
    gl.attachShader(program, shader(gl, gl.VERTEX_SHADER, VERTEX));
    gl.attachShader(program, shader(gl, gl.FRAGMENT_SHADER, FRAGMENT));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error("no shader");
    gl.useProgram(program);
    this.at = (name) => gl.getUniformLocation(program, name);
    this.places = Object.fromEntries(["picture", "corner", "per_pixel", "map", "height"].map((name) => [name, this.at(name)]));
    this.sizes = [];
    this.textures = [0, 1, 2].map((unit) => {
      const texture = gl.createTexture();
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
      for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
      return texture;
    });
    gl.enable(gl.SCISSOR_TEST);
    gl.uniform1i(this.at("palette"), 2);
  }
  picture(unit, { width, height, pixels }) {
    const gl = this.gl;
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 2);
    if (this.sizes[unit] !== width + "x" + height)
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.R16UI, width, height, 0, gl.RED_INTEGER, gl.UNSIGNED_SHORT, pixels);
    else
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RED_INTEGER, gl.UNSIGNED_SHORT, pixels);
    this.sizes[unit] = width + "x" + height;
  }
  palette(colours) {
    const gl = this.gl;
    gl.activeTexture(gl.TEXTURE2);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, colours);
  }
  draw(scene) {
    const gl = this.gl, p = this.places;
    const fill = (x0, y0, x1, y1, colour) => { // rectangle from the top
      gl.scissor(x0, scene.height - y1, Math.max(0, x1 - x0), Math.max(0, y1 - y0));
      if (!colour) return;
      gl.clearColor(...colour, 1);
      gl.clear(gl.COLOR_BUFFER_BIT);
    };
    gl.viewport(0, 0, scene.width, scene.height);
    fill(0, 0, scene.width, scene.height, scene.outside);
    gl.uniform1f(p.height, scene.height);
    scene.sides.forEach((side, i) => {
      const [x0, y0, x1, y1] = scene.rectangle(i);
      if (!(x1 > x0 && y1 > y0)) return;
      gl.uniform1i(p.picture, i);
      gl.uniform2f(p.corner, scene.corner[0] / side.step[0], scene.corner[1] / side.step[1]);
      gl.uniform2f(p.per_pixel, scene.scale / side.step[0], scene.scale / side.step[1]);
      gl.uniform2f(p.map, ...side.map);
      fill(x0, y0, x1, y1);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    });
    const line = Math.round(scene.divider);
    fill(line - 1, 0, line + 1, scene.height, scene.line);
  }
}

function isSoftware(gl) {
  const names = gl.getExtension("WEBGL_debug_renderer_info");
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(gl.getParameter(names?.UNMASKED_RENDERER_WEBGL ?? gl.RENDERER));
}

// What Gpu does, without a graphics card.
class Plain {
  constructor(canvas) {
    this.context = canvas.getContext("2d", { willReadFrequently: true });
    this.pictures = [];
    this.tables = [0, 1].map(() => new Uint32Array(65536)); // of each side: colour of each 16-bit number
  }
  picture(unit, picture) { this.pictures[unit] = picture; }
  palette(colours) { this.colours = new Uint32Array(colours.buffer.slice(0)); }
  /** Fills the table of a side; gain, not below 0, and offset. */
  tableOf(side, [gain, offset]) {
    const table = this.tables[side];
    for (let i = 0, from = 0; i < 256; i += 1) {
      const next = (i + 0.5) / 255 - offset, to = i === 255 ? 65536 : gain > 0 ? Math.max(from, Math.min(65536, Math.ceil(next / gain))) : next > 0 ? 65536 : from;
      table.fill(this.colours[i], from, to);
      from = to;
    }
    return table;
  }
  draw(scene) {
    const { width, height, corner, scale } = scene;
    if (this.image?.width !== width || this.image.height !== height) this.image = this.context.createImageData(width, height);
    const out = new Uint32Array(this.image.data.buffer);
    const solid = (rgb) => (255 << 24) | (Math.round(rgb[2] * 255) << 16) | (Math.round(rgb[1] * 255) << 8) | Math.round(rgb[0] * 255);
    out.fill(solid(scene.outside));
    scene.sides.forEach(({ step, map }, i) => {
      const picture = this.pictures[i], [x0, y0, x1, y1] = scene.rectangle(i);
      if (!picture || !(x1 > x0 && y1 > y0)) return;
      const { pixels } = picture, colour = this.tableOf(i, map);
      const place = (k, at, count) => Math.max(0, Math.min(count - 1, Math.floor((corner[k] + (at + 0.5) * scale) / step[k])));
      const columns = Int32Array.from({ length: x1 - x0 }, (_, k) => place(0, x0 + k, picture.width));
      for (let y = y0, last = -1; y < y1; y += 1) {
        const row = place(1, y, picture.height), to = y * width + x0;
        if (row === last) out.copyWithin(to, to - width, to - width + x1 - x0);
        else for (let k = 0, from = row * picture.width; k < columns.length; k += 1) out[to + k] = colour[pixels[from + columns[k]]];
        last = row;
      }
    });
    const line = Math.round(scene.divider);
    for (let y = 0; y < height; y += 1) out.fill(solid(scene.line), Math.max(y * width, y * width + line - 1), Math.min((y + 1) * width, y * width + line + 1));
    this.context.putImageData(this.image, 0, 0);
  }
}

const css = (name) => {
  const hex = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  return [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
};

export class View {
  constructor(canvas, changed) {
    this.canvas = canvas;
    this.changed = changed; // hears when zoom or place have changed
    this.engine = new Plain(canvas);
    this.kind = "canvas";
    this.sides = [null, null];
    this.divider = 0.5;
    this.contrast = 0;
    this.brightness = 0;
    this.range = "auto";
    this.held = [null, null];
    this.zoom = null; // um per pixel of the page; null: the whole picture
    this.ratio = 1; // pixels of the canvas to one of the page
    this.moving = false; // pictures follow each other: a page that draws slowly draws more coarsely
    this.lags = 0; // pictures that took long to the screen, less those that did not
    this.coarse = false;
    this.middle = [0, 0];
    this.waiting = false;
    this.drawn = 0;
    this.setPalette("white hot");
    this.sized = new ResizeObserver(() => this.draw());
    this.sized.observe(canvas);
  }
  /**
   * Goes over to WebGL where a graphics card draws it, with another canvas in the place of this one. Software GL is no
   * quicker than the canvas, and begins much later.
   */
  useGraphicsCard() {
    const asked = new URLSearchParams(location.search);
    if (asked.has("plain")) return;
    const canvas = this.canvas.cloneNode(), gl = canvas.getContext("webgl2", { antialias: false, alpha: false, depth: false, stencil: false });
    if (!gl) return;
    if (!asked.has("webgl") && isSoftware(gl)) {
      gl.getExtension("WEBGL_lose_context")?.loseContext();
      return;
    }
    const { pictures } = this.engine, focused = document.activeElement === this.canvas;
    try {
      this.engine = new Gpu(gl);
    } catch {
      return; // the canvas serves
    }
    this.kind = "webgl2";
    this.engine.palette(this.colours);
    pictures.forEach((picture, unit) => this.engine.picture(unit, picture));
    this.sized.unobserve(this.canvas);
    this.canvas.replaceWith(canvas);
    this.canvas = canvas;
    this.sized.observe(canvas);
    if (focused) canvas.focus();
    this.draw();
  }
  setPalette(name) {
    this.colours = lookup(name);
    this.engine.palette(this.colours);
    this.draw();
  }
  /** `step`: um of one pixel that was sent. */
  setPicture(side, picture, step) {
    this.engine.picture(side, picture);
    this.sides[side] = { ...picture, pixels: null, step };
    this.draw();
  }
  size() {
    const side = this.sides[0] ?? this.sides[1];
    return side ? [side.width * side.step[0], side.height * side.step[1]] : [1, 1];
  }
  fitScale() {
    const [w, h] = this.size();
    return Math.max(w / this.canvas.width, h / this.canvas.height) || 1;
  }
  /** um per pixel of the canvas. */
  scale() { return this.zoom === null ? this.fitScale() : this.zoom / this.ratio; }
  corner() {
    const scale = this.scale(), [w, h] = this.size();
    const middle = this.zoom === null ? [w / 2, h / 2] : this.middle;
    return [middle[0] - (this.canvas.width * scale) / 2, middle[1] - (this.canvas.height * scale) / 2];
  }
  /** Where a point of the page is in the focal plane, um. */
  place(event) {
    const box = this.canvas.getBoundingClientRect(), ratio = this.canvas.width / box.width, [x, y] = this.corner();
    return [x + (event.clientX - box.left) * ratio * this.scale(), y + (event.clientY - box.top) * ratio * this.scale()];
  }
  /** Where a place in the focal plane is in the box of the canvas, in pixels of the page. */
  onPage([x, y]) {
    const per = this.canvas.getBoundingClientRect().width / this.canvas.width / this.scale(), [left, top] = this.corner();
    return [(x - left) * per, (y - top) * per];
  }
  fit() {
    this.zoom = null;
    this.draw();
    this.changed();
  }
  zoomBy(factor, at) {
    const old = this.scale(), [w, h] = this.size(), least = Math.min(...(this.sides[0] ?? this.sides[1])?.step ?? [1]) / 64;
    const middle = this.zoom === null ? [w / 2, h / 2] : this.middle, held = at ?? middle;
    const scale = Math.min(Math.max(old * factor, least), this.fitScale() * 2);
    this.middle = [0, 1].map((i) => held[i] + ((middle[i] - held[i]) * scale) / old);
    this.zoom = scale * this.ratio;
    this.draw();
    this.changed();
  }
  moveBy(x, y) {
    const [w, h] = this.size(), scale = this.scale();
    if (this.zoom === null) this.middle = [w / 2, h / 2];
    this.zoom = scale * this.ratio;
    this.middle = [Math.min(Math.max(this.middle[0] + x * scale, 0), w), Math.min(Math.max(this.middle[1] + y * scale, 0), h)];
    this.draw();
    this.changed();
  }
  ends(i) {
    const side = this.sides[i];
    if (this.range === "held" && this.held[i]?.unit === side.unit) return this.held[i].ends;
    const ends = this.range === "full" ? [side.low, side.high] : [side.dark, side.bright];
    this.held[i] = { unit: side.unit, ends };
    return ends;
  }
  /** Of how many pixels of a row of a picture one is drawn, at most 8: more need not be sent. */
  drawsEvery(i) {
    const side = this.sides[i];
    return side ? Math.min(8, Math.max(1, Math.floor((this.scale() * side.every) / Math.min(...side.step)))) : 1;
  }
  /** From a 16-bit number to the place in the palette. */
  map(i) {
    const side = this.sides[i];
    if (!side) return [0, 0];
    let [black, white] = this.ends(i);
    if (!(white > black)) [black, white] = [black - 0.5, black + 0.5];
    const gain = 2 ** (this.contrast / 25) / (white - black), middle = (black + white) / 2;
    return [((side.high - side.low) / 65535) * gain, (side.low - middle) * gain + 0.5 + this.brightness / 100];
  }
  /** What the two ends of the palette are on a side. */
  shownEnds(i) {
    const side = this.sides[i];
    if (!side) return null;
    const [gain, offset] = this.map(i), value = (t) => side.low + (((t - offset) / gain) * (side.high - side.low)) / 65535;
    return gain > 0 ? [value(0), value(1)] : null;
  }
  draw() {
    if (this.waiting || !this.sides.some(Boolean)) return;
    this.waiting = true;
    const theme = document.documentElement.dataset.theme + matchMedia("(prefers-color-scheme: dark)").matches;
    if (theme !== this.theme) Object.assign(this, { theme, outside: css("--well"), line: css("--line") });
    requestAnimationFrame(() => {
      this.waiting = false;
      this.ratio = Math.min(devicePixelRatio, 2) * (this.moving && this.coarse ? 0.5 : 1);
      const box = this.canvas.getBoundingClientRect();
      const width = Math.max(1, Math.round(box.width * this.ratio)), height = Math.max(1, Math.round(box.height * this.ratio));
      if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
      const corner = this.corner(), scale = this.scale(), divider = this.divider * width;
      this.engine.draw({
        width, height, corner, scale, divider, outside: this.outside, line: this.line,
        sides: [0, 1].map((i) => ({ step: this.sides[i]?.step ?? [1, 1], map: this.map(i) })),
        /** Where the picture of a side is on the canvas. */
        rectangle: (i) => {
          const side = this.sides[i];
          if (!side) return [0, 0, 0, 0];
          const from = [0, 1].map((k) => Math.ceil(-corner[k] / scale - 0.5));
          const to = [0, 1].map((k) => Math.floor((side.step[k] * [side.width, side.height][k] - corner[k]) / scale + 0.5));
          const middle = Math.round(divider);
          return [Math.max(from[0], i === 0 ? 0 : middle), Math.max(from[1], 0), Math.min(to[0], i === 0 ? middle : width), Math.min(to[1], height)];
        },
      });
      this.drawn += 1;
      this.changedScale?.();
      this.copying?.(this.canvas);
      this.copying = null;
    });
  }
  /** A copy of what is drawn, with room below it: WebGL holds no picture beyond the frame that draws it. */
  copy(below) {
    return new Promise((resolve) => {
      this.copying = (from) => {
        const canvas = Object.assign(document.createElement("canvas"), { width: from.width, height: from.height + below });
        canvas.getContext("2d").drawImage(from, 0, 0);
        resolve(canvas);
      };
      this.draw();
    });
  }
  /** `ms`: of a picture that moves on, from being asked for to the screen, without the time of computing it. */
  lagged(ms) {
    this.lags = Math.min(6, Math.max(0, this.lags + (ms > SLOW_MS ? 1 : ms < SLOW_MS / 2 ? -1 : 0)));
    this.coarse ||= this.lags >= 3;
  }
  /** Nothing moves any more: what was drawn coarsely is drawn as it is. */
  rest() {
    if (!this.moving) return;
    this.moving = false;
    this.coarse = this.lags >= 3; // next time from the start
    this.draw();
  }
}
