// The viewer: one picture, two with a slider between them, or two side by side; zoom and pan are the same for both.

const LAYOUTS = ["one picture", "slider between two", "side by side"];
const [ONE, SLIDER, SIDE] = [0, 1, 2];
/** Screen pixels for a pixel of the picture at most. */
const CLOSEST = 64;

function viewer(pictures, reference) {
  const { width, height } = pictures[0];
  const state = {
    a: 0,
    b: reference && pictures.length > 1 ? reference.index : Math.min(1, pictures.length - 1),
    layout: pictures.length > 1 ? SLIDER : ONE,
    view: 0, tone: 0, stops: 0, split: 0.5, zoom: 1, x: width / 2, y: height / 2,
    cursor: { x: Math.floor(width / 2), y: Math.floor(height / 2) },
  };
  const { region, say } = announcer();
  const canvas = element("canvas", { "aria-hidden": "true" });
  const ink2d = canvas.getContext("2d");
  const labels = [element("span", { class: "label left" }), element("span", { class: "label right" })];
  const handle = element("div", {
    class: "handle", role: "slider", tabindex: "0", "aria-label": "Slider between the two pictures", "aria-orientation": "horizontal",
    "aria-valuemin": "0", "aria-valuemax": "100", "aria-valuenow": "50",
  });
  const stage = element("div", {
    class: "stage", tabindex: "0", role: "group", "aria-label": "Pictures", "aria-describedby": "viewer-keys",
  }, canvas, labels, handle);
  const readout = element("div", { class: "readout" });
  const legend = element("div", { class: "legend" });

  // What is drawn of each picture, until it looks different.
  const drawn = new Map();
  const factor = () => data.exposure * 2 ** state.stops;
  function image(picture) {
    // The reference has no error, so it stays a picture to compare errors with.
    const view = VIEWS[state.view].error && picture === reference ? VIEWS[0] : VIEWS[state.view];
    const key = `${view.name} ${state.tone} ${view.error ? 0 : state.stops}`;
    let known = drawn.get(picture.index);
    if (!known) {
      const surface = element("canvas", { width, height });
      const pen = surface.getContext("2d");
      known = { surface, pen, target: pen.createImageData(width, height), key: null };
      drawn.set(picture.index, known);
    }
    if (known.key !== key) {
      develop(picture, reference, view, TONES[state.tone], factor(), known.target);
      known.pen.putImageData(known.target, 0, 0);
      known.key = key;
    }
    return known.surface;
  }

  // Places on the screen. A pane is a part of the canvas that shows a whole picture.
  const panes = () => {
    const w = canvas.clientWidth, h = canvas.clientHeight;
    return state.layout === SIDE ? [{ x: 0, w: w / 2, h }, { x: w / 2, w: w / 2, h }] : [{ x: 0, w, h }];
  };
  const fit = () => { const [p] = panes(); return Math.min(p.w / width, p.h / height); };
  const scale = () => fit() * state.zoom;
  const paneAt = (x) => panes().findLast((p) => x >= p.x) ?? panes()[0];
  function pixelAt(x, y) {
    const p = paneAt(x);
    return { x: state.x + (x - p.x - p.w / 2) / scale(), y: state.y + (y - p.h / 2) / scale() };
  }
  function keepInside() {
    state.zoom = Math.max(1, Math.min(state.zoom, Math.max(1, CLOSEST / fit())));
    const [p] = panes();
    const limit = (at, size, shown) => (shown >= size ? size / 2 : Math.min(Math.max(at, shown / 2), size - shown / 2));
    state.x = limit(state.x, width, p.w / scale());
    state.y = limit(state.y, height, p.h / scale());
  }

  let asked = false;
  function draw() {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; drawNow(); });
  }
  function drawNow() {
    const w = canvas.clientWidth, h = canvas.clientHeight, dense = window.devicePixelRatio || 1;
    if (w === 0) return;
    if (canvas.width !== Math.round(w * dense) || canvas.height !== Math.round(h * dense)) {
      canvas.width = Math.round(w * dense);
      canvas.height = Math.round(h * dense);
    }
    keepInside();
    ink2d.setTransform(dense, 0, 0, dense, 0, 0);
    ink2d.clearRect(0, 0, w, h);
    const s = scale();
    const put = (picture, pane, from, to) => {
      ink2d.save();
      ink2d.beginPath();
      ink2d.rect(from, 0, to - from, h);
      ink2d.clip();
      ink2d.imageSmoothingEnabled = s * dense < 1;
      const left = pane.x + pane.w / 2 - state.x * s, top = pane.h / 2 - state.y * s;
      ink2d.drawImage(image(picture), left, top, width * s, height * s);
      ink2d.lineWidth = 1;
      const x = left + state.cursor.x * s, y = top + state.cursor.y * s, size = Math.max(s, 5), off = (size - s) / 2;
      ink2d.strokeStyle = "#000";
      ink2d.strokeRect(x - off - 1, y - off - 1, size + 2, size + 2);
      ink2d.strokeStyle = "#fff";
      ink2d.strokeRect(x - off, y - off, size, size);
      ink2d.restore();
    };
    const ps = panes();
    const [a, b] = [pictures[state.a], pictures[state.b]];
    if (state.layout === ONE) put(a, ps[0], 0, w);
    else if (state.layout === SLIDER) {
      put(a, ps[0], 0, w * state.split);
      put(b, ps[0], w * state.split, w);
    } else {
      put(a, ps[0], 0, w / 2);
      put(b, ps[1], w / 2, w);
    }
    stage.style.touchAction = state.zoom > 1 ? "none" : "pan-y";
  }

  function showLabels() {
    labels[0].textContent = pictures[state.a].name;
    labels[1].textContent = pictures[state.b].name;
    labels[1].hidden = state.layout === ONE;
    handle.hidden = state.layout !== SLIDER;
    const share = Math.round(100 * state.split);
    handle.style.left = `${100 * state.split}%`;
    handle.setAttribute("aria-valuenow", share);
    handle.setAttribute("aria-valuetext", `${share} % ${pictures[state.a].name}, the rest ${pictures[state.b].name}`);
    tabs.forEach((tab, i) => tab.setAttribute("aria-pressed", String(i === state.a)));
    other.select.value = state.b;
  }

  function showReadout() {
    const { x, y } = state.cursor;
    const i = y * width + x;
    const names = state.layout === ONE ? [state.a] : [state.a, state.b];
    const shown = [...new Set(reference ? [...names, reference.index] : names)].map((n) => pictures[n]);
    const rows = shown.map((p) => {
      const [r, g, b] = [0, 1, 2].map((c) => p.rgb[3 * i + c]);
      const cells = [r, g, b, luminance(r, g, b)].map((v) => element("td", { class: "number" }, measured(v, (n) => short(n, 4))));
      if (reference) {
        const mine = p.index === reference.index;
        cells.push(...[
          [relativeError(p.rgb, reference.rgb, i), percent],
          [relativeSquare(p.rgb, reference.rgb, i), short],
          [p.flip ? p.flip[i] / 255 : 0, short],
        ].map(([v, show], k) => element("td", { class: "number" }, mine || (k === 2 && !p.flip) ? figure(null) : measured(v, show))));
      }
      return element("tr", {}, element("th", { scope: "row", class: "text" }, p.name), cells);
    });
    const heads = ["", "red", "green", "blue", "luminance", ...(reference ? ["relative error", "squared", "FLIP"] : [])];
    readout.replaceChildren(element("table", { class: "values" },
      element("caption", {}, `Radiance at pixel (${x}, ${y}), from the upper left corner`),
      element("thead", {}, element("tr", {}, heads.map((h, k) => element("th", { scope: "col", class: k ? "number" : "text" }, h)))),
      element("tbody", {}, rows)));
    place.forEach((input, k) => { input.value = k ? y : x; });
  }
  function tell() {
    const { x, y } = state.cursor;
    const i = 3 * (y * width + x);
    const of = (p) => `${p.name} ${[0, 1, 2].map((c) => short(p.rgb[i + c])).join(" ")}`;
    const names = state.layout === ONE ? [state.a] : [state.a, state.b];
    say(`pixel ${x}, ${y}: ${names.map((n) => of(pictures[n])).join("; ")}`);
  }
  function moveCursor(x, y, spoken) {
    state.cursor = { x: Math.min(Math.max(x, 0), width - 1), y: Math.min(Math.max(y, 0), height - 1) };
    if (spoken) {
      // The pixel that is read stays in sight.
      const [p] = panes();
      const [halfX, halfY] = [p.w / scale() / 2 - 1, p.h / scale() / 2 - 1];
      state.x = Math.min(Math.max(state.x, state.cursor.x + 1 - halfX), state.cursor.x + halfX);
      state.y = Math.min(Math.max(state.y, state.cursor.y + 1 - halfY), state.cursor.y + halfY);
      tell();
    }
    showReadout();
    draw();
  }

  function showLegend() {
    const view = VIEWS[state.view];
    if (!view.scale) {
      legend.replaceChildren(element("p", { class: "muted" }, "Linear RGB radiance through the exposure and the tone curve."));
      return;
    }
    const stops = view.scale.map((c, i) => `rgb(${c.join(" ")}) ${(100 * i) / (view.scale.length - 1)}%`);
    const bar = element("div", { class: "bar", role: "img", "aria-label": `Colour scale: ${view.ends(factor()).join(", ")}` });
    bar.style.background = `linear-gradient(to right, ${stops.join(", ")})`;
    legend.replaceChildren(bar, element("div", { class: "ends", "aria-hidden": "true" }, view.ends(factor()).map((e) => element("span", {}, e))),
      element("p", { class: "muted" }, `${view.name}: ${view.unit}. Magenta: no number.`));
  }

  function update() {
    stage.style.aspectRatio = `${state.layout === SIDE ? 2 * width : width} / ${height}`;
    showLabels();
    showReadout();
    showLegend();
    const steps = state.stops > 0 ? `+${state.stops.toFixed(1)}` : state.stops.toFixed(1).replace("-", "−");
    exposureText.textContent = `${steps} stops, radiance × ${short(factor())}`;
    exposure.setAttribute("aria-valuetext", `${steps} stops`);
    zoomText.textContent = `${short(Math.round(100 * scale()) / 100, 3)} screen pixels a pixel`;
    draw();
  }
  function flipTo(i, spoken = true) {
    if (i < 0 || i >= pictures.length) return;
    state.a = i;
    update();
    if (spoken) say(`shows ${pictures[i].name}`);
  }
  function swap() {
    [state.a, state.b] = [state.b, state.a];
    update();
    say(`shows ${pictures[state.a].name}`);
  }
  function zoomBy(by, x, y) {
    const before = x === undefined ? null : pixelAt(x, y);
    state.zoom *= by;
    keepInside();
    if (before) {
      const after = pixelAt(x, y);
      state.x += before.x - after.x;
      state.y += before.y - after.y;
    }
    update();
  }
  function setSplit(share) {
    state.split = Math.min(Math.max(share, 0), 1);
    showLabels();
    draw();
  }

  // Controls.
  const tabs = pictures.map((p, i) => element("button", { type: "button", class: "tab", "aria-pressed": "false", onclick: () => flipTo(i), title: p.caption },
    i < 9 ? element("kbd", {}, i + 1) : null, p.name));
  const other = choice("second picture", pictures.map((p) => p.name), state.b, (i) => { state.b = i; update(); });
  const layout = choice("layout", pictures.length > 1 ? LAYOUTS : LAYOUTS.slice(0, 1), state.layout, (i) => { state.layout = i; update(); });
  const usable = VIEWS.map((view, i) => i).filter((i) => (reference || !VIEWS[i].error) && (VIEWS[i].name !== "FLIP" || pictures.some((p) => p.flip)));
  const look = choice("show", usable.map((i) => VIEWS[i].name), 0, (i) => { state.view = usable[i]; update(); });
  const tone = choice("tone curve", TONES.map((t) => t.name), 0, (i) => { state.tone = i; update(); });
  const exposureId = fresh("exposure");
  const exposure = element("input", {
    id: exposureId, type: "range", min: "-10", max: "10", step: "0.1", value: "0", oninput: () => { state.stops = Number(exposure.value); update(); },
  });
  const exposureText = element("output", { for: exposureId, class: "muted" });
  const zoomText = element("output", { class: "muted" });
  const button = (text, label, act) => element("button", { type: "button", "aria-label": label, title: label, onclick: act }, text);
  const reset = () => { Object.assign(state, { zoom: 1, x: width / 2, y: height / 2 }); update(); };
  const place = ["x", "y"].map((axis, k) => element("input", {
    type: "number", min: "0", max: (k ? height : width) - 1, "aria-label": `${axis} of the pixel that is read`,
    onchange: () => { const [x, y] = place.map((p) => Math.round(Number(p.value)) || 0); moveCursor(x, y, true); },
  }));

  // The mouse, fingers and pens.
  const at = (event) => { const box = canvas.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
  let drag = null;
  stage.addEventListener("pointerdown", (event) => {
    if (event.target === handle) return;
    drag = { from: at(event), x: state.x, y: state.y };
    stage.setPointerCapture(event.pointerId);
  });
  stage.addEventListener("pointermove", (event) => {
    const [x, y] = at(event);
    if (drag) {
      state.x = drag.x - (x - drag.from[0]) / scale();
      state.y = drag.y - (y - drag.from[1]) / scale();
    }
    const pixel = pixelAt(x, y);
    if (pixel.x >= 0 && pixel.x < width && pixel.y >= 0 && pixel.y < height) moveCursor(Math.floor(pixel.x), Math.floor(pixel.y), false);
    else draw();
  });
  for (const end of ["pointerup", "pointercancel"]) stage.addEventListener(end, () => { drag = null; });
  stage.addEventListener("wheel", (event) => {
    // At full view, scrolling on belongs to the page.
    if (event.deltaY > 0 && state.zoom <= 1) return;
    event.preventDefault();
    zoomBy(Math.exp(-Math.sign(event.deltaY) * 0.2), ...at(event));
  }, { passive: false });
  handle.addEventListener("pointerdown", (event) => { handle.setPointerCapture(event.pointerId); handle.focus(); event.preventDefault(); });
  handle.addEventListener("pointermove", (event) => {
    if (handle.hasPointerCapture(event.pointerId)) setSplit(at(event)[0] / canvas.clientWidth);
  });

  // The keyboard.
  handle.addEventListener("keydown", (event) => {
    const steps = { ArrowLeft: -0.01, ArrowDown: -0.01, ArrowRight: 0.01, ArrowUp: 0.01, PageDown: -0.1, PageUp: 0.1 };
    if (event.key in steps) setSplit(Math.round(100 * (state.split + steps[event.key])) / 100);
    else if (event.key === "Home") setSplit(0);
    else if (event.key === "End") setSplit(1);
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  stage.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const arrow = arrows[event.key];
    if (arrow && event.shiftKey) moveCursor(state.cursor.x + arrow[0], state.cursor.y + arrow[1], true);
    else if (arrow) {
      const [p] = panes();
      state.x += (arrow[0] * 0.1 * p.w) / scale();
      state.y += (arrow[1] * 0.1 * p.h) / scale();
      update();
    } else if (event.key === "+" || event.key === "=") zoomBy(1.25);
    else if (event.key === "-") zoomBy(0.8);
    else if (event.key === "0") reset();
    else if (event.key === " ") swap();
    else return;
    event.preventDefault();
  });
  document.addEventListener("keydown", (event) => {
    const typing = event.target.closest?.("input, select, textarea");
    if (typing || event.ctrlKey || event.metaKey || event.altKey) return;
    if (/^[1-9]$/.test(event.key) && Number(event.key) <= pictures.length) flipTo(Number(event.key) - 1);
  });
  new ResizeObserver(() => update()).observe(stage);

  const several = pictures.length > 1;
  const lost = pictures.filter((p) => p.clipped).map((p) => `${p.clipped} of ${p.name}`);
  const keys = element("details", {}, element("summary", {}, "Keys and mouse"), element("p", { id: "viewer-keys", class: "muted" },
    "Wheel, + and − zoom, 0 shows all. Drag or the arrow keys move the picture; Shift and the arrow keys move the pixel that is read. ",
    several ? "1 to 9 choose the first picture, the space bar swaps the two. The line between them moves by mouse and by arrow keys." : ""));
  update();
  return element("div", { class: "viewer" },
    several ? element("div", { class: "tabs", role: "group", "aria-label": "First picture" }, tabs) : null,
    element("div", { class: "controls" }, several ? [other.box, layout.box, element("span", { class: "field" }, button("swap", "Swap the two pictures (space)", swap))] : null, look.box, tone.box,
      element("label", { class: "field grow", for: exposureId }, element("span", {}, "exposure ", exposureText), exposure)),
    stage,
    element("div", { class: "under" },
      element("div", { class: "controls" }, button("+", "Zoom in", () => zoomBy(1.25)), button("−", "Zoom out", () => zoomBy(0.8)), button("all", "Show all of the picture", reset), zoomText,
        element("span", { class: "place" }, "pixel ", place)),
      legend),
    readout, lost.length ? element("p", { class: "muted" }, `Values too small beside the brightest for a half float, shown as 0: ${lost.join(", ")}.`) : null, keys, region);
}
