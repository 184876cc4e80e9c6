#include "export/printer_terms.h"

#include <cmath>

namespace mm {
namespace {

/// A place for one number: what was active there, and what the calibration adds.
struct Term {
  double active = 0.0, added = 0.0;
  double sum() const { return active + added; }
};

constexpr double kLeastAngle = 1e-8;  // 1 nm over 100 mm: less is rounding

Term angle(const NeededCorrection& needed, const PrinterTerms& of, const char* output, const char* input) {
  const ExportAxis *o = needed.findAxis(output), *i = needed.findAxis(input);
  if (o == nullptr || i == nullptr) return {};
  const auto told = [](double tangent) { return std::abs(tangent) < kLeastAngle ? 0.0 : tangent; };
  return {told(of.active.byPosition(o->joint, i->joint)), told(of.adds.square(o->joint, i->joint))};
}

struct Reversal {
  const ExportAxis* axis = nullptr;
  Term gap;
};

std::vector<Reversal> reversalsOf(const NeededCorrection& needed, const PrinterTerms& of,
                                  const PrinterPlaces& places) {
  std::vector<Reversal> found;
  for (const char letter : places.reversals) {
    const ExportAxis* axis = needed.findAxis(std::string(1, letter));
    if (axis == nullptr || axis->kind != JointKind::kLinear) continue;
    found.push_back({axis,
                     {2.0 * of.active.byTravel(axis->joint, axis->joint),
                      2.0 * of.adds.byTravel(axis->joint, axis->joint)}});
  }
  return found;
}

}  // namespace

const char* const kSquarenessNote =
    "Squareness is an angle: it is corrected by moving the first axis of each pair. What that turns "
    "the workpiece's frame is taken up when the workpiece is aligned.";

PrinterTerms printerTerms(const NeededCorrection& needed, const PrinterPlaces& places, Exported& out) {
  PrinterTerms terms;
  terms.adds = straightPart(needed, &NeededCorrection::adds);
  terms.active = straightPart(needed, &NeededCorrection::activeAt);
  struct Angle {
    const char* output;
    Term term;
    std::optional<double>* factor;
  };
  std::vector<Angle> angles;
  if (places.angles)
    angles = {{"x", angle(needed, terms, "x", "y"), &terms.xy},
              {"x", angle(needed, terms, "x", "z"), &terms.xz},
              {"y", angle(needed, terms, "y", "z"), &terms.yz}};
  const std::vector<Reversal> reversals = reversalsOf(needed, terms, places);
  const auto tells = [&](const Term& gap) { return std::abs(gap.added) > places.leastReversal; };
  std::string negative;
  for (const Reversal& r : reversals) {
    if (!tells(r.gap)) continue;
    if (r.gap.sum() > -places.leastReversal) {
      out.axes.insert(r.axis->letter);
      continue;
    }
    negative += " " + capital(r.axis->letter);
    if (r.gap.active != 0.0) out.axes.insert(r.axis->letter);
  }
  if (!negative.empty())
    out.notes.push_back("The reversal of" + negative + " is negative (the slide leads its drive), which " +
                        places.title + " cannot hold; it is left out.");
  if (places.sharedFraction && !out.axes.empty())
    for (const Reversal& r : reversals)
      if (r.gap.active != 0.0) out.axes.insert(r.axis->letter);
  for (const Angle& a : angles)
    if (a.term.added != 0.0) out.axes.insert(a.output);
  for (const Angle& a : angles)
    if (out.axes.count(a.output) > 0 && (a.term.added != 0.0 || a.term.active != 0.0))
      *a.factor = a.term.sum();
  for (const Reversal& r : reversals) {
    if (out.axes.count(r.axis->letter) == 0 || (r.gap.active == 0.0 && !(tells(r.gap) && r.gap.sum() > 0.0)))
      continue;
    terms.reversals.emplace_back(r.axis, r.gap.sum() > places.leastReversal ? r.gap.sum() : 0.0);
  }
  return terms;
}

}  // namespace mm
