// The page, section by section.

const kNoise = { declared: "declared", repeated: "from repeated measurements", estimated: "estimated from the residuals" };
const main = document.getElementById("report");
const contents = el("ul", {});
const short = (value) => minus(String(Number(value.toPrecision(4))));
const fileName = (path) => path.split("/").pop();

const present = (children) => children.flat(9).filter((x) => x !== null && x !== undefined);
function section(id, title, ...children) {
  contents.append(el("li", {}, el("a", { href: "#" + id }, title)));
  main.append(el("section", { "aria-labelledby": id }, el("h2", { id }, title), ...present(children)));
}
/** A section that explains nothing here, behind its heading; `why` says so in words. */
function foldedSection(id, title, why, ...children) {
  const box = el("details", { class: "fold", "aria-labelledby": id }, el("summary", {}, el("h2", { id }, title), el("span", { class: "note" }, why)), ...present(children));
  const link = el("a", { href: "#" + id }, title);
  link.addEventListener("click", () => { box.open = true; });
  contents.append(el("li", { class: "quiet" }, link));
  main.append(box);
}
/** Open where `explains`, else folded. */
const sectionIf = (explains, id, title, why, ...children) => (explains ? section(id, title, ...children) : foldedSection(id, title, why, ...children));
const lead = (text) => el("p", { class: "lead" }, text);

function commandLine(lead, command) {
  if (!command) return null;
  const button = el("button", { type: "button" }, "Copy");
  button.addEventListener("click", () => {
    const done = () => { button.textContent = "Copied"; setTimeout(() => (button.textContent = "Copy"), 1500); };
    const select = () => getSelection().selectAllChildren(code);
    if (navigator.clipboard) navigator.clipboard.writeText(command).then(done, select);
    else select();
  });
  const code = el("code", {}, command);
  return [el("p", { class: "lead" }, lead), el("div", { class: "command" }, code, button)];
}

/** What to type next: where effects are not separated, the moves first. */
function commands() {
  const measure = diagnosis.verdict === "confusable" && diagnosis.next_measurement.length > 0;
  const several = diagnosis.missing.length + diagnosis.profiles.length > 1;
  return [measure ? commandLine("Next, write a plan of the moves and measure it:", data.moves_command) : null,
    commandLine(measure ? "Or, without measuring, add the most probable:" : several ? "Type next (it adds the first; then diagnose again):" : "Type next:", data.command)];
}

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);
const sentences = (text) => text.split(/(?<=\.) (?=[A-Z])/);

/** The one picture: how the error fell, else the deviations of a positioning run. */
function picture() {
  const steps = ledgerSteps();
  if (steps.length > 1) return ledgerFigure(steps, data.noise, diagnosis.repeatability_from === "estimated").node;
  if (data.circles.length) return circleFigure(data.circles[0], "measured", "Circle in " + data.circles[0].first + data.circles[0].second).node;
  if (data.positioning.length) return positioningFigure(data.positioning[0], "measured", "Deviation of " + data.positioning[0].name).node;
  return data.variables.length ? variableFigure(data.variables[0]).node : null;
}

/** What to do where there is nothing to type. */
function advice() {
  const drift = diagnosis.drift.length ? " " + capital(said(diagnosis.drift[0].to_do)) + "." : "";
  return { question: "Answer it, then diagnose again.", insufficient_data: "Measure more, or take effects out of the model.", explained: "Nothing to add: only noise is left." + drift,
    scatter: "Touch one point twenty times, then diagnose again with their standard deviation as --repeatability-um." + drift,
    unknown_effect: "Look for the cause in the figures below.", confusable: diagnosis.next_measurement.length ? "Measure the listed moves." : "Measure what would separate them, as stated below for each." }[diagnosis.verdict] || "";
}

function facts() {
  const calibration = data.calibration ? fileName(data.calibration) + (data.calibration_id ? " (" + data.calibration_id + ")" : "") + (data.method ? ", found by " + data.method.replace(/_/g, " ") + ", seed " + data.seed : "") : "none";
  return el("dl", { class: "facts" }, [["Session", fileName(data.session)], ["Machine", fileName(data.machine)], ["Serial number", data.serial], ["Operator", data.operator], ["Measured", data.measured ? clock(data.measured) : null], ["Measurements", diagnosis.observations],
    ["Calibration", calibration], ["Report of", clock(data.created)]].filter(([, value]) => value).map(([name, value]) => el("div", {}, el("dt", {}, name), el("dd", {}, String(value)))));
}

function warnings() {
  const all = [data.session_warning ? "The session: " + data.session_warning : null,
    data.same_session === false ? "This session is not the one that the calibration was made from: the row “values held” shows whether it is still valid." : null,
    data.left_out ? data.left_out + " measurements lack an input of the model and were left out." : null];
  return all.filter(Boolean).map((text) => el("p", { class: "warning" }, text));
}

const navigation = () => el("nav", { "aria-label": "Sections" }, contents);

/** Without a calibration: the machine as it is, and which tests its session is. */
function headerAsItIs() {
  const tests = data.tests.map((t) => el("li", {}, t.in_words));
  main.replaceChildren(el("header", {}, el("h1", {}, data.title),
    el("div", { class: "verdict" }, el("div", { class: "badge" }, "The machine as it is"), el("p", { class: "sentence" }, "No calibration was given: figures and residuals are those of the nominal machine."),
      tests.length ? el("ul", { class: "plain" }, tests) : null)), ...warnings(), facts(), navigation());
}

