// The sections: what the JSON of a run says, as tables and plots.

const METRICS = [["relMSE", "rel_mse"], ["trimmed relMSE", "trimmed_rel_mse"], ["MSE", "mse"], ["FLIP", "flip"]];
const seconds = (v) => `${short(v)} s`;
const signedPercent = (v) => (v > 0 ? "+" : "") + percent(v);

/** Names and values, beside each other. Those that are not there are left out. */
function facts(pairs) {
  const known = pairs.filter(([, value]) => value !== undefined && value !== null && value !== "");
  return element("dl", { class: "facts" }, known.map(([name, value, show]) => element("div", {},
    element("dt", {}, name), element("dd", {}, typeof value === "number" ? figure(value, show) : value))));
}

/** The settings, as the render wrote them. */
function config(text) {
  return element("details", {}, element("summary", {}, "Config (RON), with which the run can be repeated"),
    element("pre", { tabindex: "0", "aria-label": "Config" }, text));
}

function accuracySections(document_) {
  const run = document_.json;
  const methods = run.methods.filter((m) => m.points.length > 0);
  const last = (m) => m.points[m.points.length - 1];
  const parts = [element("p", { class: "advice" }, run.advice)];
  parts.push(facts([
    ["scene", run.scene], ["size", element("span", {}, figure(run.size[0]), " × ", figure(run.size[1]))], ["replicas", run.replicas], ["version", run.version],
    ["processor", run.machine.processor], ["threads", run.machine.threads], ["reference", run.reference.origin],
    ["relative error of its mean", run.reference.relative_error_of_the_mean, percent], ["its relMSE, taken off", run.reference.rel_mse_of_its_own],
  ]));

  const goals = methods[0]?.time_to_reach.map((t) => t.rel_mse) ?? [];
  parts.push(table("Methods, with intervals of 95 % over replicas; times are " + run.time, [
    { name: "method", wide: true, of: (m) => m.name, show: (m) => (m.name === run.best ? element("strong", {}, m.name) : m.name) },
    { name: "relMSE at the last budget", of: (m) => last(m).rel_mse.value, show: (m) => interval(last(m).rel_mse) },
    { name: "last budget", of: (m) => last(m).budget_seconds, show: (m) => figure(last(m).budget_seconds, seconds) },
    { name: "slope", hint: "of error against time on logarithmic axes; -1 without bias", of: (m) => m.slope?.value, show: (m) => interval(m.slope) },
    { name: "efficiency", hint: "1 / (error × time) relative to the best", of: (m) => m.efficiency_relative_to_the_best?.value, show: (m) => interval(m.efficiency_relative_to_the_best) },
    { name: "bias of the mean", of: (m) => last(m).bias?.value, show: (m) => interval(last(m).bias, signedPercent) },
    ...goals.map((goal, i) => ({ name: `time to ${goal}`, of: (m) => m.time_to_reach[i].seconds?.value, show: (m) => interval(m.time_to_reach[i].seconds, seconds) })),
  ], methods));

  const holder = element("div");
  const draw = (k) => {
    const [name, field] = METRICS[k];
    const list = methods.map((m) => ({
      name: m.name,
      points: m.points.filter((p) => p.seconds > 0 && p[field].value > 0).map((p) => ({
        x: p.seconds, y: p[field].value, low: p[field].low, high: p[field].high,
        text: `${short(p.seconds)} s, ${name} ${short(p[field].value)} (${short(p[field].low)} to ${short(p[field].high)})`,
      })),
    }));
    const crossings = field === "rel_mse" ? run.crossings : [];
    const extra = (svg, x, y, size) => crossings.forEach((c) => {
      const at = x.at(c.seconds.value);
      svg.append(graphic("g", { class: "crossing" },
        graphic("title", {}, `${c.late} overtakes ${c.early} at ${short(c.seconds.value)} s (${short(c.seconds.low)} to ${short(c.seconds.high)})`),
        graphic("line", { x1: at, x2: at, y1: size.top, y2: size.height - size.bottom, "data-value": JSON.stringify(c.seconds.value) }),
        graphic("path", { d: `M${at - 5},${size.top} h10 l-5,8 z` })));
    });
    const description = list.map((m) => (m.points.length ? `${m.name} from ${short(m.points[0].y)} to ${short(m.points[m.points.length - 1].y)}` : `${m.name} nothing`)).join("; ");
    holder.replaceChildren(
      curves(`${name} against processor time`, `${description}. All values are in the table of points.`, list, { x: "seconds", y: name, logX: true, logY: true, extra }),
      key(list.map((m) => m.name)),
      crossings.length ? element("p", { class: "muted" }, "Triangles and dashed lines: where one method overtakes another. Bands: 95 %.") : element("p", { class: "muted" }, "Bands: 95 %."));
  };
  const metric = choice("metric", METRICS.map(([name]) => name), 0, draw);
  draw(0);
  parts.push(section(3, "Error against time", "Error against time", metric.box, holder,
    run.crossings.length ? table("Where one method overtakes another, by relMSE", [
      { name: "later better", wide: true, of: (c) => c.late }, { name: "earlier better", wide: true, of: (c) => c.early },
      { name: "from", of: (c) => c.seconds.value, show: (c) => interval(c.seconds, seconds) },
    ], run.crossings) : null,
    element("details", {}, element("summary", {}, "All points"), table("Means over replicas", [
      { name: "method", wide: true, of: (r) => r.name },
      { name: "budget", of: (r) => r.p.budget_seconds, show: (r) => figure(r.p.budget_seconds, seconds) },
      { name: "replicas", of: (r) => r.p.replicas, show: (r) => figure(r.p.replicas) },
      { name: "time", of: (r) => r.p.seconds, show: (r) => figure(r.p.seconds, seconds) },
      ...METRICS.map(([name, field]) => ({ name, of: (r) => r.p[field].value, show: (r) => interval(r.p[field]) })),
      { name: "bias", of: (r) => r.p.bias?.value, show: (r) => interval(r.p.bias, signedPercent) },
    ], methods.flatMap((m) => m.points.map((p) => ({ name: m.name, p })))))));

  const kept = run.methods.filter((m) => m.picture);
  if (kept.length) {
    parts.push(table("The pictures above: one replica of each method, its own errors", [
      { name: "method", wide: true, of: (m) => m.name },
      { name: "replica", of: (m) => m.picture.replica },
      { name: "budget", of: (m) => m.picture.budget_seconds, show: (m) => figure(m.picture.budget_seconds, seconds) },
      { name: "time", of: (m) => m.picture.seconds, show: (m) => figure(m.picture.seconds, seconds) },
      ...METRICS.map(([name, field]) => ({ name, of: (m) => m.picture[field] })),
      { name: "bias", of: (m) => m.picture.bias, show: (m) => figure(m.picture.bias, signedPercent) },
    ], kept));
  }
  parts.push(config(run.config));
  return section(2, `Accuracy: ${document_.name}`, "Accuracy", parts);
}

