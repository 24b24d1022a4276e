// SPDX-License-Identifier: Apache-2.0
// Two pictures on both sides of a divider, in the same place and scale: positions are um in the focal plane, from the
// corner that scene and detector share. Contrast and palette are the shader's, so that they need no request.

import { lookup } from "./palettes.js";

const VERTEX = `#version 300 es
void main() { vec2 p = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2); gl_Position = vec4(p * 2.0 - 1.0, 0.0, 1.0); }`;

const FRAGMENT = `#version 300 es
precision highp float; precision highp int; precision highp usampler2D;
uniform usampler2D left_picture, right_picture; uniform sampler2D palette;
uniform vec2 corner, left_step, right_step; uniform float um_per_pixel, height, divider;
uniform vec2 left_map, right_map; uniform vec3 outside, line;
out vec4 colour;
vec4 shown(usampler2D picture, vec2 step_um, vec2 map, vec2 um) {
  ivec2 at = ivec2(floor(um / step_um)), size = textureSize(picture, 0);
  if (um.x < 0.0 || um.y < 0.0 || at.x >= size.x || at.y >= size.y) return vec4(outside, 1.0);
  float t = clamp(float(texelFetch(picture, at, 0).r) * map.x + map.y, 0.0, 1.0);
  return vec4(texture(palette, vec2(t * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb, 1.0);
}
void main() {
  vec2 pixel = vec2(gl_FragCoord.x, height - gl_FragCoord.y);
  vec2 um = corner + pixel * um_per_pixel;
  bool left = pixel.x < divider;
  colour = left ? shown(left_picture, left_step, left_map, um) : shown(right_picture, right_step, right_map, um);
  if (abs(pixel.x - divider) < 1.0) colour = vec4(line, 1.0);
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
    this.places = {};
    for (const name of ["corner", "left_step", "right_step", "um_per_pixel", "height", "divider", "left_map", "right_map", "outside", "line"])
      this.places[name] = this.at(name);
    this.sizes = [];
    this.textures = [0, 1, 2].map((unit) => {
      const texture = gl.createTexture();
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
      for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
      return texture;
    });
    gl.uniform1i(this.at("left_picture"), 0);
    gl.uniform1i(this.at("right_picture"), 1);
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
    gl.viewport(0, 0, scene.width, scene.height);
    gl.uniform2f(p.corner, ...scene.corner);
    gl.uniform1f(p.um_per_pixel, scene.scale);
    gl.uniform1f(p.height, scene.height);
    gl.uniform1f(p.divider, scene.divider);
    gl.uniform3f(p.outside, ...scene.outside);
    gl.uniform3f(p.line, ...scene.line);
    scene.sides.forEach((side, i) => {
      gl.uniform2f(i === 0 ? p.left_step : p.right_step, ...side.step);
      gl.uniform2f(i === 0 ? p.left_map : p.right_map, ...side.map);
    });
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
}

// Without WebGL: the same, pixel by pixel.
class Plain {
  constructor(canvas) {
    this.context = canvas.getContext("2d");
    this.pictures = [];
  }
  picture(unit, picture) { this.pictures[unit] = picture; }
  palette(colours) { this.colours = new Uint32Array(colours.buffer.slice(0)); }
  draw(scene) {
    const image = this.context.createImageData(scene.width, scene.height);
    const out = new Uint32Array(image.data.buffer);
    const solid = (rgb) => (255 << 24) | (Math.round(rgb[2] * 255) << 16) | (Math.round(rgb[1] * 255) << 8) | Math.round(rgb[0] * 255);
    const outside = solid(scene.outside), line = solid(scene.line);
    for (let y = 0; y < scene.height; y += 1) {
      const um = scene.corner[1] + (y + 0.5) * scene.scale;
      for (let x = 0; x < scene.width; x += 1) {
        const unit = x + 0.5 < scene.divider ? 0 : 1, side = scene.sides[unit], picture = this.pictures[unit];
        const column = Math.floor((scene.corner[0] + (x + 0.5) * scene.scale) / side.step[0]), row = Math.floor(um / side.step[1]);
        let colour = outside;
        if (picture && column >= 0 && row >= 0 && column < picture.width && row < picture.height) {
          const t = picture.pixels[row * picture.width + column] * side.map[0] + side.map[1];
          colour = this.colours[Math.max(0, Math.min(255, Math.round(t * 255)))];
        }
        out[y * scene.width + x] = Math.abs(x + 0.5 - scene.divider) < 1 ? line : colour;
      }
    }
    this.context.putImageData(image, 0, 0);
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
    const gl = new URLSearchParams(location.search).has("plain") ? null
      : canvas.getContext("webgl2", { antialias: false, alpha: false, preserveDrawingBuffer: true });
    this.engine = gl ? new Gpu(gl) : new Plain(canvas);
    this.kind = gl ? "webgl2" : "canvas";
    this.sides = [null, null];
    this.divider = 0.5;
    this.contrast = 0;
    this.brightness = 0;
    this.range = "auto";
    this.held = [null, null];
    this.zoom = null; // um per device pixel; null: the whole picture
    this.middle = [0, 0];
    this.waiting = false;
    this.drawn = 0;
    this.setPalette("white hot");
    new ResizeObserver(() => this.draw()).observe(canvas);
  }
  setPalette(name) {
    this.engine.palette(lookup(name));
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
  scale() { return this.zoom ?? this.fitScale(); }
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
    this.zoom = scale;
    this.draw();
    this.changed();
  }
  moveBy(x, y) {
    const [w, h] = this.size(), scale = this.scale();
    if (this.zoom === null) this.middle = [w / 2, h / 2];
    this.zoom = scale;
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
  /** From a 16-bit number to the place in the palette. */
  map(i) {
    const side = this.sides[i];
    if (!side) return [0, 0];
    let [black, white] = this.ends(i);
    if (!(white > black)) [black, white] = [black - 0.5, black + 0.5];
    const gain = 2 ** (this.contrast / 25) / (white - black), middle = (black + white) / 2;
    return [((side.high - side.low) / 65535) * gain, (side.low - middle) * gain + 0.5 + this.brightness / 100];
  }
  draw() {
    if (this.waiting) return;
    this.waiting = true;
    const theme = document.documentElement.dataset.theme + matchMedia("(prefers-color-scheme: dark)").matches;
    if (theme !== this.theme) Object.assign(this, { theme, outside: css("--well"), line: css("--line") });
    requestAnimationFrame(() => {
      this.waiting = false;
      const ratio = Math.min(devicePixelRatio, 2), box = this.canvas.getBoundingClientRect();
      const width = Math.max(1, Math.round(box.width * ratio)), height = Math.max(1, Math.round(box.height * ratio));
      if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
      this.engine.draw({
        width, height, corner: this.corner(), scale: this.scale(), divider: this.divider * width, outside: this.outside, line: this.line,
        sides: [0, 1].map((i) => ({ step: this.sides[i]?.step ?? [1, 1], map: this.map(i) })),
      });
      this.drawn += 1;
    });
  }
}