function header() {
  const [first, ...rest] = sentences(said(diagnosis.sentence));
  const next = present([commands()]);
  const todo = next.length ? "" : advice();
  main.replaceChildren(el("header", {}, el("h1", {}, data.title),
    el("div", { class: "verdict " + diagnosis.verdict }, el("div", { class: "badge" }, kVerdicts[diagnosis.verdict] || diagnosis.verdict),
      el("p", { class: "sentence" }, first), rest.filter((one) => !todo.startsWith(one)).map((one) => el("p", {}, one)))));
  const shown = picture();
  if (shown) main.append(el("div", { class: "lead-picture" }, shown));
  main.append(el("section", { class: "next", "aria-labelledby": "step" }, el("h2", { id: "step" }, "Next step"), next.length ? next : el("p", {}, todo)));
  main.append(...warnings(), facts(), navigation());
}

/** Figures in boxes: [label, value, its standard uncertainty, unit, notes …]. */
const tileBoxes = (tiles) => el("div", { class: "tiles" }, tiles.map(([label, value, std, unit, ...notes]) => el("div", { class: "tile" }, el("div", { class: "label" }, label), el("div", { class: "value" }, num(value), " ", el("small", {}, known(value) ? unit : "")),
  [known(std) && std > 0 ? "± " + digits(2 * std, 2) + " " + unit + " (k = 2)" : null, ...notes].filter(Boolean).map((note) => el("div", { class: "label" }, note)))));

function errors() {
  if (!data.figures.length) return;
  const held = (f) => f["held_out_rms" + kSuffix];
  const tiles = data.figures.filter((f) => !/values held/.test(f.name)).map((f) => [f.name + ": held-out RMS", held(f), rmsStd(held(f), f["count" + kSuffix])]);
  const estimated = diagnosis.repeatability_from === "estimated", found = known(diagnosis["noise" + kSuffix]);
  if (!estimated || !found) tiles.push([(estimated ? "Noise of one measurement, " : "Repeatability, ") + (kNoise[diagnosis.repeatability_from] || ""), data.noise]);
  if (found) tiles.push(["Noise found", diagnosis["noise" + kSuffix], diagnosis["noise_std" + kSuffix]]);
  const kinds = [["um", "_um"], ["arcsec", "_arcsec"]].filter(([, suffix]) => data.figures.some((f) => known(f["rms" + suffix])));
  const columns = [["Model", "text"]];
  for (const [unit] of kinds) for (const name of ["RMS", "held-out RMS", "95 % below", "largest"]) columns.push([name + ", " + unitText(unit), "n"]);
  columns.push(["χ²/ν", "n"], ["outliers", "n"]);
  section("error", data.calibration ? "The error, before and after" : "Residuals of the nominal machine", tileBoxes(tiles.map(([label, value, std]) => [label, value, std, kUnit])),
  table("Size of the residuals without outliers (each fit excludes its own). Held out: parameters refitted without the block of time that is evaluated, no drift predicted. ± is the expanded uncertainty, k = 2", columns, data.figures.map((f) => [[f.name, el("div", { class: "note" }, f.note)],
    ...kinds.flatMap(([, s]) => [bare(f["rms" + s], f["rms_std" + s]), bare(f["held_out_rms" + s], rmsStd(f["held_out_rms" + s], f["count" + s])), bare(f["q95" + s], 0.95 * f["q95" + s] / Math.sqrt(f["count" + s])), num(f["max" + s])]),
    diagnosis.repeatability_from === "estimated" ? "–" : bare(f.chi2_per_dof, f.chi2_per_dof * Math.sqrt(2 / Math.max(1, f.degrees_of_freedom))), known(f.outliers) ? String(f.outliers) : "–"])));
}

function entry(term, ...content) {
  return content.flat().some((x) => x) ? [el("dt", {}, term), el("dd", {}, ...content)] : [];
}
/** An error before and after. */
const fall = (pair) => (pair ? bareRms(pair[0]) + " → " + bareRms(pair[1]) : "–");
const arrow = (pair) => bareRms(pair[0]) + " → " + rmsText(pair[1]);
/** Size of an effect, RMS over the measurements: it can only be known to the noise of so many. */
const sizeStd = (heldOut) => (heldOut && known(heldOut[1]) && data.residuals ? heldOut[1] / Math.sqrt(data.residuals) : null);

/** A parameter with its expanded uncertainty. */
const sized = (p) => p.name + " = " + expanded(p.value, p.std, p.unit);
const heldOut = (found) => found["held_out_rms" + kSuffix];

/** Other explanations of what was found, each with its odds and with what would tell. */
function rivals(m) {
  const lines = m.confusable_with.map((c) => [el("b", {}, withSymbol(c)), rivalText(c),
    c.moves ? el("div", { class: "note" }, "To separate them: " + said(c.moves)) : null]);
  return lines.length ? [el("dt", {}, "Or instead"), el("dd", {}, el("ul", { class: "plain" }, lines.map((line) => el("li", {}, line))))] : [];
}

function foundCard(m, title) {
  return el("div", { class: "card" }, el("h3", {}, title), el("dl", {},
    entry("Size", m.parameters.map((p) => foundSize(p, expanded)).join(", ")),
    entry("Odds", m.odds_in_words),
    entry("Share of the error", known(m["size" + kSuffix]) && m["size" + kSuffix] > 0 ? plusMinus(m["size" + kSuffix], sizeStd(heldOut(m)), data.unit) + " RMS" + (diagnosis.repeatability_from === "estimated" || !(data.noise > 0) ? "" : ", " + num(m["size" + kSuffix] / data.noise, 2) + " × the repeatability") : ""),
    entry("Held-out RMS", arrow(heldOut(m))),
    rivals(m), entry("Looks the same", m.looks_the_same), entry("Cause", m.cause), entry("Remedy", m.remedy)));
}

