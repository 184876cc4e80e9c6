// Where the model fails: the residual against anything, coloured by anything.

import { h } from "preact";
import { useMemo, useState } from "preact/hooks";
import { useDocument } from "./server.js";
import { Choice, Empty, Meter, Section, Table, Tile, Tiles, colours, useTheme } from "./parts.js";
import { Legend, Scatter } from "./scatter.js";
import { measured, rms, text, unitOf, value } from "./units.js";

const kAll = "all";
const kAlong = /^residual along/; // a deviation, measured minus model, whatever measured it

/** The columns that can be drawn, with those that are made here. */
function columnsOf(points) {
  const [residual, ...rest] = points.columns;
  const made = [residual, Object.assign({}, residual, { name: "size of the residual", values: residual.values.map((v) => (known(v) ? Math.abs(v) : null)) })];
  if (points.before) made.push(Object.assign({}, residual, { name: "residual, " + points.before_name, values: points.before }));
  return [...made, ...rest];
}

/** What a positive residual means. */
const signOf = (column) => (kAlong.test(column.name) ? "Residual along a direction: the deviation (actual − indicated) as measured minus that of the model; positive where the probe went further in + than the model says." :
  "Residual: measured minus model; of a touch on a ball positive where the machine found the surface too far out.");

/** Share of the variance of y between classes of x: which picture shows most. */
function explained(x, y) {
  const rows = y.values.map((v, r) => r).filter((r) => known(y.values[r]) && known(x.values[r]));
  if (rows.length < 12) return 0;
  if (!x.words) rows.sort((a, b) => x.values[a] - x.values[b]);
  const groups = new Map();
  rows.forEach((r, k) => { const g = x.words ? x.values[r] : Math.floor((12 * k) / rows.length); if (!groups.has(g)) groups.set(g, []); groups.get(g).push(y.values[r]); });
  const mean = (list) => list.reduce((a, b) => a + b, 0) / list.length, all = mean(rows.map((r) => y.values[r]));
  const whole = rows.reduce((sum, r) => sum + (y.values[r] - all) ** 2, 0);
  const between = [...groups.values()].reduce((sum, g) => sum + g.length * (mean(g) - all) ** 2, 0);
  return whole > 0 ? between / whole - groups.size / rows.length : 0;
}

/** RMS of the rows that are drawn (null: of all), and how many they are. */
function rmsOf(values, rows) {
  let sum = 0, n = 0;
  for (let r = 0; r < values.length; ++r) if ((!rows || rows[r]) && known(values[r])) { sum += values[r] ** 2; ++n; }
  return [n ? Math.sqrt(sum / n) : null, n];
}

