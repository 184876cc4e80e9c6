// Figures. Each is drawn by a function that reads the colours anew, so that it follows light, dark and print.

const plots = [];
let printing = false;
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
const narrow = () => innerWidth < 600; // a telephone: labels are wrapped and shortened
const hasWebGl = (() => {
  try {
    const canvas = document.createElement("canvas");
    return !!(canvas.getContext("webgl2") || canvas.getContext("webgl"));
  } catch (error) {
    return false;
  }
})();

function theme() {
  // while printing, the colours of paper: the style sheet changes only after the figures are made
  if (printing) return { ink: "#000", soft: "#444", line: "#ccc", accent: "#1f5fa8", warm: "#b4490f", good: "#1a6f3c", card: "#fff" };
  return Object.fromEntries(["ink", "soft", "line", "accent", "warm", "good", "card"].map((name) => [name, colour(name)]));
}

/** A figure: heading, plot, caption. `make` gives [traces, layout] for the colours; `label` is what it shows in words. */
function figure({ name, label, caption, make, kind, modeBar, height }) {
  const plot = el("div", { class: "plot " + (kind || ""), style: height ? "height:" + height + "px" : null, role: "img", "aria-label": label });
  let small = null;
  const draw = () => {
    if (!plot.clientWidth) return null; // folded: drawn when it is opened
    small = narrow();
    const c = theme();
    const [traces, layout] = make(c);
    const axis = { gridcolor: c.line, zerolinecolor: c.line, linecolor: c.line, automargin: true };
    const base = { paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: { color: c.ink, size: 12, family: getComputedStyle(document.body).fontFamily },
      margin: { l: 52, r: 12, t: 8, b: 40 }, showlegend: false, modebar: { bgcolor: "rgba(0,0,0,0)", color: c.soft, activecolor: c.accent }, hoverlabel: { font: { size: 12 } } };
    const full = Object.assign(base, layout);
    for (const key of Object.keys(full)) if (/^[xy]axis/.test(key)) full[key] = Object.assign({}, axis, full[key]);
    return Plotly.react(plot, traces, full, { displaylogo: false, displayModeBar: !!modeBar });
  };
  plots.push(draw);
  new ResizeObserver(() => {
    if (!plot.clientWidth) return;
    if (plot.data) Plotly.Plots.resize(plot).then(() => (small === narrow() ? null : draw()));
    else if (document.body.dataset.drawn) draw();
  }).observe(plot);
  const head = name ? el("div", { class: "name" }, name) : null;
  return { node: el("figure", {}, head, plot, caption ? el("figcaption", {}, caption) : null), draw };
}

/** One after the other, so that the page can be read and scrolled meanwhile. */
function drawAll() {
  let next = 0;
  const step = () => {
    if (next >= plots.length) {
      document.body.dataset.drawn = "yes";
      return;
    }
    plots[next++]();
    setTimeout(step, 0);
  };
  step();
}

window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawAll);
let folded = []; // what was closed before printing: paper has everything
function forPaper(begins) {
  for (const box of folded) box.open = begins;
  printing = begins;
  plots.forEach((draw) => draw());
}
window.addEventListener("beforeprint", () => {
  folded = [...document.querySelectorAll("details:not([open])")];
  forPaper(true);
});
window.addEventListener("afterprint", () => forPaper(false));

const titled = (text) => ({ text: plain(text), standoff: 6, font: { size: 12 } });