function missing() {
  const named = diagnosis.missing.filter((m) => !m.one_of_several), several = diagnosis.missing.filter((m) => m.one_of_several);
  if (named.length) section("missing", "What is missing", lead("In the order found; sizes after refitting everything together."), named.map((m, i) => foundCard(m, i + 1 + ". " + withSymbol(m))));
  if (several.length) section("several", "One of several acts", lead("These data do not tell which; the most probable first, its rivals with their odds."), several.map((m) => foundCard(m, withSymbol(m))));
  if (diagnosis.possible.length) section("possible", "Not established, and not excluded", diagnosis.possible.map((p) => el("p", {}, el("b", {}, withSymbol(p)), ", odds " + p.odds_in_words + (p.shown_by ? "; would show it: " + said(p.shown_by) : ""))));
}

function unexplained() {
  if (!diagnosis.profiles.length && !diagnosis.formulas.length) return;
  const values = (type) => data.added.filter((a) => a.effect.type === type).flatMap((a) => a.values.map(sized)).join(", ");
  section("unexplained", "What no effect of the catalogue explains", diagnosis.profiles.length ? lead("A smooth function of recorded variables. The band is the expanded uncertainty (k = 2).") : null,
    diagnosis.profiles.map((p) => el("div", { class: "card" }, el("h3", {}, p.direction === "approach" ? "Along the approach" : (p.unit === "arcsec" ? "Of " : "Along ") + p.direction, ", over " + p.variables.map((name, k) => variableName(name, p.units[k])).join(" and ")),
      el("dl", {}, entry("Odds", p.odds_in_words), entry("Held-out RMS", arrow(heldOut(p)))), profileFigure(p))),
    diagnosis.formulas.map((f) => el("div", { class: "card" }, el("h3", {}, "The same as a formula, along " + f.direction), el("p", {}, el("code", {}, f.formula)),
      el("dl", {}, entry("Values", values("formula")), entry("Held-out RMS", arrow(heldOut(f))),
        entry("Units", "linear joints in mm, rotary in rad, t in s, speeds in mm/s, temperatures in °C; the value in µm (arcsec along a rotary joint)")))));
}

/** What is left beside noise: drift, and an artifact that is not quite as its file says. */
function left() {
  if (!diagnosis.drift.length && !diagnosis.artifact_scatter.length) return;
  const size = (d) => (known(d.std_arcsec) ? withUnit(num(d.std_arcsec), "arcsec") : withUnit(num(d.std_um), "um"));
  const perhaps = (d) => d.perhaps.map((o) => el("div", {}, withSymbol(o) + ", odds " + o.odds_in_words + (known(o.share) ? "; it would explain " + percent(o.share) + " of the drift" : "")));
  section("left", "Drift and scatter", diagnosis.drift.map((d) => el("div", { class: "card" }, el("h3", {}, "Drift " + (d.direction === "approach" ? "along the approach" : "of " + d.direction)), el("dl", {},
    entry("Size", size(d) + " RMS"), entry("Time constant", known(d.time_constant_s) && d.time_constant_s > 0 ? duration(d.time_constant_s) : ""), entry("Perhaps", ...perhaps(d)), entry("To do", said(d.to_do))))),
    diagnosis.artifact_scatter.length ? el("div", { class: "card" }, el("h3", {}, "Scatter of places"), el("dl", {},
      diagnosis.artifact_scatter.map((a) => entry(a.what, size(a) + " RMS" + (a.in_words ? ": " + said(a.in_words) : ""))))) : null);
}

/** A share of variance, ± the standard error of R². */
function sharePercent(share) {
  const std = known(share) && data.residuals ? (2 * Math.sqrt(Math.max(0, share)) * (1 - share)) / Math.sqrt(data.residuals) : null;
  return known(std) && std > 5e-4 ? (100 * share).toFixed(1) + " ± " + (200 * std).toFixed(1) + " %" : percent(share, 1);
}

function where() {
  if (!diagnosis.where.length) return;
  const rows = diagnosis.where.map((w) => Object.assign([w.variable, [meter(w.share), sharePercent(w.share)], pValue(w.p_value), sharePercent(w.share_beside), pValue(w.p_value_beside)], { chosen: w.p_value_beside < 0.01 }));
  sectionIf(diagnosis.where.some((w) => w.p_value < 0.01), "where", data.calibration ? "Where the model fails" : "Where the nominal machine fails", "no variable explains the residuals", lead("Share of what is left that one variable explains, in any direction: alone, and of what those above it leave. p: probability of so much by chance in the noise that was found, corrected for the number of variables; bold where it is below 0.01 beside those above."),
    longTable("Variables, largest share first", [["Variable"], ["Share alone", "nowrap"], ["p", "n"], ["beside those above", "n"], ["p", "n"]], rows, 12));
}

function variables() {
  if (!data.variables.length) return;
  const improved = data.variables.some((v) => v.improved.some(known));
  const figures = (views) => el("div", { class: "grid" }, views.map((v) => variableFigure(v).node));
  const [explaining, others] = [data.variables.filter((v) => v.p_value < 0.01), data.variables.filter((v) => !(v.p_value < 0.01))];
  const text = lead("Residual along the direction in which the variable explains most: deviation (actual \u2212 indicated) as measured minus that of the model, which is what the model would have to add. Mean of each bin with its expanded uncertainty (blue), single measurements (grey, thinned)" +
      (improved ? ", and the means with the named effects added (green)" : "") + ". The fit has absorbed part of the missing effect, so the effect is larger than it appears here.");
  if (!explaining.length) foldedSection("variables", "Residual against each variable", "none of " + others.length + " explains anything", text, figures(others));
  else section("variables", "Residual against each variable", text, figures(explaining),
    others.length ? el("details", {}, el("summary", {}, others.length + (others.length === 1 ? " variable that explains nothing" : " variables that explain nothing")), figures(others)) : null);
}