/** Columns that every tally has. */
function tallyColumns(of) {
  const built = (r) => { const t = of(r); return t.proposed - Object.values(t.not_built).reduce((sum, n) => sum + n, 0); };
  return [
    { name: "proposed", of: (r) => of(r).proposed },
    { name: "not built", hint: "the reasons, most frequent first", wide: true, of: (r) => of(r).proposed - built(r), show: (r) => reasons(of(r)) },
    { name: "accepted", of: (r) => of(r).accepted },
    { name: "acceptance", hint: "mean acceptance probability; a proposal that was not built counts as 0", of: (r) => of(r).acceptance, show: (r) => cellBar(of(r).acceptance) },
    { name: "jump, pixels", hint: "mean distance moved on the image when moved", of: (r) => of(r).mean_jump_pixels },
    { name: "ns each", of: (r) => of(r).ns_per_proposal },
    { name: "faulty", of: (r) => of(r).faulty },
  ];
}

function reasons(tally) {
  const list = Object.entries(tally.not_built).sort((a, b) => b[1] - a[1]);
  if (list.length === 0) return element("span", { class: "none" }, "–");
  const shown = list.map(([reason, count], i) => [i ? ", " : "", reason, " ", figure(count)]);
  return element("span", { class: "reasons" }, shown.slice(0, 2), shown.length > 2 ? element("details", {}, element("summary", {}, `${shown.length - 2} more`), shown.slice(2)) : null);
}

