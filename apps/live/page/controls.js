// SPDX-License-Identifier: Apache-2.0
// The forms of the sensor, and of the file of a 3-D scene: a section for each component and table, a row for each
// parameter. Everything about a row (unit, range, scale, words, documentation) comes from the field tables of the program.

const CALM_MS = 100;
const LISTS = { presample: "Before sampling", readout: "Readout", postsample: "After sampling" };

/**
 * Calls `letGo` once for each time that a slider has moved and is let go. A browser fires no `change` where the handle is
 * back in its place.
 */
function onLetGo(slider, letGo) {
  let moved = false;
  const end = () => {
    if (moved) letGo();
    moved = false;
  };
  slider.addEventListener("input", () => { moved = true; });
  for (const event of ["change", "pointerup", "pointercancel", "blur"]) slider.addEventListener(event, end);
}

/** Escape brings a text back; where one was being written it does nothing else. */
export function onEscape(field, restore) {
  field.onkeydown = (event) => {
    if (event.key !== "Escape") return;
    if (field.value !== field.dataset.shown) event.stopPropagation();
    restore();
  };
}

const KEYS = { ArrowLeft: -10, ArrowDown: -10, ArrowRight: 10, ArrowUp: 10, PageDown: -100, PageUp: 100 }; // of 1000 steps
const FINE = 0.1; // with Shift

export const element = (tag, properties = {}, ...children) => {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
};

export const shortNumber = (value) => String(Number(value.toPrecision(4)));

const position = (row, value) => row.log
  ? (1000 * Math.log(value / row.low)) / Math.log(row.high / row.low)
  : (1000 * (value - row.low)) / (row.high - row.low);
/** `grain`: values are multiples of it. */
const grainOf = (row) => (row.whole ? 1 : row.grain);
const valueAt = (row, t) => {
  const value = row.log ? row.low * (row.high / row.low) ** (t / 1000) : row.low + ((row.high - row.low) * t) / 1000;
  return grainOf(row) ? Math.round(value / grainOf(row)) * grainOf(row) : value;
};
/** As the sensor file has it, with the digits that half a step of the slider needs. */
const written = (row, value) => {
  const half = (row.log ? value * Math.log(row.high / row.low) : row.high - row.low) / 2000;
  const digits = Math.min(Math.max(4, Math.ceil(Math.log10(Math.abs(value / half)))), 12);
  const number = row.whole ? String(value) : String(Number(value.toPrecision(digits)));
  return row.unit ? `${number} ${row.unit}` : row.whole || /[.e]/.test(number) ? number : `${number}.0`;
};

/** Keys of lists by what they are. */
const titleOf = (key) => ({ "format[0]": "columns", "format[1]": "rows" })[key] ?? key.replace(/^(\w+)\[(\d)\]$/, (_, name, i) => `${i === "0" ? "1st" : "2nd"} ${name}`);
/** Long keys go on in the next line behind an underscore. */
const breakable = (text) => text.split(/(?<=_)/).flatMap((part, i) => (i > 0 ? [document.createElement("wbr"), part] : [part]));

/**
 * A slider of 1000 steps with the two ends of its range beside it, which a user may change. `range()`: { low, high, log,
 * whole or grain } of the moment; `moved(value, by a key)`; `text`: of an end; `setEnd(end, text)`: what is wrong with it.
 */
export function track(name, { range, moved, letGo, text, setEnd }) {
  const slider = element("input", { type: "range", min: 0, max: 1000, step: "any" });
  slider.setAttribute("aria-label", `${name} slider`);
  slider.oninput = () => moved(valueAt(range(), Number(slider.value)), false);
  onLetGo(slider, letGo);
  slider.onkeydown = (event) => {
    if (!(event.key in KEYS)) return;
    event.preventDefault();
    const step = KEYS[event.key] * (event.shiftKey ? FINE : 1), { low, high } = range();
    // A grain at least: less would change nothing.
    slider.value = Number(slider.value) + Math.sign(step) * Math.max(Math.abs(step), (1000 * (grainOf(range()) ?? 0)) / (high - low));
    moved(valueAt(range(), Number(slider.value)), true);
  };
  const ends = ["low", "high"].map((end) => {
    const field = element("input", { type: "text", className: "end", spellcheck: false, autocomplete: "off", title: "End of the slider; emptied: as it was" });
    field.setAttribute("aria-label", `${name}, ${end === "low" ? "lower" : "upper"} end of the slider`);
    field.onchange = () => {
      field.setCustomValidity(setEnd(end, field.value.trim()));
      if (field.reportValidity()) show();
    };
    field.oninput = () => field.setCustomValidity("");
    field.onblur = () => { field.setCustomValidity(""); show(); };
    onEscape(field, () => show());
    return field;
  });
  const show = () => ends.forEach((field, i) => {
    field.value = field.dataset.shown = text([range().low, range().high][i]);
    field.size = Math.max(1, field.value.length);
  });
  return {
    slider,
    line: element("div", { className: "track" }, ends[0], slider, ends[1]),
    show(value, words) {
      if (!slider.matches(":active")) slider.value = position(range(), value);
      slider.setAttribute("aria-valuetext", words);
      if (!ends.includes(document.activeElement)) show();
    },
  };
}