function space() {
  if (data.vectors) sectionIf(data.added.length > 0, "space", "Residuals in space", "no effect is named that they could show", spaceSection(data.vectors));
}

const kPositioning = [["A", "Accuracy A, bi-directional"], ["A_forward", "Accuracy A↑"], ["A_backward", "Accuracy A↓"],
  ["R", "Repeatability R, bi-directional"], ["R_forward", "Repeatability R↑"], ["R_backward", "Repeatability R↓"],
  ["E", "Systematic deviation E, bi-directional"], ["E_forward", "Systematic deviation E↑"], ["E_backward", "Systematic deviation E↓"],
  ["M", "Range of the mean bi-directional deviation M"], ["B", "Reversal error B (largest amount)"], ["B_mean", "Mean reversal error B̄ (forward − backward)"]];

/** Each target of a positioning test, behind a line that opens. */
function targetsOf(a, heading = "Each target: nominal and actual position") {
  const m = a.measured, unit = unitText(a.unit), place = (x) => minus(x.toFixed(4)), micro = a.unit === "um" ? 1e-3 : 1 / 3600;
  const cell = (x) => (known(x) ? minus(x.toFixed(2)) : "–");
  return el("details", {}, el("summary", {}, heading), table("Mean actual position, mean deviation x̄, standard deviation s of the runs, reversal error B, as measured",
      [["Target, " + unitText(a.position_unit), "n"], ["actual ↑", "n"], ["actual ↓", "n"], ["x̄↑, " + unit, "n"], ["x̄↓, " + unit, "n"], ["s↑, " + unit, "n"], ["s↓, " + unit, "n"], ["B, " + unit, "n"], ["runs ↑ / ↓", "n"]],
      m.at.map((x, i) => [place(x), known(m.forward[i]) ? place(x + micro * m.forward[i]) : "–", known(m.backward[i]) ? place(x + micro * m.backward[i]) : "–", cell(m.forward[i]), cell(m.backward[i]),
        cell(m.s_forward[i]), cell(m.s_backward[i]), known(m.forward[i]) && known(m.backward[i]) ? cell(m.forward[i] - m.backward[i]) : "–", m.runs[i].join(" / ")])));
}

/** Pictures and tables of the positioning of one axis. */
function positioningTest(a, heading) {
  const m = a.measured, unit = unitText(a.unit), counts = m.runs.flat().filter((n) => n > 0);
  const most = Math.max(...counts), least = Math.min(...counts);
  const remarks = (least < 5 || m.at.length < 5 ? ". The standard asks for at least five targets and five runs in each direction" : "") + (a.travel_assumed ? ". The direction of approach was not recorded: it was assumed " + a.travel_assumed : "");
  return [el("h3", {}, heading), pair((part, name) => positioningFigure(a, part, name).node, "calibrated"),
    table(heading + ", " + m.at.length + " targets, " + (least === most ? least : least + " to " + most) + " runs in each direction" + remarks,
      measuredAndLeft([["Figure"]], unit), kPositioning.map(([key, name]) => [name, ...leftToo(bare(m.figures[key], m.std[key]), bare(a.calibrated.figures[key], a.calibrated.std[key]))])),
targetsOf(a)];
}

// What the model leaves is shown where there is a calibration: of the nominal machine it is what was measured.
const leftToo = (measured, left) => (data.calibration ? [measured, left] : [measured]);
const measuredAndLeft = (first, unit) => [...first, ...leftToo(["as measured, " + unit, "n"], ["left by the model, " + unit, "n"])];
/** A figure as measured, and beside it what the model leaves. */
const pair = (make, left) => el("div", { class: "pair" }, leftToo([make("measured", "As measured")], [make(left, "What the model leaves")]));
const asLeft = (text) => (data.calibration ? " What the model leaves is " + text : "");

function positioning() {
  if (!data.positioning.length) return;
  section("positioning", "Positioning by ISO 230-2", lead("Deviations (actual minus target position) found by an independent instrument, by target and direction of approach; figures as ISO 230-2:2014 defines them, with its coverage factor of 2 on s. Every run counts. ± is their expanded uncertainty (k = 2) from the scatter of the runs alone, without that of the instrument, its alignment and the temperatures." + asLeft("the deviation that a corrected machine would still have.")),
    data.positioning.map((a) => positioningTest(a, "Axis " + a.name)));
}

/** "+x−y" of a direction in the machine's volume. */
const signed = (name) => name.replace(/-(?=[a-z])/g, "−");

