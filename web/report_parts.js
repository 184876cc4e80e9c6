// Text, numbers and elements of the report. Whatever comes from a file goes in as text, never as markup.

const data = JSON.parse(document.getElementById("data").textContent);
const diagnosis = data.diagnosis;
const kUnit = unitText(data.unit);
const kSuffix = data.unit === "arcsec" ? "_arcsec" : "_um";

const length = (value, digits = 3) => withUnit(num(value, digits), data.unit);

// An RMS of all residuals: its uncertainty, and it ± this without and with the unit of the page.
const stdOfAll = (rms) => rmsStd(rms, data.residuals);
const bareRms = (rms) => bare(rms, stdOfAll(rms));
const rmsText = (rms) => plusMinus(rms, stdOfAll(rms), data.unit);

/** A table that scrolls by itself where the window is narrow. Columns: [heading, class]; rows of cells. */
function table(caption, columns, rows) {
  const cell = (tag, content, kind, scope) => el(tag, { class: kind || null, scope: scope || null }, content);
  return el("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption },
    el("table", {}, el("caption", {}, el("span", {}, caption)),
      el("thead", {}, el("tr", {}, columns.map(([name, kind]) => cell("th", name, kind, "col")))),
      el("tbody", {}, rows.map((row) => el("tr", { class: row.chosen ? "chosen" : null },
        row.map((content, i) => (i === 0 ? cell("th", content, columns[0][1], "row") : cell("td", content, columns[i][1]))))))));
}

function meter(share) {
  return el("span", { class: "meter", "aria-hidden": "true" }, el("i", { style: "width:" + meterWidth(share) }));
}

/** The first rows, and the others behind a line that opens. */
function longTable(caption, columns, rows, shown) {
  if (rows.length <= shown + 2) return [table(caption, columns, rows)];
  return [table(caption, columns, rows.slice(0, shown)),
    el("details", {}, el("summary", {}, (rows.length - shown) + " more"), table(caption + ", continued", columns, rows.slice(shown)))];
}
