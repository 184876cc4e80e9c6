#include "report/certificate_style.h"

#include <cctype>

namespace mm {
namespace {

/// What stands at the foot of every printed page; the id may come from a foreign file.
std::string footOfPage(const std::string& title, const std::string& id) {
  std::string plain;
  for (const char c : id)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-') plain += c;
  return "@page { @bottom-left { content: \"" + title + " " + plain +
         "\"; font: 8pt sans-serif; color: #444c56; } }\n";
}

constexpr const char* kStyle = R"(
@page { size: A4; margin: 17mm 16mm 18mm; @bottom-right { content: "page " counter(page) " of " counter(pages); font: 8pt sans-serif; color: #444c56; } }
* { box-sizing: border-box; }
html { color-scheme: light; }
body { font: 10.5pt/1.42 "DejaVu Sans", "Liberation Sans", Arial, sans-serif; color: #1b1f24; background: #e9ecef; margin: 0; }
main { background: #fff; max-width: 210mm; margin: 8mm auto; padding: 15mm 16mm; box-shadow: 0 1px 8px #0002; }
h1 { font-size: 19pt; margin: 0; letter-spacing: .01em; }
h2 { font-size: 12pt; margin: 7mm 0 2mm; padding-bottom: 1mm; border-bottom: .4mm solid #1f5fa8; break-after: avoid; }
.number { color: #444c56; margin: 1mm 0 5mm; overflow-wrap: anywhere; }
table { border-collapse: collapse; width: 100%; font-size: 9.5pt; font-variant-numeric: tabular-nums; }
th { text-align: left; font-weight: 600; vertical-align: top; }
td, th { padding: .9mm 2mm .9mm 0; border-bottom: .2mm solid #d5dae0; vertical-align: top; overflow-wrap: anywhere; }
thead th { border-bottom: .3mm solid #6b7683; }
table.facts th { width: 46mm; color: #444c56; }
tr.own td.which { font-weight: 600; } .when { white-space: nowrap; } th.which, td.which { min-width: 32mm; }
td.n, th.n { text-align: right; white-space: nowrap; padding-left: 3mm; }
tr, figure, .together { break-inside: avoid; }
thead { display: table-header-group; }
figure { margin: 3mm 0; }
figcaption { font-size: 9pt; color: #444c56; }
svg { width: 100%; max-width: 150mm; height: auto; display: block; }
.result { font-size: 11.5pt; margin: 1mm 0; } .result b { white-space: nowrap; }
.bar { display: inline-block; height: 2.6mm; background: #1f5fa8; vertical-align: middle; min-width: .3mm; }
td.share { width: 52mm; white-space: nowrap; }
.verdict { border-left: 1.2mm solid #6b7683; padding: 1mm 0 1mm 3mm; margin: 2mm 0; }
.conforms { border-color: #2d7d46; } .fails { border-color: #b3261e; } .open { border-color: #b07d00; }
.task { margin-bottom: 5mm; } h3 { font-size: 10.5pt; margin: 4mm 0 1mm; break-after: avoid; }
.wide { margin-bottom: 4mm; } .wide th, .wide td:last-child { white-space: nowrap; } .wide th.u { white-space: normal; text-align: right; padding-left: 3mm; }
.tests td, .tests th { font-size: 8.5pt; padding: .5mm 2mm .5mm 0; white-space: nowrap; }
p { margin: 1.5mm 0; } .small { font-size: 9pt; color: #444c56; }
.sign { display: flex; margin-top: 14mm; break-inside: avoid; } .sign div + div { margin-left: 12mm; } .sign div { flex: 1; border-top: .3mm solid #444c56; padding-top: 1mm; font-size: 9pt; }
@media print { body { background: #fff; } main { margin: 0; padding: 0; max-width: none; box-shadow: none; } * { print-color-adjust: exact; -webkit-print-color-adjust: exact; } }
@media screen and (max-width: 720px) { main { margin: 0; padding: 6mm 4mm; } .wide { overflow-x: auto; } table.facts th { width: 30%; }
  table:not(.facts) { display: block; overflow-x: auto; } thead th, thead th.n { white-space: normal; } td, th { overflow-wrap: break-word; } td:first-child:not(.n) { min-width: 26mm; } td.share { width: auto; } }
)";

}  // namespace

std::string certificateStyle(const std::string& title, const std::string& id) {
  return kStyle + footOfPage(title, id);
}

}  // namespace mm
