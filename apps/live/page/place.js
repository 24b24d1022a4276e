// SPDX-License-Identifier: Apache-2.0
// The camera and the clock of a 3-D scene: angles and range about the point that it looks at, rows of sliders, and what
// the mouse does. Axes as in scene files: x east, y north, z up, m; azimuth of the camera from north, clockwise.

import { $, app } from "./app.js";
import { element, onEscape, shortNumber, track } from "./controls.js";

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
    const points = (list) => list.map((value) => shortNumber(Math.round(value * 1000) / 1000)).join(", ");
    const point = (get, set) => ({
      get, set, text: points, wants: "three numbers in m belong here, as 40, -45, 12",
      read: (text) => { const list = text.split(/[,;]\s*/).map(metres); return list.length === 3 && list.every(Number.isFinite) ? list : null; },
    });
    const angle = (key, low, high) => ({
      get: () => this[key], set: (value) => { this[key] = low < -90 ? (value + 360) % 360 : value; }, text: (value) => `${shortNumber(value)} deg`,
      wants: `an angle from ${low} to ${high} deg belongs here`, read: (text) => { const value = number(text); return value >= low && value <= high ? value : null; },
    });
    const sun = element("p", { id: "sun", className: "note" });
    this.box.replaceChildren(
      this.row("camera.time", "time", "UTC; temperatures, sun, sky and weather are those of this time", begin_s < end_s ? { low: begin_s, high: end_s, grain: 60 } : null, {
        get: () => this.utc_s, set: (s) => { this.utc_s = Math.min(Math.max(Math.round(s), begin_s), end_s); }, text: isoOf, short: (s) => isoOf(s).slice(5, -1),
        wants: `a time from ${isoOf(begin_s)} to ${isoOf(end_s)} belongs here`,
        read: (text) => {
          const plain = text.trim().replace(/^(?=\d\d-\d\d )/, isoOf(begin_s).slice(0, 5)).replace(" ", "T"), s = Date.parse(/(Z|[+-]\d\d:?\d\d)$/.test(plain) ? plain : `${plain}Z`) / 1000;
          return s >= begin_s && s <= end_s ? s : null;
        },
      }),
      sun,
      this.row("camera.range", "range", "from the camera to the point that it looks at", { low: 1e-4 * far, high: far, log: true }, {
        get: () => this.range, set: (value) => { this.range = value; }, text: (value) => `${shortNumber(value)} m`,
        wants: "a length above 0 belongs here, in m or km", read: (text) => { const value = metres(text); return value > 0 ? value : null; },
      }),
      this.row("camera.azimuth", "azimuth", "of the camera seen from the point that it looks at; from north, clockwise", { low: 0, high: 360 }, angle("azimuth", -360, 360)),
      this.row("camera.elevation", "elevation", "of the camera above the point that it looks at", { low: -10, high: STEEPEST }, angle("elevation", -STEEPEST, STEEPEST)),
      this.row("camera.position", "position", "of the camera: x east, y north, z up, m", null, point(() => this.position, (list) => this.setPosition(list))),
      this.row("camera.look_at", "look at", "the point that the camera looks at, m", null, point(() => this.look_at, (list) => {
        const { position } = this;
        this.look_at = list;
        this.setPosition(position);
      })));
    this.update();
  }

  /** `of`: { get, set, text, read: null for what is none, wants: the words for that }. */
  row(name, title, doc, range, of) {
    const id = `p-${name}`, message = element("p", { className: "message", id: `${id}-message`, hidden: true });
    const field = element("input", { id, type: "text", spellcheck: false, autocomplete: "off" });
    field.setAttribute("aria-describedby", message.id);
    field.onchange = () => {
      const value = of.read(field.value);
      this.clear();
      if (value === null) return this.problem(name, of.wants);
      field.dataset.shown = field.value;
      of.set(value);
      this.moved(name);
      this.rest();
    };
    const own = { ...range };
    const slider = range ? track(name, {
      range: () => range,
      moved: (value, byKey) => { of.set(value); this.held ||= !byKey; this.moved(name); },
      letGo: () => { this.held = false; this.rest(); },
      text: of.short ?? of.text,
      setEnd: (end, text) => {
        const next = { ...range, [end]: text === "" ? own[end] : of.read(text) };
        if (next[end] === null) return of.wants;
        if (!(next.low <= of.get() && of.get() <= next.high && next.low < next.high)) return `the present value, ${of.text(of.get())}, lies beyond it`;
        Object.assign(range, next);
        return "";
      },
    }) : null;
    const line = element("div", { className: "row" }, element("label", { htmlFor: id, title: doc }, title), field, ...(slider ? [slider.line] : []), message);
    line.dataset.name = name;
    line.classList.toggle("no-slider", !slider);
    const update = () => {
      const value = of.get(), text = of.text(value);
      if (document.activeElement !== field || field.value === field.dataset.shown) field.value = field.dataset.shown = text;
      slider?.show(value, text);
    };
    onEscape(field, () => {
      field.dataset.shown = field.value;
      update();
      this.clear();
    });
    this.rows.set(name, { line, message, field, update });
    return line;
  }
  /**
   * Local time and sun of the time of the picture; nothing for another. The zone is that of the longitude: summer time and
   * borders are not known here.
   */
  showSun(sun, utc_s) {
    const zone = Math.round(this.space.longitude_deg / 15), clock = (h) => isoOf(60 * Math.floor((((h % 24) + 24) % 24) * 60 + 1e-6)).slice(11, 16);
    const up = Math.abs(sun.elevation_deg).toFixed(1), light = sun.elevation_deg > 0 ? "day" : sun.elevation_deg > -6 ? "twilight" : "night";
    $("sun").textContent = utc_s === this.utc_s ? `Local ${clock(utc_s / 3600 + zone)} (UTC${zone < 0 ? "−" : "+"}${Math.abs(zone)} by longitude), solar ${clock(sun.solar_time_h)}\nSun ${up}° ${sun.elevation_deg > 0 ? "above" : "below"} the horizon: ${light}` : "";
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
