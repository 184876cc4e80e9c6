// A uPlot in a component: as wide as its place, drawn again when its colours or its data change.

import { h } from "preact";
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { colours, useTheme } from "./parts.js";

/** An axis in the colours of the page. */
export const axis = (c, label, more) => Object.assign({ values: (u, splits, at, space, step) => splits.map((v) => (known(v) ? minus(String(Number(v.toPrecision(12)))) : "")), size: 32, stroke: c.soft, grid: { stroke: c.line, width: 1 }, ticks: { stroke: c.line, width: 1 }, label, labelSize: 20, labelGap: 2, labelFont: "12px system-ui, sans-serif", font: "12px system-ui, sans-serif" }, more);

/** @param make colours → [options of uPlot, data]; called again when one of `inputs` changes. */
export function Chart({ make, inputs, label, tall, onReady }) {
  const place = useRef(null), plot = useRef(null);
  const theme = useTheme();
  useEffect(() => {
    const [options, data] = make(colours());
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
  return h("div", { class: "chart", ref: place, role: "img", "aria-label": label });
}

/** A curve with its band: x, y and the half width of the band. */
export function curveWithBand(c, { x, y, half, xLabel, yLabel, words }) {
  const low = y.map((v, i) => v - half[i]), high = y.map((v, i) => v + half[i]);
  return [{
    scales: { x: { time: false } },
    axes: [axis(c, xLabel, words ? { splits: () => x, values: () => words } : {}), axis(c, yLabel, { size: 60 })],
    series: [{}, { stroke: "transparent", points: { show: false } }, { stroke: "transparent", points: { show: false } }, { stroke: c.accent, width: 2, points: { show: x.length < 40, size: 5, fill: c.accent } }],
    bands: [{ series: [1, 2], fill: c.accent + "40" }],
  }, [x, high, low, y]];
}