function variableFigure(v) {
  const along = v.direction === "approach" ? "along the approach" : "along " + v.direction;
  const unit = unitText(v.unit);
  const most = v.mean.reduce((best, m, i) => (Math.abs(m) > Math.abs(v.mean[best]) ? i : best), 0);
  const where = v.category ? v.labels[most] : num(v.at[most]) + (unit ? " " + unit : "");
  const means = v.mean.concat(v.improved.filter(known));
  const reach = 1.25 * Math.max(...v.mean.map((m, i) => Math.abs(m) + 2 * (v.standard_error[i] || 0)), ...means.map(Math.abs),
    quantile(v.y.map(Math.abs), 0.98) || 0, 1e-9);
  const jitter = v.category ? v.x.map((x, i) => x + 0.25 * (((i * 0.618034) % 1) - 0.5)) : v.x;
  return figure({
    name: v.name,
    label: "Mean residual " + along + " against " + v.name + ": largest " + length(v.mean[most]) + " at " + where,
    caption: "residual " + along + "; explains " + percent(v.share) + " (" + ("p = " + pValue(v.p_value)).replace("= <", "<").replace(/ /g, "\u00a0") + ")",
    make: (c) => [[
      { x: jitter, y: v.y, mode: "markers", type: "scatter", marker: { size: 3, color: c.soft, opacity: 0.35 }, hoverinfo: "skip" },
      v.improved.some(known) ? { x: v.at, y: v.improved, mode: v.category ? "markers" : "lines", type: "scatter", line: { color: c.good, width: 1.5, dash: "dot" },
        marker: { color: c.good, symbol: "diamond-open", size: 9 }, hovertemplate: "with the named effects: %{y:.3g} " + kUnit + "<extra></extra>" } : null,
      { x: v.at, y: v.mean, mode: v.category || v.at.length < 3 ? "markers" : "lines+markers", type: "scatter", line: { color: c.accent, width: 1.5 },
        marker: { color: c.accent, size: 6 }, error_y: { type: "data", array: v.standard_error.map((e) => 2 * e), color: c.accent, thickness: 1.5, width: 3 },
        customdata: v.count.map((n, i) => [n, 2 * v.standard_error[i], v.category ? plain(v.labels[i]) : num(v.at[i]) + " " + unit]),
        hovertemplate: "%{customdata[2]}: %{y:.3g} ± %{customdata[1]:.2g} " + kUnit + " (%{customdata[0]} measurements)<extra></extra>" },
    ].filter(Boolean), {
      xaxis: Object.assign({ title: titled(v.category ? v.name : v.name + (unit ? ", " + unit : "")), zeroline: false },
        v.category ? { tickvals: v.at, ticktext: v.labels.map(plain), range: [-0.5, v.labels.length - 0.5] } : {}),
      yaxis: { title: titled("measured \u2212 model, " + kUnit), range: [-reach, reach] },
    }],
  });
}

function quantile(values, share) {
  const sorted = values.filter(known).sort((a, b) => a - b);
  return sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] : null;
}

function ledgerFigure(steps, noise, estimated) {
  const line = known(noise) && noise > 0;
  const values = steps.map((s) => s.held_out).concat(line ? [noise] : []);
  const log = Math.min(...values) * 20 < Math.max(...values);
  const from = Math.min(...values) / 3, to = Math.max(...values) * (log ? 6 : 1.35);
  return figure({
    height: 70 + steps.length * Math.max(46, 12 + 16 * Math.max(...steps.map((s) => wrapped(s.name, narrow() ? 22 : 36).split("<br>").length))), label: "Held-out RMS after each step of the ledger: " + steps.map((s) => s.name + " " + length(s.held_out)).join("; "),
    caption: "Held-out RMS after each step" + (log ? ", on a logarithmic scale" : "") + (!line ? "." : ". The dashed line is the " + (estimated ? "noise" : "repeatability") + ", " + length(noise) +
      (estimated ? ", estimated from what this model leaves: a better model may lower it." : ": no model can do better.")),
    make: (c) => [[{ type: "bar", orientation: "h", y: steps.map((s, i) => i), x: steps.map((s) => s.held_out), marker: { color: steps.map((s) => (s.proposed ? c.good : c.accent)), opacity: steps.map((s) => (s.proposed ? 0.6 : 0.9)) },
      hovertemplate: "%{customdata}<extra></extra>", customdata: steps.map((s) => plain(s.name) + ": " + rmsText(s.held_out)), error_x: { type: "data", array: steps.map((s) => 2 * stdOfAll(s.held_out) || 0), color: c.ink, thickness: 1, width: 4 } },
      { type: "scatter", mode: "text", x: steps.map((s) => s.held_out + (2 * stdOfAll(s.held_out) || 0)), y: steps.map((s, i) => i), text: steps.map((s) => " " + (narrow() ? length(s.held_out) : rmsText(s.held_out))), textposition: "middle right", cliponaxis: false, hoverinfo: "skip" }],
    { margin: { l: 20, r: 20, t: 8, b: 44 }, bargap: 0.35,
      yaxis: { tickvals: steps.map((s, i) => i), ticktext: steps.map((s) => wrapped(s.name, narrow() ? 22 : 36)), ticks: "outside", ticklen: 7, tickcolor: "rgba(0,0,0,0)", range: [steps.length - 0.4, -0.6], showgrid: false, zeroline: false },
      xaxis: Object.assign({ title: titled("held-out RMS, " + kUnit), zeroline: false, nticks: 6 }, log ? { type: "log", dtick: 1, tickformat: "~g", range: [Math.log10(from), Math.log10(to)] } : { range: [0, to] }),
      shapes: line ? [{ type: "line", yref: "paper", y0: 0, y1: 1, x0: noise, x1: noise, line: { color: c.warm, width: 1.5, dash: "dash" } }] : [] }],
  });
}

