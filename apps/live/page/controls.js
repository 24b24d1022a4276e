// SPDX-License-Identifier: Apache-2.0
// The forms of the sensor: a section for each component and table, a row for each parameter. Everything about a row
// (unit, range, scale, words, documentation) comes from the field tables of the program.

const CALM_MS = 100;
const LISTS = { presample: "Before sampling", readout: "Readout", postsample: "After sampling" };
const element = (tag, properties = {}, ...children) => {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
};

export const shortNumber = (value) => String(Number(value.toPrecision(4)));

const position = (row, value) => row.log
  ? (1000 * Math.log(value / row.low)) / Math.log(row.high / row.low)
  : (1000 * (value - row.low)) / (row.high - row.low);
const valueAt = (row, t) => {
  const value = row.log ? row.low * (row.high / row.low) ** (t / 1000) : row.low + ((row.high - row.low) * t) / 1000;
  return row.whole ? Math.round(value) : value;
};
/** As the sensor file has it. */
const written = (row, value) => {
  const number = row.whole ? String(value) : shortNumber(value);
  return row.unit ? `${number} ${row.unit}` : row.whole || /[.e]/.test(number) ? number : `${number}.0`;
};

export class Controls {
  /** `act`: what the forms call: drag, drop, set, add, reset. */
  constructor(place, act) {
    this.place = place;
    this.act = act;
    this.rows = new Map(); // name -> { row, update }
    this.open = new Map(); // sections that the user has opened or closed
    this.shape = "";
    this.begin = new Map(); // texts at the start
  }

  /** The texts that `reset` goes back to. */
  remember(model) {
    for (const owner of [...model.components, ...model.tables])
      for (const row of owner.rows) this.begin.set(row.name, row.given ? row.text : null);
  }

  show(model) {
    const owners = [...model.components, ...model.tables];
    const shape = JSON.stringify([owners.map((owner) => [owner.label ?? owner.name, owner.rows.map((row) => [row.name, row.control, row.given])]), model.off]);
    if (shape === this.shape) {
      for (const owner of owners) for (const row of owner.rows) this.rows.get(row.name)?.update(row);
      return;
    }
    this.shape = shape;
    const focus = document.activeElement?.dataset?.focus;
    this.rows.clear();
    const groups = Object.keys(LISTS).map((list) => this.list(list, model)).filter(Boolean);
    this.place.replaceChildren(...groups, ...this.tables(model));
    if (focus) this.place.querySelector(`[data-focus="${CSS.escape(focus)}"]`)?.focus();
    this.filter(this.wanted ?? "");
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
    choice.onchange = () => choice.value && this.act.add(["add", list, choice.value]);
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
    const details = element("details", { className: "section", open: this.open.get(key) ?? (owner.list !== undefined || owner.name === "optics") });
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
    const label = element("label", { htmlFor: id, title: `${row.doc}${row.example ? `, such as ${row.example}` : ""}` }, row.key.replace(/^(.*)\[(\d)\]$/, (_, name, i) => `${i === "0" ? "1st" : "2nd"} ${name}`));
    const back = element("button", { type: "button", className: "small quiet back", title: "As at the start", hidden: true }, "↺");
    back.setAttribute("aria-label", `${row.key} as at the start`);
    back.onclick = () => this.act.reset(row.name, this.begin.get(row.name) ?? row.example);
    let field, slider = null, now = row, told = 0;
    if (row.control === "word" || row.control === "flag") {
      field = element("select", { id });
      for (const word of row.words ?? ["true", "false"]) field.append(element("option", {}, word));
      if (!row.given) field.prepend(element("option", { value: "" }, row.text || "not given"));
      field.onchange = () => field.value && this.act.set(row.name, field.value);
    } else {
      field = element("input", { id, type: "text", spellcheck: false, autocomplete: "off", disabled: row.control === "file" });
      field.placeholder = row.text || row.example;
      field.onchange = () => field.value.trim() !== "" && this.act.set(row.name, field.value.trim());
    }
    field.dataset.focus = id;
    field.setAttribute("aria-describedby", message.id);
    if (row.control === "number") {
      slider = element("input", { type: "range", min: 0, max: 1000, step: "any" });
      slider.setAttribute("aria-label", `${row.name} slider`);
      slider.dataset.focus = `${id}-slider`;
      slider.oninput = () => {
        const text = written(now, valueAt(now, Number(slider.value)));
        // The text follows no more often than can be read: a page that is painted costs pictures.
        if (performance.now() - told > CALM_MS) [field.value, told] = [text, performance.now()];
        slider.setAttribute("aria-valuetext", text);
        this.act.drag(row.name, text);
      };
      slider.onchange = () => {
        field.value = written(now, valueAt(now, Number(slider.value)));
        this.act.drop();
      };
      slider.onkeydown = (event) => { // a step is a hundredth of the way
        const step = { ArrowLeft: -10, ArrowDown: -10, ArrowRight: 10, ArrowUp: 10, PageDown: -100, PageUp: 100 }[event.key];
        if (step === undefined) return;
        event.preventDefault();
        slider.value = Number(slider.value) + step;
        slider.oninput();
        slider.onchange();
      };
    }
    const update = (next) => {
      now = next;
      if (document.activeElement !== field || field.tagName === "SELECT") field.value = next.given ? next.text : "";
      if (slider && document.activeElement !== slider) slider.value = position(next, next.number);
      else if (slider && slider.matches(":not(:active)")) slider.value = position(next, next.number);
      slider?.setAttribute("aria-valuetext", next.text || next.example);
      const start = this.begin.get(row.name);
      back.hidden = start === undefined || (next.given ? next.text : null) === start;
    };
    update(row);
    this.rows.set(row.name, { row, update, line, message, field });
    line.append(label, ...(slider ? [slider] : []), field, back, message);
    line.classList.toggle("no-slider", !slider);
    return line;
  }

  /** The program's own words at the control that they are about. */
  problem(name, text) {
    this.clear();
    const at = this.rows.get(name);
    if (!at) return false;
    at.message.textContent = text;
    at.message.hidden = false;
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
  }
}
