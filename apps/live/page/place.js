// SPDX-License-Identifier: Apache-2.0
// The camera and the clock of a 3-D scene: angles and range about the point that it looks at, rows of sliders, and what
// the mouse does. Axes as in scene files: x east, y north, z up, m; azimuth of the camera from north, clockwise.

import { $, app } from "./app.js";
import { element, onLetGo, shortNumber, stepOf } from "./controls.js";

const REST_MS = 250; // after the last turn of a wheel or press of a key the camera is at rest
const CALM_MS = 150;
const STEEPEST = 89; // deg
const rad = Math.PI / 180;
const isoOf = (s) => new Date(s * 1000).toISOString().replace("T", " ").replace(/(:00)?\.\d+Z$/, "Z");
const metres = (text) => {
  const found = /^\s*([-+.\deE]+)\s*(m|km)?\s*$/.exec(text);
  return found ? Number(found[1]) * (found[2] === "km" ? 1000 : 1) : NaN;
};
const number = (text) => (/^\s*[-+.\deE]+\s*(deg|°)?\s*$/.test(text) ? parseFloat(text) : NaN);

export class Place {
  /** `space`: of the answer of `start`; `changed`: called while it moves, `settled` at rest, with where it was before. */
  constructor(box, space, changed, settled) {
    Object.assign(this, { box, space, changed, settled, held: false, timer: null, told: 0, rows: new Map() });
    this.home();
    this.build();
    this.rested = this.request();
  }

  home() {
    this.look_at = [...this.space.look_at];
    this.utc_s = this.space.utc_s;
    this.setPosition(this.space.position);
  }
  /** Back to the start; false where it is there already. */
  toStart() {
    const now = JSON.stringify(this.request());
    this.home();
    this.rested = this.request();
    this.update();
    return JSON.stringify(this.rested) !== now;
  }
  get moving() { return this.held || this.timer !== null; }
  get position() {
    const flat = this.range * Math.cos(this.elevation * rad);
    return [this.look_at[0] + flat * Math.sin(this.azimuth * rad), this.look_at[1] + flat * Math.cos(this.azimuth * rad), this.look_at[2] + this.range * Math.sin(this.elevation * rad)];
  }
  setPosition(position) {
    const [x, y, z] = position.map((value, i) => value - this.look_at[i]);
    this.range = Math.hypot(x, y, z);
    this.elevation = Math.atan2(z, Math.hypot(x, y)) / rad;
    if (Math.hypot(x, y) > 0) this.azimuth = (Math.atan2(x, y) / rad + 360) % 360;
    this.azimuth ??= 180;
  }
  /** Fields of a request, to the millimetre: what a command line can say. */
  request() {
    const round = (point) => point.map((value) => Math.round(value * 1000) / 1000);
    return { position: round(this.position), look_at: round(this.look_at), utc_s: this.utc_s };
  }
  restore(view) {
    const point = (list) => Array.isArray(list) && list.length === 3 && list.every(Number.isFinite);
    if (!view || !point(view.position) || !point(view.look_at)) return;
    this.look_at = view.look_at;
    this.setPosition(view.position);
    if (view.utc_s >= this.space.begin_s && view.utc_s <= this.space.end_s) this.utc_s = view.utc_s;
    clearTimeout(this.timer);
    Object.assign(this, { timer: null, held: false, told: 0, rested: this.request() });
    this.update();
  }