function diagonals() {
  if (!data.diagonals.length) return;
  for (const a of data.diagonals) [a.axis, a.name] = [signed(a.axis), signed(a.name)];
  const largest = data.diagonals.reduce((most, a) => (a.measured.figures.E > most.measured.figures.E ? a : most));
  const columns = [["E", "E"], ["E_forward", "E↑"], ["E_backward", "E↓"], ["R", "R"], ["B", "B"], ["B_mean", "mean B̄"]], text = (part, key) => bare(part.figures[key], part.std[key]);
  const cell = (a, key) => [text(a.measured, key), data.calibration ? el("div", { class: "note" }, "left " + text(a.calibrated, key)) : null];
  const tile = (a, label) => [label, a.measured.figures.E, a.measured.std.E, "µm", data.calibration ? "left by the model: " + bare(a.calibrated.figures.E, a.calibrated.std.E) + " µm" : null];
  section("diagonals", "Diagonal displacements by ISO 230-6", lead("Displacement along each diagonal found by an independent instrument, actual minus indicated, from the first reading; figures as those of ISO 230-2. E is the bi-directional systematic deviation of the diagonal displacement. Diagonals of different E tell of axes that are not square, or of different scales. ± is the expanded uncertainty (k = 2) from the scatter of the runs alone."),
    tileBoxes([...data.diagonals.map((a) => tile(a, "E of " + a.name)), ...(data.diagonals.length > 1 ? [tile(largest, "Largest E (" + largest.name + ")")] : [])]),
    table("Each diagonal, µm" + (data.calibration ? ", as measured and as the model leaves it" : ""), [["Diagonal"], ...columns.map(([, name]) => [name, "n"])], data.diagonals.map((a) => [a.name, ...columns.map(([key]) => cell(a, key))])),
    data.calibration ? data.diagonals.map((a) => [el("h3", {}, "Diagonal " + a.name), pair((part, name) => positioningFigure(a, part, name).node, "calibrated"), targetsOf(a)]) :
      [el("div", { class: "pair" }, data.diagonals.map((a) => positioningFigure(a, "measured", "Diagonal " + a.name).node)), data.diagonals.map((a) => targetsOf(a, "Targets of the diagonal " + a.name))]);
}

function rotations() {
  if (!data.rotations.length) return;
  section("rotation", "Axes of rotation by ISO 230-7", lead("Radial error motion about the centre of the least-squares circle and axial error motion from the plane through the positions that an independent instrument found while nothing but the axis turned. Where the axis stands and how it is tilted does not count. Ranges of single points, so noise is in them."),
    data.rotations.map((r) => [el("h3", {}, "Axis " + r.joint + (r.setup && r.setup !== r.joint ? ", setup " + r.setup : "")), pair((part, name) => (r[part] ? rotationFigure(r[part], r.joint, name).node : null), "left"),
      table("Axis " + r.joint + ", circle of " + num(r.measured.radius_mm, 5) + " mm radius, " + r.measured.angle_deg.length + " readings", measuredAndLeft([["Figure"]], "µm"),
        [["Radial error motion", "radial_error_um"], ["Axial error motion", "axial_error_um"]].map(([name, key]) => [name, ...leftToo(num(r.measured[key]), num(r.left && r.left[key]))]))]));
}

function lengths() {
  if (!data.lengths.length) return;
  for (const t of data.lengths) t.name = signed(t.name);
  section("lengths", "Length measurement errors by ISO 10360-2", lead("E: error of a length, indicated minus actual, its faces reached from opposite sides."),
    pair((key, name) => lengthsFigure(data.lengths, key === "measured" ? "E_um" : key, name).node, "left_um"),
    table("Largest amount of E of each line", [["Line"], ["lengths", "n"], ["errors", "n"], ...measuredAndLeft([], "µm")], data.lengths.map((t) => [t.name, String(t.lengths), String(t.E_um.length), ...leftToo(num(t.largest_um), num(t.largest_left_um))])));
}

function circles() {
  if (!data.circles.length) return;
  const way = (sense, key) => (f) => (f[sense] ? f[sense][key] : null);
  const rows = [["Circular deviation G↺", way("counter_clockwise", "G")], ["Circular deviation G↻", way("clockwise", "G")], ["Bi-directional circular deviation G(b)", (f) => f.G_both],
    ["Radial deviation F↺, largest", way("counter_clockwise", "F_max")], ["Radial deviation F↺, smallest", way("counter_clockwise", "F_min")],
    ["Radial deviation F↻, largest", way("clockwise", "F_max")], ["Radial deviation F↻, smallest", way("clockwise", "F_min")],
    ["Mean bi-directional radial deviation D", (f) => f.D], ["Circular hysteresis H", (f) => f.H]];
  section("circle", "Circles by ISO 230-4", lead("Circular deviation G, radial deviation F and mean bi-directional radial deviation D as ISO 230-4:2005 defines them, about the centre of the least-squares circle; circular hysteresis H as in its first edition. ↺ counter-clockwise, ↻ clockwise, seen so that the second axis is a quarter of a turn counter-clockwise of the first. Extremes of single points, so without an uncertainty of their own."),
    data.circles.map((c) => [el("h3", {}, "Plane " + c.first + c.second + (c.setup ? ", setup " + c.setup : "")), pair((part, name) => circleFigure(c, part, name).node, "calibrated"),
      table("Plane " + c.first + c.second + ", nominal radius " + num(c.radius_mm, 6) + " mm", measuredAndLeft([["Figure"]], "µm"),
        rows.map(([name, value]) => [name, ...leftToo(num(value(c.measured)), num(value(c.calibrated)))]))]));
}

/** Balls and points: where the artifact's file has them, and where the session found them. */
function nominalAndActual() {
  if (!data.features.length) return;
  const at = (xyz) => (xyz ? xyz.map((x) => minus(x.toFixed(4))) : ["–", "–", "–"]);
  const columns = ["x", "y", "z"].map((k) => [k + ", mm", "n"]);
  const rows = data.features.flatMap((f) => [["nominal", at(f.nominal_mm)], ["actual", at(f.actual_mm)],
    ["U (k = 2), µm", f.std_um.map((s) => (s > 0 ? digits(2 * s, 2) : "–"))]].map(([what, cells], i) => [i ? "" : f.name, what, ...cells,
    i === 0 ? (known(f.nominal_radius_mm) ? f.nominal_radius_mm.toFixed(4) : "–") : i === 1 ? (known(f.radius_mm) ? f.radius_mm.toFixed(4) : "–") : f.radius_std_um > 0 ? digits(2 * f.radius_std_um, 2) : "–"]));
  return longTable("Balls and points, nominal and actual (in workpiece; nominal centres are known there only where the artifact's pose is)", [["Name"], [""], ...columns, ["radius, mm", "n"]], rows, 30);
}