function mutationSections(run) {
  const list = run.mutation_statistics;
  const used = list.filter((m) => m.proposed > 0);
  const parts = [section(3, "Mutations", "Mutations", table("All proposals of each mutation", [
    { name: "mutation", wide: true, of: (m) => m.name }, ...tallyColumns((m) => m),
  ], list))];
  const split = (field) => used.flatMap((m) => Object.entries(m[field]).map(([name, tally]) => ({ mutation: m.name, name, tally })));

  parts.push(section(3, "By length of the path", null,
    element("div", { class: "charts" }, used.map((m) => element("figure", {}, element("figcaption", {}, m.name),
      columns(`Acceptance of ${m.name} by length`, "Mean acceptance probability by the number of edges; the values are in the table below.",
        Object.entries(m.by_length).map(([length, t]) => ({ label: length, value: t.acceptance ?? 0, text: `${length} edges: ${percent(t.acceptance ?? 0)} of ${short(t.proposed)} proposals` })),
        { x: "edges", top: 1 })))),
    element("details", {}, element("summary", {}, "Table by length"), table("Proposals by mutation and by the number of edges of the path that was to be changed", [
      { name: "mutation", wide: true, of: (r) => r.mutation }, { name: "edges", of: (r) => Number(r.name), show: (r) => figure(r.name, String) }, ...tallyColumns((r) => r.tally),
    ], split("by_length")))));

  const classes = new Map();
  for (const { name, tally } of split("by_class")) classes.set(name, (classes.get(name) ?? 0) + tally.proposed);
  const frequent = [...classes].sort((a, b) => b[1] - a[1]).slice(0, 12).map(([name]) => name);
  parts.push(section(3, "By class of the path", null,
    frequent.length ? table("Acceptance in the most frequent classes: L is the light, D a surface that spreads, S one that does not, E the eye", [
      { name: "class", wide: true, of: (c) => c, show: (c) => element("code", {}, c) },
      ...used.map((m) => ({ name: m.name, of: (c) => m.by_class[c]?.acceptance, show: (c) => cellBar(m.by_class[c]?.acceptance) })),
    ], frequent, { class: "matrix" }) : null,
    element("details", {}, element("summary", {}, "Table by class"), table("Proposals by mutation and by the class of the path that was to be changed", [
      { name: "mutation", wide: true, of: (r) => r.mutation }, { name: "class", wide: true, of: (r) => r.name, show: (r) => element("code", {}, r.name) }, ...tallyColumns((r) => r.tally),
    ], split("by_class")))));

  const bounds = (j) => (j.from_pixels === 0 && j.to_pixels === 0 ? "0" : j.to_pixels === null ? `≥ ${j.from_pixels}` : j.from_pixels === 0 ? `< ${j.to_pixels}` : `${j.from_pixels} to ${j.to_pixels}`);
  const label = (j) => (j.from_pixels === 0 && j.to_pixels === 0 ? "0" : j.from_pixels === 0 ? "<" : j.from_pixels < 1 ? `1/${1 / j.from_pixels}` : String(j.from_pixels));
  parts.push(section(3, "How far accepted proposals jump", "Jumps",
    element("div", { class: "charts" }, used.filter((m) => m.jumps.length).map((m) => element("figure", {}, element("figcaption", {}, m.name, element("span", { class: "muted" }, ", mean ", figure(m.mean_jump_pixels), " px")),
      columns(`Jumps of ${m.name}`, "Share of the accepted weight by the distance moved on the image in pixels, from each power of two to the next.",
        m.jumps.map((j) => ({ label: label(j), value: j.share, text: `${bounds(j)} pixels: ${percent(j.share)}` })), { x: "pixels, from each power of two" })))),
    element("details", {}, element("summary", {}, "Table of jumps"), table("Share of the accepted weight by distance in pixels", [
      { name: "mutation", wide: true, of: (r) => r.mutation },
      { name: "from", of: (r) => r.from_pixels }, { name: "up to", of: (r) => r.to_pixels },
      { name: "share", of: (r) => r.share, show: (r) => cellBar(r.share) },
    ], used.flatMap((m) => m.jumps.map((j) => ({ mutation: m.name, ...j })))))));
  return parts;
}