function wrapped(text, width) {
  const lines = [""];
  for (const word of String(text).split(" ")) {
    if (lines[lines.length - 1] && (lines[lines.length - 1] + " " + word).length > width) lines.push("");
    lines[lines.length - 1] += (lines[lines.length - 1] ? " " : "") + word;
  }
  return lines.map(plain).join("<br>");
}

/** What was measured against the variable of a profile: its own points, else those of the residual. */
function pointsOf(p) {
  if (p.x) return p;
  const same = (v) => v.direction === p.direction && v.unit === p.units[0] && (v.name === p.variables[0] || (v.name === "time" && p.variables[0] === "t"));
  return data.variables.find((v) => !v.category && same(v)) || { x: [], y: [] };
}

/** A smooth function of one variable with its band, or of two as a map. */
function profileFigure(p) {
  const n = p.variables.length, unit = unitText(p.unit);
  const points = p.curve.filter((point) => point.length === n + 2 && point.every(known));
  if (!points.length) return null;
  const named = p.variables.map((name, k) => variableName(name, p.units[k]));
  const axis = (k) => ({ title: titled(named[k] + (unitText(p.units[k]) ? ", " + unitText(p.units[k]) : "")), zeroline: false });
  const size = (point) => expanded(point[n], point[n + 1], p.unit);
  const at = (point) => named.map((name, k) => name + " " + withUnit(num(point[k]), p.units[k])).join(", ");
  const most = points.reduce((best, point) => (Math.abs(point[n]) > Math.abs(best[n]) ? point : best));
  const label = "Error against " + named.join(" and ") + ": largest " + size(most) + " at " + at(most);
  const hover = "%{text}<extra></extra>";
  if (n === 2) return profileMap(p, points, axis, label, (point) => plain(at(point) + ": " + size(point)), hover, unit);
  const measured = pointsOf(p);
  const x = points.map((point) => point[0]), edge = (side) => points.map((point) => point[1] + side * 2 * point[2]);
  return figure({
    label, kind: "tall", caption: measured.x.length ? "Curve with its expanded uncertainty (k = 2); grey: single measurements" + (p.x ? ", the curve and the residual that it leaves." : ", the residual without the curve.") : null,
    make: (c) => [[
      { x: measured.x, y: measured.y, mode: "markers", type: "scatter", marker: { size: 3, color: c.soft, opacity: 0.35 }, hoverinfo: "skip" },
      { x, y: edge(-1), mode: "lines", type: "scatter", line: { width: 0 }, hoverinfo: "skip" },
      { x, y: edge(1), mode: "lines", type: "scatter", line: { width: 0 }, fill: "tonexty", fillcolor: c.accent + "33", hoverinfo: "skip" },
      { x, y: points.map((point) => point[1]), mode: "lines", type: "scatter", line: { color: c.accent, width: 2 }, text: points.map((point) => plain(at(point) + ": " + size(point))), hovertemplate: hover },
    ], { xaxis: axis(0), yaxis: { title: titled("error, " + unit), zeroline: true } }],
  }).node;
}