const kThermalTests = { etve: "Surroundings (ETVE): the machine idle", spindle: "Spindle", linear_axis: "Linear axis ", rotary_axis: "Rotary axis " };

/** One test of ISO 230-3: its figures in boxes, its pictures, and what each figure is. */
function thermalTest(test, temperatures) {
  const unit = unitText(test.unit), hours = duration(3600 * (test.heated_hours[1] - test.heated_hours[0]));
  const text = (f) => bare(f.value, f.std), idle = test.kind === "etve";
  const columns = idle ? [["range", "range, whole period"], ["hour", "largest range within an hour"]] :
    [["first_hour", "displacement in the first hour"], ["heated", (test.kind === "spindle" ? "while it turned (" : "up to the largest (") + hours + ")"], ["recovery", "recovery to the last reading"], ["range", "range, whole period"]];
  const of = (c, key) => c.measured_figures[key], chief = idle ? "range" : "heated";
  const tile = (c) => [said(c.name) + (idle ? ": range" : ": after " + hours), of(c, chief).value, of(c, chief).std, unit, known(of(c, chief).noise) && idle ? "of which noise " + num(of(c, chief).noise, 2) + " " + unit : null,
    idle ? (known(of(c, "hour").value) ? "within an hour " + num(of(c, "hour").value) + " " + unit : null) : known(of(c, "first_hour").value) ? "first hour " + num(of(c, "first_hour").value) + " " + unit : null];
  const named = (c) => [said(c.name) + (c.iso230 ? " (" + c.iso230 + ")" : "")];
  const cell = (c, key) => [text(of(c, key)), data.calibration ? el("div", { class: "note" }, "left " + text(c.left_figures[key])) : null];
  return [el("h3", {}, kThermalTests[test.kind] + (test.axis || "") + (test.setup && test.setup !== test.axis && test.setup !== test.kind ? ", setup " + test.setup : "")), el("p", { class: "note" }, test.in_words + "."),
    tileBoxes(test.courses.map(tile)), pair((part, name) => thermalFigure(test, part, name, temperatures).node, "left"),
    table("Displacement, " + unit + (data.calibration ? ", as measured and as the model leaves it" : ""), [[test.courses.some((c) => known(c.at)) ? "Position" : "Direction"], ...columns.map(([, name]) => [name, "n"]), ["noise in the range", "n"]],
      test.courses.map((c) => [named(c), ...columns.map(([key]) => cell(c, key)), num(of(c, "range").noise, 2)]))];
}

function thermal() {
  const t = data.thermal, between = (test, one) => one.hours.some((h) => h >= test.hours[0] && h <= test.hours[1]);
  if (!t.tests.length && !data.networks.length) return;
  const range = (one) => [one.sensor, num(Math.min(...one.temperature), 4), num(Math.max(...one.temperature), 4), num(one.range)];
  section("thermal", "Displacement against time, figures of ISO 230-3", t.tests.length ? lead("Displacement found by an independent instrument, from the first reading, while the machine warms and cools. Where nothing tells when the heating ended, it is taken up to the largest displacement. ± is the expanded uncertainty (k = 2) from the noise of the readings alone, where that is known. Noise makes a range too large by the share that is stated; subtract it where it matters.") : null,
    data.networks.map((n) => el("p", {}, el("b", {}, n.in_words), ": ", said(n.summary))),
    t.tests.map((test) => thermalTest(test, t.temperatures.filter((one) => between(test, one)))),
    t.temperatures.length ? table("Temperatures" + (t.temperatures.length === 12 ? " of twelve sensors" : ""), [["Sensor"], ["lowest, °C", "n"], ["highest, °C", "n"], ["range, K", "n"]], t.temperatures.map(range)) : null);
}

function candidates() {
  if (!diagnosis.candidates.length) return;
  const key = "held_out_rms" + kSuffix;
  const rows = diagnosis.candidates.map((c) => {
    const taken = diagnosis.missing.find((m) => sameEffect(m.effect, c.effect));
    const gain = c[key] && known(c[key][0]) && known(c[key][1]) && c[key][0] > 0 ? 1 - c[key][1] / c[key][0] : 0;
    const rivalNames = taken ? taken.confusable_with.map(withSymbol) : [];
    return Object.assign([withSymbol(c), c.odds_in_words, c[key] && known(c[key][1]) ? [meter(gain), bareRms(c[key][1])] : "–", c["size" + kSuffix] > 0 ? (sizeStd(c[key]) > 0 ? bare(c["size" + kSuffix], sizeStd(c[key])) : num(c["size" + kSuffix])) : "–", rivalNames.join("; ") || "–"], { chosen: !!taken });
  });
  sectionIf(diagnosis.missing.length > 0, "candidates", "Candidates, best first", "none is named", lead("Each cause of the catalogue. The odds are conditional on the effects found; an effect that merely imitates them has none. Size and held-out RMS are those of each alone, everything refitted with it; the bar is the share of the held-out RMS that it removes, worked out for the best. Bold: named as missing."),
    longTable(diagnosis.candidates.length + (diagnosis.candidates.length === 1 ? " cause asked" : " causes asked"), [["Cause"], ["odds", "nowrap"], ["held-out RMS after, " + kUnit, "nowrap"], ["size, " + kUnit, "n"], ["confusable with", "text"]], rows, 12));
}