function mixingSection(run) {
  const found = run.diagnostics;
  const names = { ln_luminance: "ln luminance", image_x: "image x", image_y: "image y" };
  const list = found.quantities.filter((q) => q.autocorrelation.length).map((q) => ({
    name: names[q.name] ?? q.name,
    points: q.autocorrelation.map((p) => ({ x: p.lag, y: p.correlation, text: `lag ${p.lag}: ${short(p.correlation)}` })),
  }));
  const steps = run.mutations / run.chains;
  return section(3, "How well the chains mix", "Mixing",
    table("What is watched in the chains", [
      { name: "quantity", wide: true, of: (q) => names[q.name] ?? q.name },
      { name: "autocorrelation time, steps", of: (q) => q.autocorrelation_time },
      { name: "effective samples", of: (q) => q.effective_sample_size },
      { name: "R-hat", hint: "potential scale reduction over the chains; 1 where they agree", of: (q) => q.r_hat, show: (q) => figure(q.r_hat, (v) => v.toFixed(3)) },
    ], found.quantities),
    list.length ? [
      curves("Autocorrelation of the chains", `Correlation of a chain with itself by lag in steps, over the first 256 chains. ${list.map((c) => `${c.name} from ${short(c.points[0].y)} to ${short(c.points[c.points.length - 1].y)}`).join("; ")}.`,
        list, { x: "lag, steps", y: "correlation", logX: true, include: [0, 1], small: true }),
      key(list.map((c) => c.name)),
      element("details", {}, element("summary", {}, "Table of correlations"), table("Autocorrelation by lag", [
        { name: "lag, steps", of: (r) => r.lag },
        ...found.quantities.map((q, k) => ({ name: names[q.name] ?? q.name, of: (r) => r.values[k] })),
      ], found.quantities[0].autocorrelation.map((p, i) => ({ lag: p.lag, values: found.quantities.map((q) => q.autocorrelation[i]?.correlation) })))),
    ] : element("p", { class: "muted" }, `The chains are too short, ${short(steps)} steps each, for an autocorrelation function.`),
    element("p", {}, "Longest stay: ", figure(found.longest_stay), " steps", found.longest_stay_class ? [" at a path ", element("code", {}, found.longest_stay_class)] : null,
      ". Stuck chains: ", figure(found.stuck_chains), "."));
}

function censusSection(run) {
  return section(3, "Census", "Census", table("Effects: what the scene has of them, and what follows", [
    { name: "effect", wide: true, of: (c) => c.effect },
    { name: "found", wide: true, of: (c) => (c.found ? "yes" : "no") },
    { name: "where", wide: true, of: (c) => c.place },
    { name: "what follows, or what is saved", wide: true, of: (c) => c.consequence },
  ], run.census),
  run.effects.mutations_left_out?.length ? element("p", {}, `Left out, since they apply to no path: ${run.effects.mutations_left_out.join(", ")}.`) : null);
}