function profileMap(p, points, axis, label, text, hovertemplate, unit) {
  const reach = Math.max(...points.map((point) => Math.abs(point[2])), 1e-9);
  const values = (k) => [...new Set(points.map((point) => point[k]))].sort((a, b) => a - b);
  const x = values(0), y = values(1), whole = x.length * y.length === points.length;
  const cell = new Map(points.map((point) => [point[0] + " " + point[1], point]));
  const rows = (what) => y.map((b) => x.map((a) => what(cell.get(a + " " + b))));
  const bar = (c) => ({ title: { text: unit }, thickness: 12, tickfont: { color: c.ink } });
  const bands = points.map((point) => 2 * point[3]), ends = (list) => [list[0], list[list.length - 1]];
  const least = num(Math.min(...bands), 2), most = num(Math.max(...bands), 2);
  return figure({
    label, kind: "tall", caption: "Expanded uncertainty (k = 2) " + (least === most ? "" : least + " to ") + most + " " + unit + ".",
    make: (c) => [[whole && x.length > 1 && y.length > 1 ?
      { type: "heatmap", x, y, z: rows((point) => point[2]), text: rows(text), hovertemplate, zmin: -reach, zmax: reach, colorscale: kScale, colorbar: bar(c), zsmooth: "best" } :
      { type: "scatter", mode: "markers", x: points.map((point) => point[0]), y: points.map((point) => point[1]), text: points.map(text), hovertemplate,
        marker: { size: 9, color: points.map((point) => point[2]), cmin: -reach, cmax: reach, colorscale: kScale, showscale: true, colorbar: bar(c) } }],
    { xaxis: Object.assign(axis(0), x.length > 1 ? { range: ends(x) } : {}), yaxis: Object.assign(axis(1), y.length > 1 ? { range: ends(y) } : {}) }],
  }).node;
}

function curveFigure(curve) {
  const unit = unitText(curve.unit), last = curve.rms[curve.rms.length - 1];
  return figure({
    name: curve.name, kind: "tall", label: "Convergence of the genetic algorithm: RMS " + num(curve.rms[0]) + " " + unit + " at first, " + num(last) + " " + unit + " after " + curve.generation[curve.generation.length - 1] + " generations",
    caption: "Best RMS " + num(curve.rms[0]) + " " + unit + " → " + num(last) + " " + unit + " in " + curve.generation[curve.generation.length - 1] + " generations",
    make: (c) => [[{ x: curve.generation, y: curve.rms, mode: "lines", type: "scatter", line: { color: c.accent, width: 2, shape: "hv" }, hovertemplate: "generation %{x}: %{y:.4g} " + unit + "<extra></extra>" }],
      { xaxis: { title: titled("generation"), zeroline: false }, yaxis: { title: titled("best RMS, " + unit + " (logarithmic)"), type: "log" } }],
  });
}

function positioningFigure(axis, part, name) {
  const test = axis[part], unit = unitText(axis.unit), runs = part === "measured" ? axis.y : axis.left;
  const band = (mean, s, c) => ({ x: test.at, y: mean, error_y: { type: "data", array: s.map((v) => (known(v) ? 2 * v : 0)), color: c, thickness: 1, width: 4 } });
  const dots = (up) => runs.map((y, i) => (axis.up[i] === up ? y : null));
  return figure({
    name, kind: "tall", label: name + ", axis " + axis.name + ": bi-directional accuracy A " + num(test.figures.A) + " " + unit + ", reversal B " + num(test.figures.B) + " " + unit,
    caption: "Means of the runs; the bars are ± 2 s. Dots: single runs.",
    make: (c) => [[
      { x: axis.x, y: dots(1), mode: "markers", type: "scatter", marker: { size: 4, color: c.accent, opacity: 0.45 }, hoverinfo: "skip", showlegend: false },
      { x: axis.x, y: dots(0), mode: "markers", type: "scatter", marker: { size: 4, color: c.warm, opacity: 0.45 }, hoverinfo: "skip", showlegend: false },
      Object.assign(band(test.forward, test.s_forward, c.accent), { name: "forward ↑", mode: "lines+markers", type: "scatter", line: { color: c.accent }, marker: { symbol: "triangle-up", size: 8 }, hovertemplate: "↑ %{x:.4g}: %{y:.3g} " + unit + "<extra></extra>" }),
      Object.assign(band(test.backward, test.s_backward, c.warm), { name: "backward ↓", mode: "lines+markers", type: "scatter", line: { color: c.warm, dash: "dash" }, marker: { symbol: "triangle-down", size: 8 }, hovertemplate: "↓ %{x:.4g}: %{y:.3g} " + unit + "<extra></extra>" }),
    ], { showlegend: true, legend: { orientation: "h", y: 1.12, x: 0 }, margin: { l: 56, r: 12, t: 28, b: 40 },
      xaxis: { title: titled("position of " + axis.axis + ", " + unitText(axis.position_unit)), zeroline: false }, yaxis: { title: titled("deviation, " + unit) } }],
  });
}