const stepName = (e) => (e.action === "calibrate" ? "calibrated" : e.action + " " + said(withSymbol(e)));
/** Held-out RMS after each step of the ledger, and with what the diagnosis proposes. */
function ledgerSteps() {
  if (!data.ledger.length) return [];
  const key = "held_out_rms" + kSuffix;
  const steps = [{ name: data.ledger[0].action === "calibrate" ? "nominal machine" : "before", held_out: data.ledger[0][key] && data.ledger[0][key][0] }];
  for (const e of data.ledger) steps.push({ name: stepName(e), held_out: e[key] && e[key][1] });
  const proposed = data.figures.find((f) => /named effects/.test(f.name));
  if (proposed) steps.push({ name: "proposed: " + data.added.map((a) => said(withSymbol(a))).join(" and "), held_out: proposed[key], proposed: true });
  return steps.filter((s) => known(s.held_out));
}

function ledger() {
  if (!data.ledger.length) return;
  sectionIf(data.ledger.length > 1, "ledger", "Ledger: error after each step", "nothing was added since the calibration",
    table("Each step and its effect on the error", [["Step"], ["RMS, " + kUnit, "n"], ["held-out RMS, " + kUnit, "n"], ["when (UTC)", "nowrap"], ["taken from", "nowrap"]],
      data.ledger.map((e) => [stepName(e), fall(e["rms" + kSuffix]), fall(e["held_out_rms" + kSuffix]), clock(e.time, ""), e.calibration || "–"])),
    el("p", { class: "note" }, "Any step can be undone with mm remove."));
}

function parameters() {
  const lost = data.identifiability ? data.identifiability.lost : [];
  const rows = data.parameters.flatMap((e) => e.values.map((v) => [withSymbol(e), [v.name, v.meaning ? el("div", { class: "note" }, said(v.meaning)) : null], known(v.nominal) ? withUnit(short(v.nominal), v.unit) : "–", v.held ? withUnit(num(v.value, 5), v.unit) + " (held)" : plusMinus(v.value, v.std, v.unit)]));
  sectionIf(rows.length > 0 || lost.length > 0, "parameters", "Parameters, nominal and actual", "the model has none", rows.length ? longTable("As in the calibration file, with the expanded uncertainty (k = 2)", [["Effect"], ["Parameter"], ["nominal", "n"], ["actual", "n"]], rows, 40) : lead("The model has no effects: the machine as its scales read."),
    data.identifiability ? el("p", {}, data.identifiability.rank + " of " + data.identifiability.parameters + " parameters are determined by this session.") : null,
    nominalAndActual(),
    data.profiles.map((p) => [el("h3", {}, "The " + said(p.in_words)), profileFigure(p)]),
    lost.length ? [el("h3", {}, "Directions that this session does not determine"), el("ul", {}, lost.map((l) => el("li", {}, l.in_words.replace(/\.$/, "") + ". Held: " + l.fixed_by + (l.by_convention ? ", by convention" : "") + (l.would_show ? "; " + l.would_show : "") + ".")))] : null);
}

function pointSet() {
  const p = data.point_set, range = (a, b, unit) => (known(a) ? (a === b ? short(a) : short(a) + " … " + short(b)) + " " + unitText(unit) : "–");
  const weak = (p.weak || []).length + data.weak.length > 0;
  sectionIf(weak, "points", "The point set", p.contacts + " contacts, " + p.references + " references; no parameter is weakly determined", lead(p.contacts + " contacts and " + p.references + " references in " + (p.duration_s > 300 ? num(p.duration_s / 60) + " min" : num(p.duration_s) + " s") + "."),
    p.features.length ? longTable("Balls and points", [["Name"], ["contacts", "n"], ["cone of approach, ± °", "n"], ["centre alone, × noise", "n"]], p.features.map((f) => [f.name, String(f.contacts), num(f.cone_half_angle_deg),
      f.kind !== "ball" ? "–" : known(f.centre_std_per_noise) ? num(f.centre_std_per_noise, 2) : "not determined"]), 20) : null,
    table("Joints", [["Joint"], ["range", "nowrap"], ["positions", "n"], ["travel + / − / unknown", "n"], ["correlation with time", "n"]], p.joints.map((j) => {
      const unit = "lower_deg" in j ? "deg" : "mm";
      return [j.name, range(j["lower_" + unit], j["upper_" + unit], unit), known(j.positions) ? String(j.positions) : "many", j.travel.up + " / " + j.travel.down + " / " + j.travel.unknown, fixed(j.correlation_with_time)];
    })),
    p.logged.length ? table("Logged", [["Quantity"], ["range", "nowrap"], ["missing", "n"], ["correlation with time", "n"]], p.logged.map((i) => [i.name, range(i.lower, i.upper, i.unit), String(i.missing),
      fixed(i.correlation_with_time) + (Math.abs(i.correlation_with_time) > 0.95 ? " (not separable from drift)" : "")])) : null,
    p.weak && p.weak.length ? table("Parameters that these points determine only weakly, before any fit (k = 2)", [["Parameter"], ["only to ±", "n"]], p.weak.map((w) => [w.name, withUnit(num(2 * w.std, 2), w.unit)])) : null,
    data.weak.length ? [el("h3", {}, "Weakly determined in the fit"), el("ul", {}, data.weak.map((w) => el("li", {}, said(w) + ".")))] : null);
}