/** A slider keeps its ends, which only a typed value beyond them moves: what a place of the handle means stays. */
function withEndsOf(now, next) {
  const same = now.unit === next.unit && now.log === next.log && now.min === next.min && now.max === next.max;
  const at = position(now, next.number);  // a value at an end is written with four digits
  return same && at > -1 && at < 1001 ? { ...next, low: now.low, high: now.high } : next;
}

/** The row with another end of its slider, or what is wrong with it. */
function withEnd(row, end, text) {
  const given = text.endsWith(row.unit) ? text.slice(0, text.length - row.unit.length) : text, value = Number(given);
  if (given.trim() === "" || !Number.isFinite(value)) return `a number${row.unit ? ` in ${row.unit}` : ""} belongs here`;
  if (value < (row.min ?? -Infinity) || value > (row.max ?? Infinity)) return `${row.name} goes from ${row.min ?? "any"} to ${row.max ?? "any"} ${row.unit}`;
  if (row.log && !(value > 0)) return "an end above 0 belongs here: the slider is logarithmic";
  const next = { ...row, [end]: value };
  return next.low <= row.number && row.number <= next.high && next.low < next.high ? next : `the value, ${`${shortNumber(row.number)} ${row.unit}`.trim()}, lies beyond it`;
}

export class Controls {
  /**
   * `act`: what the forms call: drag, drop, set, unset, add, reset, stay (nothing has changed, and words about it go).
   * `open`: names of the tables that are open at first.
   */
  constructor(place, act, open) {
    Object.assign(this, { place, act, first: new Set(open) });
    this.rows = new Map(); // name -> { row, update }
    this.open = new Map(); // sections that the user has opened or closed
    this.shape = "";
    this.added = null; // what has been added: it opens, and comes into view
    this.begin = new Map(); // texts at the start
    this.ends = new Map(); // name -> a row with the ends that its slider has, also when the form is made anew
  }

  /** The texts that `reset` goes back to. */
  remember(model) {
    for (const owner of [...(model.components ?? []), ...model.tables])
      for (const row of owner.rows) this.begin.set(row.name, row.given ? row.text : null);
  }

  show(model) {
    const owners = [...(model.components ?? []), ...model.tables];
    const shape = JSON.stringify([owners.map((owner) => [owner.label ?? owner.name, owner.rows.map((row) => [row.name, row.control, row.given])]), model.off]);
    if (shape === this.shape) {
      for (const owner of owners) for (const row of owner.rows) this.rows.get(row.name)?.update(row);
      return;
    }
    const old = new Set(this.owners);
    this.owners = owners.map((owner) => owner.label ?? owner.name);
    if (this.shape !== "") this.added = this.owners.find((name) => !old.has(name)) ?? null;
    this.shape = shape;
    const focus = document.activeElement?.dataset?.focus;
    this.rows.clear();
    this.place.replaceChildren(...(model.components
      ? [...Object.keys(LISTS).map((list) => this.list(list, model)), ...this.tables(model)]
      : model.tables.map((table) => this.section(table, table.name, ""))));
    if (focus) this.place.querySelector(`[data-focus="${CSS.escape(focus)}"]`)?.focus();
    this.filter(this.wanted ?? "");
    if (this.added) this.place.querySelector(".added")?.scrollIntoView({ block: "nearest" });
  }