/** Both ways round a circle, the radial deviation drawn large about the nominal circle. */
function circleFigure(circle, part, name) {
  const paths = [["counter_clockwise", "counter-clockwise ↺", "accent", "solid"], ["clockwise", "clockwise ↻", "warm", "dash"]].filter(([key]) => circle[part][key]);
  const all = paths.flatMap(([key]) => circle[part][key].F_um).concat([0]);
  const low = Math.min(...all), high = Math.max(...all), span = high - low || 1;
  const shown = paths.map(([key, text]) => "G " + num(circle[part][key].G) + " µm " + text);
  return figure({
    name, kind: "tall", label: name + ", plane " + circle.first + circle.second + ": " + shown.join(", "),
    caption: "Radial deviation F in µm; the thin circle is the nominal one (" + num(circle.radius_mm, 4) + " mm). " + circle.first + " to the right.",
    make: (c) => [paths.map(([key, text, tint, dash]) => {
      const path = circle[part][key];
      return { type: "scatterpolar", mode: "lines", name: text, theta: path.angle_deg.concat(path.angle_deg[0]), r: path.F_um.concat(path.F_um[0]), line: { color: c[tint], width: 1.5, dash },
        hovertemplate: "%{theta:.1f}°: %{r:.3g} µm<extra>" + text + "</extra>" };
    }).concat([{ type: "scatterpolar", mode: "lines", theta: Array.from({ length: 121 }, (x, i) => 3 * i), r: Array(121).fill(0), line: { color: c.soft, width: 1 }, hoverinfo: "skip", showlegend: false }]),
    { showlegend: true, legend: { orientation: "h", y: 1.22, x: 0 }, margin: { l: 44, r: 36, t: 56, b: 24 },
      polar: { bgcolor: "rgba(0,0,0,0)", angularaxis: { gridcolor: c.line, linecolor: c.line, dtick: 45 }, radialaxis: { gridcolor: c.line, linecolor: c.line, range: [low - 0.8 * span, high + 0.1 * span], angle: 22.5, nticks: 5, tickfont: { size: 10 } } } }],
  });
}

/** Displacement against time, the temperatures below it; both parts on one scale. */
function thermalFigure(test, part, name, temperatures) {
  const unit = unitText(test.unit), all = test.courses.flatMap((c) => c.measured.concat(c.left)).filter(known);
  const low = Math.min(...all), high = Math.max(...all), room = 0.05 * (high - low) || 1;
  const directions = [...new Set(test.courses.map((c) => c.direction))], places = [...new Set(test.courses.map((c) => c.at))];
  const warm = temperatures.length > 0, tints = ["accent", "warm", "good", "soft"], dashes = ["solid", "dash", "dot", "dashdot"];
  // several directions: a colour each, a dash for each place; one direction: a colour for each place
  const look = (c) => (c.between ? ["ink", "dashdot"] : directions.length > 1 ? [tints[directions.indexOf(c.direction) % 4], dashes[places.indexOf(c.at) % 4]] :
    [tints[places.indexOf(c.at) % 4], dashes[places.indexOf(c.at) % 4]]);
  const range = (c) => c.name + " " + num(c[part + "_figures"].range.value) + " " + unit;
  return figure({
    name, height: warm ? 500 : 360, label: name + ", range of the displacement: " + test.courses.map(range).join(", "),
    caption: (test.kind === "spindle" ? "Shaded: the spindle turns. " : "") + (warm ? "Below: temperatures." : "No temperature was recorded."),
    make: (c) => [test.courses.map((course) => ({ x: course.hours, y: course[part], mode: course.hours.length > 30 ? "lines" : "lines+markers", type: "scatter", name: plain(said(course.name)),
      line: { color: c[look(course)[0]], width: 1.5, dash: look(course)[1] }, marker: { size: 4, color: c[look(course)[0]] },
      hovertemplate: "%{x:.3g} h: %{y:.3g} " + unit + "<extra>" + plain(said(course.name)) + "</extra>" }))
      .concat(temperatures.map((t, i) => ({ x: t.hours, y: t.temperature, yaxis: "y2", mode: "lines", type: "scatter", name: plain(t.sensor) + ", °C",
        line: { width: 1.2, color: c[tints[i % 4]], dash: dashes[Math.floor(i / 4) % 4] }, hovertemplate: "%{x:.3g} h: %{y:.4g} °C<extra>" + plain(t.sensor) + "</extra>" }))),
    Object.assign({ showlegend: true, legend: { orientation: "h", y: warm ? -0.14 : -0.2, x: 0 }, margin: { l: 56, r: 12, t: 8, b: 40 },
      shapes: test.kind === "spindle" ? [{ type: "rect", xref: "x", yref: "paper", x0: test.heated_hours[0], x1: test.heated_hours[1], y0: 0, y1: 1, fillcolor: c.warm, opacity: 0.08, line: { width: 0 } }] : [],
      xaxis: { title: titled("time, h"), zeroline: false, range: test.hours, anchor: warm ? "y2" : "y" },
      yaxis: { title: titled("displacement, " + unit), range: [low - room, high + room], domain: warm ? [0.4, 1] : [0, 1] } },
    warm ? { yaxis2: { title: titled("°C"), zeroline: false, domain: [0, 0.32] } } : {})],
  });
}

