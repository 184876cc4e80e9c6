// A chart as a file: its picture as SVG, its numbers as CSV.

const cellOf = (value) => (typeof value === "string" ? '"' + value.replace(/"/g, '""') + '"' : known(value) ? String(value) : "");
const escaped = (value) => String(value).replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);

/** `columns`: of [heading, values]. */
export const csvOf = (columns) => [columns.map(([name]) => cellOf(name)), ...columns[0][1].map((first, r) => columns.map(([, values]) => cellOf(values[r])))]
  .map((row) => row.join(",")).join("\r\n") + "\r\n";

/** The columns of a uPlot's data, under the words of its series or axes. */
export const columnsOf = (plot) => plot.data.map((values, i) => [plot.series[i].named || plot.axes[Math.min(i, 1)].label, Array.from(values)]);

/** `plot`: a uPlot that is drawn; `points`: x, y, colour, and half of an error bar, in the units of its axes; `c`: colours. */
export function svgOf(plot, points, c) {
  const ratio = devicePixelRatio, box = { x: plot.bbox.left / ratio, y: plot.bbox.top / ratio, w: plot.bbox.width / ratio, h: plot.bbox.height / ratio };
  const px = (v) => (box.x + plot.valToPos(v, "x")).toFixed(1), py = (v) => (box.y + plot.valToPos(v, "y")).toFixed(1);
  const out = ['<svg xmlns="http://www.w3.org/2000/svg" width="' + plot.width + '" height="' + plot.height + '" font-family="sans-serif" font-size="12">',
    '<rect width="100%" height="100%" fill="' + c.card + '"/><clipPath id="inside"><rect x="' + box.x + '" y="' + box.y + '" width="' + box.w + '" height="' + box.h + '"/></clipPath>'];
  const word = (x, y, anchor, text, more) => out.push('<text x="' + x + '" y="' + y + '" fill="' + c.soft + '" text-anchor="' + anchor + '"' + (more || "") + ">" + escaped(text) + "</text>");
  const line = (x1, y1, x2, y2) => out.push('<line x1="' + x1 + '" y1="' + y1 + '" x2="' + x2 + '" y2="' + y2 + '" stroke="' + c.line + '"/>');
  const ticks = (axis, place) => (axis._splits || []).forEach((v, i) => known(v) && axis._values && axis._values[i] != null && place(v, axis._values[i]));
  ticks(plot.axes[0], (v, text) => { line(px(v), box.y, px(v), box.y + box.h); word(px(v), box.y + box.h + 16, "middle", text); });
  ticks(plot.axes[1], (v, text) => { line(box.x, py(v), box.x + box.w, py(v)); word(box.x - 6, Number(py(v)) + 4, "end", text); });
  word(box.x + box.w / 2, plot.height - 4, "middle", plot.axes[0].label);
  word(12, box.y + box.h / 2, "middle", plot.axes[1].label, ' transform="rotate(-90 12 ' + (box.y + box.h / 2) + ')"');
  out.push('<g clip-path="url(#inside)">');
  const [x, ...courses] = plot.data;
  const way = (y) => Array.from(x, (v, i) => (known(y[i]) ? px(v) + "," + py(y[i]) : null)).filter(Boolean);
  for (const band of plot.bands || []) out.push('<polygon points="' + [...way(plot.data[band.series[0]]), ...way(plot.data[band.series[1]]).reverse()].join(" ") + '" fill="' + c.accent + '" fill-opacity="0.25"/>');
  courses.forEach((y, i) => {
    const s = plot.series[i + 1], stroke = typeof s.stroke === "function" ? s.stroke(plot, i + 1) : s.stroke;
    if (stroke && stroke !== "transparent") out.push('<polyline points="' + way(y).join(" ") + '" fill="none" stroke="' + stroke + '" stroke-width="' + s.width + '"/>');
  });
  for (const p of points || []) if (p.half) out.push('<line x1="' + px(p.x) + '" y1="' + py(p.y - p.half) + '" x2="' + px(p.x) + '" y2="' + py(p.y + p.half) + '" stroke="' + p.colour + '"/>');
  for (const p of points || []) out.push('<circle cx="' + px(p.x) + '" cy="' + py(p.y) + '" r="' + (p.half ? 3.2 : 2) + '" fill="' + p.colour + '" fill-opacity="0.8"/>');
  out.push("</g></svg>");
  return out.join("\n");
}

/** Hands a text to the browser as a file. */
export function save(name, type, text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