export function CompareView() {
  const points = useDocument("points"), compare = useDocument("compare");
  useTheme();
  const [x, setX] = useState(null), [y, setY] = useState(null), [colour, setColour] = useState(null);
  const [filter, setFilter] = useState(kAll), [word, setWord] = useState(kAll), [picked, setPicked] = useState(-1);
  const columns = useMemo(() => (points ? columnsOf(points) : []), [points]);
  const find = (name) => columns.find((c) => c.name === name);
  // what explains most is looked at first
  const asked = compare ? compare.where.map((w) => w.variable).map((v) => (v === "ball" ? "feature" : v)).filter((v) => find(v)) : [];
  const xc = find(x) || find(asked[0]) || columns.find((c) => c.name === "time") || columns[columns.length - 1];
  const plain = columns.find((c) => c.name === "residual");
  const shows = useMemo(() => { const errors = columns.filter((c) => kAlong.test(c.name)); return xc && errors.length ? errors.reduce((a, b) => (explained(xc, b) > explained(xc, a) ? b : a)) : null; }, [columns, xc]);
  const yc = find(y) || shows || plain, cc = colour === "" ? null : find(colour) || find(asked.find((v) => xc && v !== xc.name && find(v).words)) || null;
  const fc = find(filter), words = fc ? fc.words || null : null;
  const rows = useMemo(() => {
    if (!points) return null;
    const drawn = new Uint8Array(points.rows).fill(1);
    if (!fc || word === kAll) return drawn;
    const wanted = Number(word), limits = words ? null : quarter(fc.values, wanted);
    for (let r = 0; r < points.rows; ++r) drawn[r] = Number(words ? fc.values[r] === wanted : known(fc.values[r]) && fc.values[r] >= limits[0] && fc.values[r] <= limits[1]);
    return drawn;
  }, [points, fc, word]);
  const before = useMemo(() => (points && points.before ? rmsOf(points.before, null) : null), [points]);
  if (!points || !compare) return h(Empty, null, "Nothing is compared yet.");
  const suffix = points.unit === "arcsec" ? "_arcsec" : "_um", unit = points.unit;
  const [shownRms, count] = rmsOf(yc.values, rows);
  const names = columns.map((c) => [c.name, c.name]);
    return h("div", null,
    h(Tiles, null,
      before ? h(Tile, { label: "RMS, " + points.before_name, value: rms(before[0], before[1], unit), note: "k\u00a0=\u00a02" }) : null,
      h(Tile, { label: "RMS, this calibration", value: rms(compare["rms" + suffix], points.rows, unit), note: "values held; k\u00a0=\u00a02" }),
      h(Tile, { label: "Held-out RMS", value: rms(compare["held_out_rms" + suffix], points.rows, unit), note: "of blocks of time that the fit did not see; k\u00a0=\u00a02" }),
      h(Tile, { label: "Repeatability, " + compare.repeatability_from, value: text(compare["repeatability" + suffix], unit) }),
      h(Tile, { label: "χ²/ν", value: compare.repeatability_from === "estimated" ? "–" : num(compare.chi2_per_dof), note: "1: nothing but noise" })),
    h(Section, { title: "Residual against anything" },
      h("div", { class: "controls" },
        h(Choice, { id: "y", label: "Draw", value: yc.name, options: names, onChange: setY }),
        h(Choice, { id: "x", label: "against", value: xc.name, options: names, onChange: setX }),
        h(Choice, { id: "colour", label: "coloured by", value: cc ? cc.name : "", options: [["", "nothing"], ...names], onChange: setColour }),
        h(Choice, { id: "filter", label: "only", value: filter, options: [[kAll, "everything"], ...columns.filter((c) => !points.columns[0].values || !/residual/.test(c.name)).map((c) => [c.name, c.name])], onChange: (v) => { setFilter(v); setWord(kAll); } }),
        fc ? h(Choice, { id: "word", label: "where it is", value: String(word), options: [[kAll, "anything"], ...(words ? words.map((w, i) => [String(i), w]) : ["in its lowest quarter", "in its second", "in its third", "in its highest"].map((t, i) => [String(i), t]))], onChange: setWord }) : null),
      h(Legend, { column: cc, c: colours() }),
      h(Scatter, { x: xc, y: yc, colour: cc, rows, onPick: setPicked, label: yc.name + " against " + xc.name + " of " + count + " residuals" }),
      /^residual/.test(yc.name) ? h("p", { class: "note" }, signOf(yc)) : null,
      h("p", { class: "note", "aria-live": "polite" }, "Drawn: " + count + " of " + points.rows + " residuals" + (kAlong.test(yc.name) ? ", those that tell of this direction" : "") + "; RMS " + rms(shownRms, count, unit) + " (k\u00a0=\u00a02). The marks with bars are means of bins ± 2 standard uncertainties. Drag to zoom, double-click to reset; a click, or the arrow keys where the picture has the focus, shows one point."),
      picked >= 0 ? h(PickedRow, { points, columns, row: picked }) : null),
    h(Section, { title: "Where the model fails" }, h(Table, { caption: "Share of the residual's variance that one variable explains, in any direction, alone and of what those above it leave; p is corrected for the number of variables", columns: [["Variable"], ["alone", "nowrap"], ["p", "n"], ["beside those above", "n"], ["p", "n"], ["picture", "n"]],
      rows: compare.where.map((w) => [w.variable, [h(Meter, { share: w.share }), percent(w.share)], pValue(w.p_value), percent(w.share_beside), pValue(w.p_value_beside), h("button", { onClick: () => { setX(w.variable === "ball" ? "feature" : w.variable); scrollTo({ top: 0, behavior: "smooth" }); } }, "Draw")]) })),
    h(Section, { title: "Worst measurements" }, h(Worst, { points, columns })));
}

function quarter(values, k) {
  const sorted = Float64Array.from(values.filter(known)).sort();
  const at = (share) => sorted[Math.round(share * (sorted.length - 1))];
  return [at(k / 4), at((k + 1) / 4)];
}

const cell = (column, r) => (column.words ? column.words[column.values[r]] ?? "–" : known(column.values[r]) ? num(value(column.values[r], column.unit), 5) + " " + unitOf(column.unit) : "–");

const PickedRow = ({ points, columns, row }) => h("div", { class: "card", role: "status" }, h("b", null, "Row " + points.row[row] + (points.outlier[row] ? ", set aside as an outlier" : "")), h("dl", null, columns.map((c) => h("div", { key: c.name }, h("dt", null, c.name), h("dd", null, cell(c, row))))));

function Worst({ points, columns }) {
  const residual = points.columns[0].values;
  const worst = useMemo(() => residual.map((v, r) => r).filter((r) => known(residual[r])).sort((a, b) => Math.abs(residual[b]) - Math.abs(residual[a])).slice(0, 25), [points]);
  const more = columns.filter((c) => ["feature", "component", "time"].includes(c.name) || /travel direction/.test(c.name));
  return h(Table, { caption: "Largest residuals ± the noise taken for one (k\u00a0=\u00a02)", columns: [["Row", "n"], ["residual", "n"], ["× noise", "n"], ...more.map((c) => [c.name, "n"])],
    rows: worst.map((r) => [String(points.row[r]) + (points.outlier[r] ? " (outlier)" : ""), measured(residual[r], points.sigma[r], points.unit), num(Math.abs(residual[r]) / points.sigma[r], 2), ...more.map((c) => cell(c, r))]), most: 10 });
}
