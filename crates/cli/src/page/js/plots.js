// Plots: axes, curves with bands, columns. Every mark has a title with its figures.

const PLOT = { width: 720, height: 400, left: 68, right: 16, top: 14, bottom: 46 };

/** An axis, logarithmic or straight, over some values, from one place to another. */
function axis(values, logarithmic, from, to, room = 0.04) {
  const usable = values.filter((v) => Number.isFinite(v) && (!logarithmic || v > 0));
  const place = logarithmic ? Math.log10 : (v) => v;
  let [low, high] = [Math.min(...usable.map(place)), Math.max(...usable.map(place))];
  if (!(high > low)) [low, high] = [low - 0.5, low + 0.5];
  const more = room * (high - low);
  [low, high] = [low - more, high + more];
  const at = (v) => from + ((place(v) - low) / (high - low)) * (to - from);
  const ticks = [];
  if (logarithmic) {
    const wide = high - low > 3;
    for (let d = Math.floor(low); d <= Math.ceil(high); d++) {
      for (const m of [1, 2, 5]) {
        const v = m * 10 ** d, p = d + Math.log10(m);
        if (p >= low && p <= high && (m === 1 || !wide)) ticks.push(v);
      }
    }
  }
  // Less than a decade shows too few of these.
  if (ticks.length < 3) {
    ticks.length = 0;
    const [first, last] = logarithmic ? [10 ** low, 10 ** high] : [low, high];
    const rough = (last - first) / 6, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough);
    for (let v = Math.ceil(first / step) * step; v <= last + 1e-9 * step; v += step) {
      if (!logarithmic || v > 0) ticks.push(Math.abs(v) < 1e-9 * step ? 0 : v);
    }
  }
  return { at, ticks };
}

/** A number beside an axis. */
function tickText(v) {
  if (v === 0) return "0";
  const size = Math.abs(v);
  return size >= 1e5 || size < 1e-3 ? v.toExponential(0).replace("e+", "e").replace(/-/g, "−") : String(Number(v.toPrecision(6))).replace("-", "−");
}

function frame(name, description, x, y, xName, yName, size = PLOT, yText = tickText) {
  const [right, bottom] = [size.width - size.right, size.height - size.bottom];
  const [titleId, textId] = [fresh("t"), fresh("d")];
  const svg = graphic("svg", { viewBox: `0 0 ${size.width} ${size.height}`, role: "img", "aria-labelledby": `${titleId} ${textId}`, class: "plot" },
    graphic("title", { id: titleId }, name), graphic("desc", { id: textId }, description));
  for (const v of x.ticks) {
    svg.append(graphic("line", { class: "grid", x1: x.at(v), x2: x.at(v), y1: size.top, y2: bottom }));
    svg.append(graphic("text", { x: x.at(v), y: bottom + 17, "text-anchor": "middle" }, tickText(v)));
  }
  for (const v of y.ticks) {
    svg.append(graphic("line", { class: "grid", x1: size.left, x2: right, y1: y.at(v), y2: y.at(v) }));
    svg.append(graphic("text", { x: size.left - 7, y: y.at(v) + 4, "text-anchor": "end" }, yText(v)));
  }
  svg.append(
    graphic("rect", { class: "frame", x: size.left, y: size.top, width: right - size.left, height: bottom - size.top }),
    graphic("text", { class: "axis", x: (size.left + right) / 2, y: size.height - 8, "text-anchor": "middle" }, xName),
    graphic("text", { class: "axis", transform: `translate(14 ${(size.top + bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, yName));
  return svg;
}

/** Names of curves with their ink, as a list beside a plot. */
function key(names, marks = true) {
  return element("ul", { class: "key" }, names.map((name, i) => element("li", {},
    marks ? graphic("svg", { viewBox: "0 0 26 10", width: 26, height: 10, "aria-hidden": "true" },
      graphic("line", { x1: 0, x2: 26, y1: 5, y2: 5, stroke: ink(i), "stroke-width": 2.5, "stroke-dasharray": dash(i) })) : null, name)));
}

/**
 * Curves: each has a name and points with x, y, perhaps low and high, and a text. `extra` draws on top with the axes at hand.
 */
function curves(name, description, list, options) {
  const size = options.size ?? PLOT;
  const points = list.flatMap((c) => c.points);
  if (points.length === 0) return element("p", { class: "muted" }, "Nothing that could be drawn.");
  const x = axis(points.map((p) => p.x), options.logX, size.left, size.width - size.right);
  const low = (p) => (p.low === undefined ? p.y : options.logY && p.low <= 0 ? p.y / 2 : p.low);
  const ys = points.flatMap((p) => [p.y, low(p), p.high ?? p.y]).concat(options.include ?? []);
  const y = axis(ys, options.logY, size.height - size.bottom, size.top);
  const svg = frame(name, description, x, y, options.x, options.y, size);
  list.forEach((curve, i) => {
    const line = curve.points.map((p) => `${x.at(p.x)},${y.at(p.y)}`).join(" ");
    if (curve.points.some((p) => p.low !== undefined)) {
      const band = [...curve.points.map((p) => `${x.at(p.x)},${y.at(p.high)}`), ...[...curve.points].reverse().map((p) => `${x.at(p.x)},${y.at(low(p))}`)];
      svg.append(graphic("polygon", { points: band.join(" "), fill: ink(i), "fill-opacity": 0.16 }));
    }
    svg.append(graphic("polyline", { points: line, fill: "none", stroke: ink(i), "stroke-width": 2, "stroke-dasharray": dash(i) }));
    for (const p of curve.points) {
      svg.append(graphic("circle", { cx: x.at(p.x), cy: y.at(p.y), r: options.small ? 2.2 : 3.4, fill: ink(i), "data-value": JSON.stringify(p.y) },
        graphic("title", {}, `${curve.name}: ${p.text ?? `${options.x} ${p.x}, ${options.y} ${p.y}`}`)));
    }
  });
  options.extra?.(svg, x, y, size);
  return svg;
}

/** Columns: labels and values, on a straight axis from 0 to `top`. */
function columns(name, description, bars, options) {
  const size = { width: 260, height: 150, left: 40, right: 6, top: 8, bottom: 38, ...options.size };
  const bottom = size.height - size.bottom;
  const greatest = options.top ?? Math.max(...bars.map((b) => b.value), 0);
  const y = axis([0, 1.04 * greatest || 1], false, bottom, size.top, 0);
  const svg = frame(name, description, { ticks: [], at: () => 0 }, { ...y, ticks: y.ticks.filter((_, i) => i % 2 === 0) }, options.x, "", size, (v) => percent(v, 2));
  const step = (size.width - size.left - size.right) / bars.length;
  const every = Math.ceil((9 * Math.max(...bars.map((b) => b.label.length))) / step);
  bars.forEach((bar, i) => {
    const left = size.left + i * step;
    svg.append(graphic("rect", { x: left + 0.1 * step, width: 0.8 * step, y: y.at(bar.value), height: Math.max(0, bottom - y.at(bar.value)), class: "column", "data-value": JSON.stringify(bar.value) },
      graphic("title", {}, bar.text)));
    if (i % every === 0) svg.append(graphic("text", { x: left + step / 2, y: bottom + 15, "text-anchor": "middle" }, bar.label));
  });
  return svg;
}

/** A bar inside a cell, for a share. */
function cellBar(value, show = percent) {
  if (value === null || value === undefined) return figure(null);
  const bar = element("span", { class: "share", "aria-hidden": "true" });
  bar.style.width = `${Math.min(100, Math.max(0, 100 * value))}%`;
  return element("span", { class: "sharing" }, bar, figure(value, show));
}