function stabilitySection(run) {
  const rows = [
    ...Object.entries(run.stability.by_place).map(([name, counts]) => ({ name, counts })),
    ...Object.entries(run.stability.by_mutation).map(([name, counts]) => ({ name, counts })),
  ].flatMap(({ name, counts }) => Object.entries(counts).map(([what, count]) => ({ name, what, count })));
  return section(3, "Stability", null,
    element("p", {}, "Contributions left out because they were no number or negative: ", figure(run.stability.total), "."),
    element("details", {}, element("summary", {}, "By place and mutation"), table("What was left out", [
      { name: "where", wide: true, of: (r) => r.name }, { name: "what", wide: true, of: (r) => r.what }, { name: "count", of: (r) => r.count },
    ], rows)),
    run.faults?.length ? table("The first proposals whose densities were no numbers; `replay` shows them", [
      { name: "mutation", wide: true, of: (f) => f.mutation }, { name: "density", wide: true, of: (f) => f.density },
      { name: "class", wide: true, of: (f) => f.class }, { name: "chain", of: (f) => f.chain }, { name: "step", of: (f) => f.step },
    ], run.faults) : null);
}

function renderSections(document_) {
  const run = document_.json;
  const rate = (v) => `${short(v / 1e6)} M/s`;
  const parts = [facts([
    ["method", run.method], ["scene", run.scene], ["size", element("span", {}, figure(run.width), " × ", figure(run.height))], ["seed", element("span", {}, figure(run.seed, String))],
    ["wall time", run.wall_seconds, seconds], ["threads", run.threads], ["instructions", run.instructions], ["version", run.version],
    [run.chains === undefined ? "samples a pixel" : "mutations a pixel", run.samples_per_pixel], ["rays", run.rays], ["rays a second", run.rays_per_second, rate],
    ["mean radiance", element("span", {}, run.mean.map((v, i) => [i ? " " : "", figure(v)]))],
    ["b", run.b], ["relative error of b", run.b_relative_error, percent], ["seeding samples", run.seeding_samples], ["chains", run.chains], ["mutations of a chain before it begins anew", run.life],
    ["mutations", run.mutations], ["mutations a second", run.mutations_per_second, rate], ["seeding", run.seeding_seconds, seconds],
    ["direct light", run.direct_seconds, seconds], ["chains took", run.mutation_seconds, seconds],
  ])];
  const has = (list) => list && list.length > 0;
  if (has(run.mutation_statistics)) parts.push(...mutationSections(run));
  if (run.diagnostics && has(run.diagnostics.quantities)) parts.push(mixingSection(run));
  parts.push(censusSection(run), stabilitySection(run), config(run.config));
  if (has(run.notes)) parts.push(section(3, "Notes", null, element("ul", {}, run.notes.map((n) => element("li", {}, n)))));
  return section(2, `Render: ${document_.name}`, data.documents.length > 1 ? document_.name : "Render", parts);
}

/** All that should be known before the pictures are believed. */
function warnings() {
  const list = [...data.warnings];
  for (const { kind, name, json } of data.documents) {
    if (kind !== "render") continue;
    const of = (text) => (data.documents.length > 1 ? `${name}: ${text}` : text);
    list.push(...json.warnings.map(of), ...(json.diagnostics?.warnings ?? []).map(of));
    if (json.interrupted) list.push(of("the render was stopped before its budget was used up"));
    if (json.stability.total > 0) list.push(of(`${json.stability.total} contributions were left out, so the picture is too dark`));
  }
  if (list.length === 0) return element("p", { class: "fine" }, "No warnings.");
  return section(2, list.length === 1 ? "1 warning" : `${list.length} warnings`, "Warnings", element("ul", { class: "warnings" }, list.map((w) => element("li", {}, w))));
}

/** Errors of renders against the reference, measured when the page was made. */
function comparisons(pictures) {
  const rows = pictures.filter((p) => p.comparison);
  if (rows.length === 0 || data.documents.some((d) => d.kind === "accuracy")) return null;
  const show = (field, how = short) => ({ of: (p) => p.comparison[field], show: (p) => measured(p.comparison[field], how) });
  return table("Distances from the reference, its own noise included", [
    { name: "picture", wide: true, of: (p) => p.name }, { name: "what it is", wide: true, of: (p) => p.caption },
    ...METRICS.map(([name, field]) => ({ name, ...show(field) })), { name: "bias of the mean", ...show("bias", signedPercent) },
  ], rows);
}
