// A uPlot in a component: as wide as its place, drawn again when its colours or its data change.

import { h } from "preact";
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { colours, useTheme } from "./parts.js";
import { columnsOf, csvOf, save, svgOf } from "./picture.js";

/** An axis in the colours of the page. */
export const axis = (c, label, more) => Object.assign({ values: (u, splits, at, space, step) => splits.map((v) => (known(v) ? minus(String(Number(v.toPrecision(12)))) : "")), size: 32, stroke: c.soft, grid: { stroke: c.line, width: 1 }, ticks: { stroke: c.line, width: 1 }, label, labelSize: 20, labelGap: 2, labelFont: "12px system-ui, sans-serif", font: "12px system-ui, sans-serif" }, more);

/** `make`: colours → [options of uPlot, data, points that it draws by itself], called again when one of `inputs` changes;
 * `onKey` of a chart whose points are picked by keys. */
export function Chart({ make, inputs, label, tall, onReady, onKey }) {
  const place = useRef(null), plot = useRef(null), points = useRef(null);
  const theme = useTheme();
  useEffect(() => {
    const [options, data, own] = make(colours());
    points.current = own || null;
    const height = tall ? 360 : 250;
    const began = performance.now();
    plot.current = new uPlot(Object.assign({ width: Math.max(200, place.current.clientWidth), height, legend: { show: false }, cursor: { drag: { x: true, y: true, uni: 20 } } }, options), data, place.current);
    place.current.dataset.drawnMs = (performance.now() - began).toFixed(1);
    if (onReady) onReady(plot.current);
    const watch = new ResizeObserver(() => {
      const width = place.current ? Math.max(200, place.current.clientWidth) : 0;
      if (width && Math.abs(width - plot.current.width) > 1) plot.current.setSize({ width, height });
    });
    watch.observe(place.current);
    return () => { watch.disconnect(); plot.current.destroy(); };
  }, [theme, ...inputs]);
  const file = label.replace(/[^A-Za-z0-9]+/g, "_").slice(0, 60);
  return h("div", null,
    h("div", Object.assign({ class: "chart", ref: place, role: onKey ? "application" : "img", "aria-label": label }, onKey ? { tabindex: 0, onKeyDown: onKey } : {})),
    h("p", { class: "note keep" }, h("button", { onClick: () => save(file + ".svg", "image/svg+xml", svgOf(plot.current, points.current, colours())) }, "Keep the picture (SVG)"), " ",
      h("button", { onClick: () => save(file + ".csv", "text/csv", csvOf(columnsOf(plot.current))) }, "Keep its numbers (CSV)")));
}

/** A curve with its band: x, y and the half width of the band. */
export function curveWithBand(c, { x, y, half, xLabel, yLabel, words = null }) {
  const low = y.map((v, i) => v - half[i]), high = y.map((v, i) => v + half[i]);
  return [{
    scales: { x: { time: false } },
    axes: [axis(c, xLabel, words ? { splits: () => x, values: () => words } : {}), axis(c, yLabel, { size: 60 })],
    series: [{}, { named: yLabel + ", upper", stroke: "transparent", points: { show: false } }, { named: yLabel + ", lower", stroke: "transparent", points: { show: false } }, { stroke: c.accent, width: 2, points: { show: x.length < 40, size: 5, fill: c.accent } }],
    bands: [{ series: [1, 2], fill: c.accent + "40" }],
  }, [x, high, low, y]];
}