  /** Something has moved: pictures follow at once, all else when it rests. */
  moved(name) {
    app.lastName = name;
    this.update();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.rest(), REST_MS);
    this.changed();
  }
  rest() {
    clearTimeout(this.timer);
    this.timer = null;
    this.told = 0;
    this.update();
    if (this.held) return;
    const before = this.rested;
    this.rested = this.request();
    this.settled(JSON.stringify(before) === JSON.stringify(this.rested) ? null : before);
  }
  hold(held) {
    if (held === this.held) return;
    this.held = held;
    if (!held) this.rest();
  }

  orbitBy(azimuth, elevation) {
    this.azimuth = (((this.azimuth + azimuth) % 360) + 360) % 360;
    this.elevation = Math.min(Math.max(this.elevation + elevation, -STEEPEST), STEEPEST);
    this.moved(Math.abs(elevation) > Math.abs(azimuth) ? "camera.elevation" : "camera.azimuth");
  }
  nearBy(factor) {
    this.range = Math.min(Math.max(this.range * factor, 0.1), 1e5);
    this.moved("camera.range");
  }
  /** Camera and point go sideways and upwards, by um in the focal plane. */
  panBy(right_um, up_um) {
    const scale = this.range / (1000 * (app.frames[1]?.focal_length_mm ?? 100));
    this.fly(right_um * scale, 0, up_um * scale);
  }
  /** The same by m to the right, ahead over the ground, and up. */
  fly(right, ahead, up) {
    const sin = Math.sin(this.azimuth * rad), cos = Math.cos(this.azimuth * rad);
    this.look_at = [this.look_at[0] - right * cos - ahead * sin, this.look_at[1] + right * sin - ahead * cos, this.look_at[2] + up];
    this.moved("camera.look_at");
  }
  keys(shift) {
    const step = this.range / 25;
    const arrows = shift
      ? { ArrowLeft: () => this.orbitBy(3, 0), ArrowRight: () => this.orbitBy(-3, 0), ArrowUp: () => this.orbitBy(0, 2), ArrowDown: () => this.orbitBy(0, -2) }
      : { ArrowLeft: () => this.fly(-step, 0, 0), ArrowRight: () => this.fly(step, 0, 0), ArrowUp: () => this.fly(0, step, 0), ArrowDown: () => this.fly(0, -step, 0) };
    return {
      ...arrows, PageUp: () => this.fly(0, 0, step), PageDown: () => this.fly(0, 0, -step), "+": () => this.nearBy(1 / 1.1), "=": () => this.nearBy(1 / 1.1), "-": () => this.nearBy(1.1),
      0: () => { this.home(); this.moved("camera.range"); },
    };
  }

  build() {
    const { begin_s, end_s, size_m } = this.space, far = Math.max(20 * size_m, 4 * this.range);
    const log = { of: (t) => far * 1e-4 ** (1 - t / 1000), at: (v) => 1000 * (1 + Math.log(v / far) / Math.log(1e4)) };
    const line = (low, high) => ({ of: (t) => low + ((high - low) * t) / 1000, at: (v) => (1000 * (v - low)) / (high - low) });
    const point = (list) => list.map((value) => shortNumber(Math.round(value * 1000) / 1000)).join(", ");
    const setPoint = (text, take) => {
      const list = text.split(/[,;]\s*/).map(metres);
      if (list.length !== 3 || !list.every(Number.isFinite)) return "three numbers in m belong here, as 40, -45, 12";
      take(list);
      return "";
    };
    const whole = (s) => Math.min(Math.max(Math.round(s / 60) * 60, begin_s), end_s);
    this.box.replaceChildren(
      this.row("camera.time", "time", "UTC; temperatures, sun, sky and weather are those of this time", begin_s < end_s ? line(begin_s, end_s) : null, () => this.utc_s,
        (s) => { this.utc_s = whole(s); }, () => isoOf(this.utc_s), (text) => {
          const plain = text.trim().replace(" ", "T"), s = Date.parse(/(Z|[+-]\d\d:?\d\d)$/.test(plain) ? plain : `${plain}Z`) / 1000;
          if (!(s >= begin_s && s <= end_s)) return `a time from ${isoOf(begin_s)} to ${isoOf(end_s)} belongs here`;
          this.utc_s = Math.round(s);
          return "";
        }),
      this.row("camera.range", "range", "from the camera to the point that it looks at", log, () => this.range, (value) => { this.range = value; }, () => `${shortNumber(this.range)} m`, (text) => {
        const value = metres(text);
        if (!(value > 0)) return "a length above 0 belongs here, in m or km";
        this.range = value;
        return "";
      }),
      this.row("camera.azimuth", "azimuth", "of the camera seen from the point that it looks at; from north, clockwise", line(0, 360), () => this.azimuth, (value) => { this.azimuth = value; },
        () => `${shortNumber(this.azimuth)} deg`, (text) => this.angle(text, "azimuth", -360, 360)),
      this.row("camera.elevation", "elevation", "of the camera above the point that it looks at", line(-10, STEEPEST), () => this.elevation, (value) => { this.elevation = value; },
        () => `${shortNumber(this.elevation)} deg`, (text) => this.angle(text, "elevation", -STEEPEST, STEEPEST)),
      this.row("camera.position", "position", "of the camera: x east, y north, z up, m", null, null, null, () => point(this.position), (text) => setPoint(text, (list) => this.setPosition(list))),
      this.row("camera.look_at", "look at", "the point that the camera looks at, m", null, null, null, () => point(this.look_at), (text) => setPoint(text, (list) => {
        const { position } = this;
        this.look_at = list;
        this.setPosition(position);
      })));
    this.update();
  }
  angle(text, key, low, high) {
    const value = number(text);
    if (!(value >= low && value <= high)) return `an angle from ${low} to ${high} deg belongs here`;
    this[key] = key === "azimuth" ? (value + 360) % 360 : value;
    return "";
  }

  row(name, title, doc, scale, get, set, text, parse) {
    const id = `p-${name}`, message = element("p", { className: "message", id: `${id}-message`, hidden: true });
    const field = element("input", { id, type: "text", spellcheck: false, autocomplete: "off" });
    field.setAttribute("aria-describedby", message.id);
    field.onchange = () => {
      const wrong = parse(field.value);
      this.clear();
      if (wrong) return this.problem(name, wrong);
      this.moved(name);
      this.rest();
    };
    const slider = scale ? element("input", { type: "range", min: 0, max: 1000, step: "any" }) : null;
    if (slider) {
      slider.setAttribute("aria-label", `${name} slider`);
      slider.oninput = () => { set(scale.of(Number(slider.value))); this.held = true; this.moved(name); };
      onLetGo(slider, () => { this.held = false; this.rest(); });
      slider.onkeydown = (event) => {
        const step = stepOf(event);
        if (step === undefined) return;
        event.preventDefault();
        slider.value = Number(slider.value) + step;
        set(scale.of(Number(slider.value)));
        this.moved(name);
      };
    }
    const line = element("div", { className: "row" }, element("label", { htmlFor: id, title: doc }, title), ...(slider ? [slider] : []), field, message);
    line.dataset.name = name;
    line.classList.toggle("no-slider", !slider);
    const update = () => {
      if (document.activeElement !== field || field.value === field.dataset.shown) field.value = field.dataset.shown = text();
      if (slider && !slider.matches(":active")) slider.value = scale.at(get());
      slider?.setAttribute("aria-valuetext", text());
    };
    this.rows.set(name, { line, message, field, update });
    return line;
  }
  /** Fields follow a moving camera no more often than can be read: a page that is painted costs pictures. */
  update() {
    const now = performance.now();
    clearTimeout(this.later);
    if (this.moving && now - this.told < CALM_MS) {
      this.later = setTimeout(() => this.update(), CALM_MS);
      return;
    }
    this.told = now;
    for (const { update } of this.rows.values()) update();
  }

  problem(name, text) {
    const row = this.rows.get(name);
    if (!row) return false;
    this.clear();
    row.message.textContent = text;
    row.message.hidden = false;
    row.line.classList.add("wrong");
    row.field.setAttribute("aria-invalid", "true");
    return true;
  }
  clear() {
    for (const { line, message, field } of this.rows.values()) {
      message.hidden = true;
      line.classList.remove("wrong");
      field.removeAttribute("aria-invalid");
    }
  }
  /** What stands for air, sky and sun, in the program's words. */
  showClosures(closures) {
    if (!closures) return;
    const items = closures.map(([name, words]) => `${name}: ${words}`);
    if (items.join() === this.said) return;
    this.said = items.join();
    $("closures").replaceChildren(...items.map((text) => element("li", { textContent: text })));
  }
}