  list(list, model) {
    const owners = model.components.filter((component) => component.list === list);
    const off = model.off.filter((entry) => entry.table === list);
    return element("div", { className: "group" },
      element("h2", {}, LISTS[list], this.adder(list, model)),
      ...owners.map((owner) => this.section(owner, owner.label, owner.kind === owner.label ? "" : owner.kind)),
      ...off.map((entry) => this.offRow(entry)));
  }

  tables(model) {
    const off = model.off.filter((entry) => !(entry.table in LISTS));
    return [element("div", { className: "group" },
      element("h2", {}, "Sensor and chain", this.adder("table", model)),
      ...model.tables.map((table) => this.section(table, `[${table.name}]`, "")),
      ...off.map((entry) => this.offRow(entry)))];
  }

  adder(list, model) {
    const choice = element("select", { className: "add", ariaLabel: `Add to ${LISTS[list] ?? "the chain"}` }, element("option", { value: "" }, "Add …"));
    choice.setAttribute("aria-label", choice.ariaLabel);
    for (const [name, doc] of model.addable[list]) choice.append(element("option", { value: name, title: doc }, name));
    choice.onchange = () => {
      const kind = choice.value;
      choice.value = ""; // so that one that was refused can be chosen again
      if (kind) this.act.add(["add", list, kind]);
    };
    return choice;
  }

  offRow(entry) {
    const box = element("input", { type: "checkbox", checked: false });
    box.setAttribute("aria-label", `${entry.title} on`);
    box.onchange = () => this.act.add(["on", entry.number]);
    return element("div", { className: "section is-off" }, element("div", { className: "head" }, box, element("span", {}, entry.title), element("em", {}, "off")));
  }

  section(owner, title, kind) {
    const key = title, given = owner.rows.filter((row) => row.given), more = owner.rows.filter((row) => !row.given);
    const fixed = owner.fixed === true, label = owner.label ?? `[${owner.name}]`;
    const details = element("details", { className: "section", open: this.open.get(key) ?? (owner.list !== undefined || this.first.has(owner.name)) });
    if ((owner.label ?? owner.name) === this.added) [details.open, details.className] = [true, "section added"];
    details.ontoggle = () => this.open.set(key, details.open);
    const head = element("summary", { className: "head", title: owner.doc }, element("span", {}, title), element("em", {}, kind));
    if (!fixed) {
      const box = element("input", { type: "checkbox", checked: true });
      box.setAttribute("aria-label", `${title} on`);
      box.dataset.focus = `on ${label}`;
      box.onclick = (event) => event.stopPropagation();
      box.onchange = () => this.act.add(["off", label]);
      const gone = element("button", { type: "button", className: "small quiet", title: `Remove ${title}` }, "×");
      gone.setAttribute("aria-label", `Remove ${title}`);
      gone.onclick = (event) => { event.preventDefault(); this.act.add(["remove", label]); };
      head.prepend(box);
      head.append(gone);
    }
    details.append(head, ...given.map((row) => this.row(row)));
    if (more.length > 0) {
      const rest = element("details", { className: "more", open: this.open.get(`${key} more`) ?? false }, element("summary", {}, `${more.length} more`), ...more.map((row) => this.row(row)));
      rest.ontoggle = () => this.open.set(`${key} more`, rest.open);
      details.append(rest);
    }
    return details;
  }

