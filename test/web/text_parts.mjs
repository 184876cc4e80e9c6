// What the pages compute of numbers and words, against what a person would write. Prints `ok …` and `not ok …` lines.
import { readFileSync } from "node:fs";
import { createContext, runInContext } from "node:vm";

const page = createContext({});
runInContext(readFileSync("web/text_parts.js", "utf8"), page);
globalThis.known = runInContext("known", page);
// a module, whatever this node takes a .js file for
const { csvOf } = await import("data:text/javascript," + encodeURIComponent(readFileSync("web/workbench/picture.js", "utf8")));
const say = (name, got, wanted) => console.log((got === wanted ? "ok " : "not ok ") + name + (got === wanted ? "" : ": " + JSON.stringify(got) + " instead of " + JSON.stringify(wanted)));

const expected = {
  'num(1234.5)': "1235",
  'num(-0.0004)': "−0.000400",
  'num(0.000012345)': "1.23 × 10⁻⁵",
  'num(12345678)': "1.23 × 10⁷",
  'num(0)': "0",
  'num(NaN)': "–",
  'digits(123456, 3)': "123000",
  'minus("-0.00")': "0.00",
  'minus("-1.5e-3")': "−1.5e−3",
  'plusMinus(3.14159, 0.012, "um")': "3.142 ± 0.024 µm",
  'plusMinus(12345.6, 150, "um")': "12350 ± 300 µm",
  'plusMinus(3e-7, 1e-9, "1")': "(3.000 ± 0.020) × 10⁻⁷",
  'plusMinus(1, 0)': "1.0000",
  'expanded(3.14159, 0.012, "um")': "3.142 ± 0.024 µm (k = 2)",
  'expanded(3.14159, 0.2, "um")': "3.1 ± 0.4 µm (k = 2)",
  'expanded(99.96, 0.0499, "um")': "99.96 ± 0.10 µm (k = 2)",
  'expanded(-0.001, 0.4, "um")': "0.0 ± 0.8 µm (k = 2)",
  'foundSize({ name: "tau", value: 900, std: 30, unit: "s" }, expanded)': "tau = 900 ± 60 s (k = 2)",
  'foundSize({ name: "tau", value: 0, std: 0, unit: "s" }, expanded)': "tau is not determined by this session",
  'pValue(0.9999)': "1",
  'pValue(0.0312)': "0.031",
  'pValue(3.2e-6)': "3 × 10⁻⁶",
  'pValue(1e-30)': "< 10⁻⁶",
  'rmsStd(2, 200)': 0.1,
  'rmsStd(2, 0)': null,
  'said("gap 3 um at -2 degC -> x")': "gap 3 µm at −2 °C → x",
  'duration(89)': "89 s",
  'duration(5000)': "83 min",
  'duration(200000)': "2.3 days",
  'roundDown(0.73)': 0.5,
  'roundDown(20)': 20,
  'drawnLonger(1)': "to scale",
  'drawnLonger(25000)': "25\u202f000 times longer than they are",
  'meterWidth(1.7)': "100.0%",
  'longestSide([[0, 0, 0], [3, -4, 1]])': 4,
};
for (const [expression, wanted] of Object.entries(expected)) say(expression, runInContext(expression, page), wanted);
say("a table for a spreadsheet", csvOf([['a "b", c', [1, NaN]], ["d", [2.5, -3]]]), '"a ""b"", c","d"\r\n1,2.5\r\n,-3\r\n');