function outliers() {
  if (!data.outliers.length) return;
  section("outliers", "Outliers, set aside", longTable(data.outliers.length + (data.outliers.length === 1 ? " measurement that deviates from its" : " measurements that deviate from their") + " neighbours", [["Row", "n"], ["feature"], ["time, s", "n"], ["residual", "n"], ["× noise", "n"]],
    data.outliers.map((o) => [String(o.row), o.feature || "–", num(o.time_s, 5), withUnit(num(o.residual), o.unit), num(o.sigmas, 2)]), 12));
}

function curves() {
  if (data.curves.length) foldedSection("convergence", "Convergence of the search", "best RMS of each generation", el("div", { class: "pair" }, data.curves.map((c) => curveFigure(c).node)));
}

function limits() {
  const groups = new Map();
  for (const c of diagnosis.cannot_show) {
    const key = c.effect.type + "\n" + c.why;
    if (!groups.has(key)) groups.set(key, { members: [], why: c.why, moves: new Set() });
    const group = groups.get(key);
    group.members.push(withSymbol(c));
    group.moves.add(c.moves || "–");
  }
  // the members of one family: no more than can be read
  const named = (g) => g.members.slice(0, 6).join("; ") + (g.members.length > 6 ? "; and " + (g.members.length - 6) + " more" : "");
  const advice = (g) => [...g.moves][0] + (g.moves.size > 1 ? " Likewise for the others." : "");
  const inputs = diagnosis.missing_inputs;
  sectionIf(inputs.length > 0, "limits", "What this session cannot show", groups.size ? diagnosis.cannot_show.length + " effects cannot be excluded" : "no effect of the catalogue", inputs.length ? table("Inputs that were not recorded", [["Input"], ["in its place", "text"], ["cannot be excluded without it", "text"]],
    inputs.map((i) => [i.input, i.assumed ? "assumed " + i.assumed : "–", i.assumed ? "–" : i.in_words || "–"])) : null,
    groups.size ? [lead("This session cannot exclude these effects."),
      longTable("Effects, why they stay hidden, and what would show them", [["Effect", "text"], ["why", "text"], ["what would show it", "text"]], [...groups.values()].map((g) => [named(g), g.why, advice(g)]), 10)] :
    inputs.length ? null : lead("Every effect of the catalogue would have shown in this session."));
}

function nextMeasurement() {
  const moves = diagnosis.next_measurement;
  if (!moves.length) return;
  const keys = [...new Set(moves.flatMap((m) => Object.keys(m)))];
  const head = (k) => k.replace(/_(mm|deg|um|s|degC|mm_s|deg_s)$/, (x, unit) => ", " + unitText(unit.replace("_s", "/s"))).replace(/_/g, " ");
  const text = (v) => (Array.isArray(v) ? "(" + v.map((a) => num(a, 2)).join(", ") + ")" : typeof v === "number" ? short(v) : v === undefined || v === null ? "–" :
    typeof v === "object" ? Object.entries(v).map(([joint, side]) => (side > 0 ? "+" : "−") + joint).join(", ") : v);
  section("next", "Next measurement", lead(moves.length + " targets that best separate the candidates, most useful first."),
    longTable("Targets", [["#", "n"], ...keys.map((k) => [head(k), "n"])], moves.map((m, i) => [String(i + 1), ...keys.map((k) => text(m[k]))]), 12),
    el("p", { class: "lead" }, "As a plan that mm simulate and the node measure run:"), el("div", { class: "command" }, el("code", {}, data.moves_command)));
}

function legend() {
  const terms = [["RMS", "root mean square of the scalar residuals: one per contact on a ball, one per measured component of a reference."],
    ["Held-out RMS", "the same, of measurements that the fit did not use: blocks of time are left out in turn, the parameters are refitted to the others, and no drift is predicted, as for a corrected machine. Fitting noise does not reduce it. Everywhere on this page, of mm diagnose and in the ledger of mm add, it is this figure."],
    ["χ²/ν", "squared residuals over the noise, per degree of freedom: 1 when only noise is left; meaningless where the noise was estimated from the residuals."],
    ["Odds", "that the effect acts, against its rivals and chance; “20 to 1” is a probability of 95 %."],
    ["Repeatability", "standard deviation of one measurement repeated; noise found: the part of the residuals that is unrelated to any variable."],
    ["p", "probability of so large a share by chance, corrected for the number of variables."],
    ["±", "the expanded uncertainty, k = 2, everywhere on this page: of a parameter from the covariance of the fit; of an RMS, a share or a size as for independent normal residuals, so more where what is left has structure. Largest values and readings are as observed."]];
  if (!data.calibration) terms.splice(3, 1); // nothing has odds
  main.append(el("footer", {}, el("h3", {}, "How to read the figures"), el("dl", {}, terms.map(([a, b]) => [el("dt", {}, a), el("dd", {}, b)])),
    el("p", {}, ("measuring_machine " + (data.software || "")).trim() + ". Session " + data.session + (data.calibration ? ", calibration " + data.calibration : "") + ". This page is self-contained and loads nothing from a network. Figures by Plotly.js (MIT).")));
}

const standardTests = [positioning, circles, diagonals, rotations, lengths];
(data.calibration ? [header, errors, ...standardTests, missing, unexplained, left, where, variables, space, thermal, candidates, ledger, parameters, pointSet, outliers, curves, limits, nextMeasurement, legend] :
  [headerAsItIs, ...standardTests, thermal, errors, where, variables, space, pointSet, legend]).forEach((part) => part());
drawAll();