/** Error motions of an axis of rotation by its angle, drawn large about a circle. */
function rotationFigure(motion, joint, name) {
  const all = motion.radial_um.concat(motion.axial_um), low = Math.min(...all), span = Math.max(...all) - low || 1;
  const parts = [["radial_um", "radial", "accent", "solid"], ["axial_um", "axial", "warm", "dash"]];
  return figure({
    name, kind: "tall", label: name + ", axis " + joint + ": radial error motion " + num(motion.radial_error_um) + " µm, axial " + num(motion.axial_error_um) + " µm",
    caption: "Error motion in µm against the reading of " + joint + "; lines through the means of each angle.",
    make: (c) => [parts.flatMap(([key, text, tint, dash]) => {
      const at = new Map(); // readings of each angle: the line goes through their means
      motion.angle_deg.forEach((angle, i) => { const place = angle.toFixed(1); at.set(place, [...(at.get(place) || []), motion[key][i]]); });
      return [{ type: "scatterpolar", mode: "markers", theta: motion.angle_deg, r: motion[key], marker: { size: 4, color: c[tint], opacity: 0.5 }, showlegend: false, hovertemplate: "%{theta:.1f}°: %{r:.3g} µm<extra>" + text + "</extra>" },
        { type: "scatterpolar", mode: "lines", name: text, theta: [...at.keys()].map(Number), r: [...at.values()].map((all) => all.reduce((a, b) => a + b) / all.length), line: { color: c[tint], width: 1.5, dash }, hoverinfo: "skip" }];
    }),
    { showlegend: true, legend: { orientation: "h", y: 1.22, x: 0 }, margin: { l: 30, r: 30, t: 56, b: 24 },
      polar: { bgcolor: "rgba(0,0,0,0)", angularaxis: { gridcolor: c.line, linecolor: c.line, dtick: 45 }, radialaxis: { gridcolor: c.line, linecolor: c.line, range: [low - 0.8 * span, low + 1.1 * span], angle: 22.5, nticks: 5, tickfont: { size: 10 } } } }],
  });
}

/** Errors of lengths against the length, a colour for each line. */
function lengthsFigure(tests, key, name) {
  const all = tests.flatMap((t) => t.E_um.concat(t.left_um)).filter(known).concat(0);
  const low = Math.min(...all), high = Math.max(...all), room = 0.08 * (high - low) || 1;
  return figure({
    name, kind: "tall", label: name + ": " + tests.map((t) => t.name + ", largest " + num(key === "E_um" ? t.largest_um : t.largest_left_um) + " µm").join("; "),
    caption: "One mark a length measured" + (data.calibration ? "; both figures have the same scale." : "."),
    make: (c) => [tests.map((t, i) => ({ x: t.length_mm, y: t[key], mode: "markers", type: "scatter", name: plain(t.name), marker: { size: 7, color: c[["accent", "warm", "good", "soft"][i % 4]], symbol: ["circle", "square", "diamond", "cross"][Math.floor(i / 4) % 4] },
      hovertemplate: "%{x:.5g} mm: %{y:.3g} µm<extra>" + plain(t.name) + "</extra>" })),
    { showlegend: true, legend: { orientation: "h", y: -0.2, x: 0 }, margin: { l: 56, r: 12, t: 8, b: 40 },
      xaxis: { title: titled("length, mm"), zeroline: false }, yaxis: { title: titled("E, µm"), range: [low - room, high + room] } }],
  });
}