  row(row) {
    const id = `p-${row.name}`, message = element("p", { className: "message", id: `${id}-message`, hidden: true });
    const line = element("div", { className: "row" });
    line.dataset.name = row.name;
    const label = element("label", { htmlFor: id, title: `${row.doc}${row.example ? `, such as ${row.example}` : ""}` }, ...breakable(titleOf(row.key)));
    const back = element("button", { type: "button", className: "small quiet back", title: "Reset to the value at the start", hidden: true }, "↺");
    back.setAttribute("aria-label", `Reset ${row.key}`);
    back.onclick = () => this.act.reset(row.name, this.begin.get(row.name) ?? null);
    let field, slider = null, own = row, now = row, told = 0, later = null;
    const say = (text) => {
      clearTimeout(later);
      [field.value, field.dataset.shown, told] = [text, text, performance.now()];
    };
    const restore = () => {
      say(now.given ? now.text : "");
      this.act.stay();
    };
    if (row.control === "word" || row.control === "flag") {
      field = element("select", { id });
      for (const word of row.words ?? ["true", "false"]) field.append(element("option", {}, word));
      if (!row.given) field.prepend(element("option", { value: "" }, row.text || "not given"));
      field.onchange = () => field.value && this.act.set(row.name, field.value);
    } else {
      field = element("input", { id, type: "text", spellcheck: false, autocomplete: "off", disabled: row.control === "file" });
      field.placeholder = row.text || (row.presence === "shared" ? "as in [optics]" : `e.g. ${row.example}`);
      field.onchange = () => {
        const text = field.value.trim();
        field.dataset.shown = field.value;
        if (text !== "") this.act.set(row.name, text);
        else if (now.given && now.presence !== "required") this.begin.get(row.name) ? this.act.unset(row.name) : this.act.reset(row.name, null);
        else restore();
      };
      onEscape(field, restore);
      field.onblur = () => this.wrong !== row.name && say(now.given ? now.text : "");
    }
    field.setAttribute("aria-label", row.name);
    field.dataset.focus = id;
    field.setAttribute("aria-describedby", message.id);
    if (row.control === "number") slider = track(row.name, {
      range: () => now,
      moved: (value, byKey) => {
        const text = written(now, value);
        // The text follows no more often than can be read: a page that is painted costs pictures.
        clearTimeout(later);
        if (performance.now() - told > CALM_MS) say(text);
        else later = setTimeout(() => say(text), CALM_MS);
        slider.slider.setAttribute("aria-valuetext", text);
        this.act.drag(row.name, text);
        if (byKey) letGo();
      },
      letGo: () => letGo(),
      text: (value) => written(now, value),
      setEnd: (end, text) => {
        const ends = text === "" ? own : withEnd(now, end, text);
        if (typeof ends === "string") return ends;
        this.ends.set(row.name, { ...now, low: ends.low, high: ends.high });
        update(own);
        return "";
      },
    });
    const letGo = () => {
      say(written(now, valueAt(now, Number(slider.slider.value))));
      this.act.drop();
    };
    const update = (next) => {
      own = next;
      now = slider && this.ends.has(row.name) ? withEndsOf(this.ends.get(row.name), next) : next;
      if (slider) this.ends.set(row.name, now);
      const typing = document.activeElement === field && field.tagName !== "SELECT" && field.value !== field.dataset.shown;
      if (!typing && this.wrong !== row.name) say(next.given ? next.text : "");
      slider?.show(next.number, next.text || "not given");
      slider?.slider.classList.toggle("unset", !next.text);
      const start = this.begin.get(row.name);
      back.hidden = start === undefined || (next.given ? next.text : null) === start;
    };
    update(row);
    this.rows.set(row.name, { row, update, line, message, field });
    line.append(label, field, back, ...(slider ? [slider.line] : []), message);
    line.classList.toggle("no-slider", !slider);
    return line;
  }

  /** The program's own words at the control that they are about. */
  problem(name, text) {
    const at = this.rows.get(name);
    if (!at) return false;
    const isNew = this.wrong !== name;
    this.clear();
    at.message.textContent = text;
    at.message.hidden = false;
    if (isNew) at.message.scrollIntoView({ block: "nearest" });
    at.line.classList.add("wrong");
    at.field.setAttribute("aria-invalid", "true");
    this.wrong = name;
    return true;
  }
  clear() {
    const at = this.rows.get(this.wrong);
    if (at) {
      at.message.hidden = true;
      at.line.classList.remove("wrong");
      at.field.removeAttribute("aria-invalid");
    }
    this.wrong = undefined;
  }

  filter(text) {
    this.wanted = text;
    const words = text.toLowerCase().split(/\s+/).filter(Boolean);
    for (const { row, line } of this.rows.values())
      line.hidden = !words.every((word) => `${row.name} ${row.doc}`.toLowerCase().includes(word));
    for (const section of this.place.querySelectorAll(".section, .more")) {
      const rows = [...section.querySelectorAll(".row")];
      if (section.classList.contains("is-off")) continue;
      section.hidden = words.length > 0 && rows.every((row) => row.hidden);
      if (words.length > 0 && !section.hidden) section.open = true;
    }
    return [...this.rows.values()].some(({ line }) => !line.hidden);
  }
}
