// Elements, numbers and colours that everything else is made with.

const data = JSON.parse(document.getElementById("data").textContent);
const SVG = "http://www.w3.org/2000/svg";

/** An element: its attributes (`on...` are listeners) and children (texts, elements, lists of these; null is nothing). */
function element(name, attributes, ...children) {
  const made = document.createElement(name);
  return fill(made, attributes, children);
}

/** The same for graphics. */
function graphic(name, attributes, ...children) {
  return fill(document.createElementNS(SVG, name), attributes, children);
}

function fill(made, attributes, children) {
  for (const [key, value] of Object.entries(attributes ?? {})) {
    if (value === null || value === undefined || value === false) continue;
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else made.setAttribute(key, value === true ? "" : String(value));
  }
  // What is null is left out, as append would write the word.
  made.append(...children.flat(4).filter((child) => child !== null && child !== undefined));
  return made;
}

/** A number to some significant digits, short. */
function short(value, digits = 3) {
  if (typeof value !== "number") return String(value);
  if (!Number.isFinite(value)) return Number.isNaN(value) ? "NaN" : value > 0 ? "∞" : "−∞";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e7 || size < 1e-3) return value.toExponential(digits - 1).replace("-", "−").replace("e+", "e");
  if (Number.isInteger(value) || size >= 1e4) return Math.round(value).toLocaleString("en-US").replaceAll(",", " ").replace("-", "−");
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  return value.toFixed(Math.min(decimals, 8)).replace("-", "−");
}

function percent(value, digits = 3) {
  return `${short(100 * value, digits)} %`;
}

/** A figure of the run's JSON: what is shown, with the exact value beside it. */
function figure(value, show = short) {
  if (value === null || value === undefined) return element("span", { class: "none" }, "–");
  const exact = typeof value === "number" ? JSON.stringify(value) : String(value);
  return element("data", { value: exact, "data-value": exact, title: exact }, show(value));
}

/** A figure with its interval of 95 %. */
function interval(found, show = short) {
  if (!found) return figure(null);
  return [figure(found.value, show), element("span", { class: "range" }, " (", figure(found.low, show), " to ", figure(found.high, show), ")")];
}

/** A figure that was measured from the pictures of this page, not taken from the run's JSON. */
function measured(value, show = short) {
  return element("data", { value: String(value), "data-measured": String(value), title: `${value}, measured from the pictures` }, show(value));
}

/** Ink that people who see few colours can tell apart (Okabe and Ito 2008). */
const INKS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b88600", "#3a9bd9", "#8c6d31", "#777777"];
const ink = (i) => INKS[i % INKS.length];
const DASHES = ["", "7 3", "2 3", "9 3 2 3", "12 4", "4 2"];
const dash = (i) => DASHES[i % DASHES.length];

let ids = 0;
const fresh = (name) => `${name}-${++ids}`;

/** A section with a heading; it is in the contents of the page under a short name, if it has one. */
function section(level, title, entry, ...children) {
  const id = fresh("s");
  return element("section", { "aria-labelledby": id }, element(`h${level}`, { id, "data-entry": entry }, title), ...children);
}

function contents() {
  // With several runs, the parts of each would only repeat each other.
  const heads = document.querySelectorAll(data.documents.length > 1 ? "h2[data-entry]" : "[data-entry]");
  document.getElementById("contents").replaceChildren(...Array.from(heads, (head) =>
    element("li", {}, element("a", { href: `#${head.id}` }, head.dataset.entry))));
}

/** What a screen reader is told, at most every half second and only the last of it. */
function announcer() {
  const region = element("p", { class: "unseen", "aria-live": "polite", "aria-atomic": "true" });
  let waiting = null;
  const say = (text) => {
    clearTimeout(waiting);
    waiting = setTimeout(() => { region.textContent = text; }, 500);
  };
  return { region, say };
}

/**
 * A table whose columns sort. `columns` have a name, `of` a row: what to sort by, `show` a row: what to show, perhaps `wide` for text
 * and `hint`. Sorting is by buttons in the heads; numbers start with the greatest.
 */
function table(caption, columns, rows, options = {}) {
  const body = element("tbody");
  const heads = [];
  let sorted = { column: -1, up: true };
  const draw = () => {
    let list = rows;
    if (sorted.column >= 0) {
      const of = columns[sorted.column].of;
      const rank = (row) => { const v = of(row); return v === undefined || v === null || Number.isNaN(v) ? null : v; };
      list = [...rows].sort((a, b) => {
        const [x, y] = [rank(a), rank(b)];
        // What is not known comes last either way.
        if (x === null || y === null) return (x === null) - (y === null);
        const order = typeof x === "string" ? x.localeCompare(y) : x - y;
        return sorted.up ? order : -order;
      });
    }
    body.replaceChildren(...list.map((row) => element("tr", {}, columns.map((column, i) => {
      const shown = column.show ? column.show(row) : figureOrText(column.of(row));
      const kind = column.wide ? "text" : "number";
      return i === 0 ? element("th", { scope: "row", class: kind }, shown) : element("td", { class: kind }, shown);
    }))));
    heads.forEach((head, i) => head.setAttribute("aria-sort", i !== sorted.column ? "none" : sorted.up ? "ascending" : "descending"));
  };
  const sort = (i) => {
    const text = columns[i].wide;
    sorted = { column: i, up: sorted.column === i ? !sorted.up : Boolean(text) };
    draw();
  };
  for (const [i, column] of columns.entries()) {
    const label = [column.name, element("span", { class: "arrow", "aria-hidden": "true" })];
    heads.push(element("th", { scope: "col", "aria-sort": "none", class: column.wide ? "text" : "number", title: column.hint },
      element("button", { type: "button", onclick: () => sort(i) }, label)));
  }
  draw();
  const shown = element("table", { class: options.class }, element("caption", {}, caption), element("thead", {}, element("tr", {}, heads)), body);
  return element("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": `${caption}, table` }, shown);
}

function figureOrText(value) {
  return typeof value === "string" ? value : figure(value);
}

/** A list of buttons of which one is chosen. */
function choice(label, names, chosen, pick) {
  const id = fresh("choice");
  const options = names.map((name, i) => element("option", { value: i, selected: i === chosen }, name));
  const select = element("select", { id, onchange: () => pick(Number(select.value)) }, options);
  return { box: element("label", { for: id, class: "field" }, element("span", {}, label), select), select };
}
