#include "export/printer_terms.h"

namespace mm {

const char* const kSquarenessNote =
    "Squareness is an angle: it is corrected by moving the first axis of each pair. What that turns "
    "the workpiece's frame is taken up when the workpiece is aligned.";

double squareness(const NeededCorrection& needed, const StraightPart& part, const char* output,
                  const char* input) {
  const ExportAxis *o = needed.findAxis(output), *i = needed.findAxis(input);
  return o == nullptr || i == nullptr ? 0.0 : part.square(o->joint, i->joint);
}

std::vector<std::pair<const ExportAxis*, double>> reversals(const NeededCorrection& needed,
                                                            const StraightPart& part,
                                                            const std::string& letters, double least,
                                                            const std::string& title, Exported& out) {
  std::vector<std::pair<const ExportAxis*, double>> found;
  std::string negative;
  for (const char letter : letters) {
    const ExportAxis* axis = needed.findAxis(std::string(1, letter));
    if (axis == nullptr || axis->kind != JointKind::kLinear) continue;
    const double gap = 2.0 * part.byTravel(axis->joint, axis->joint);
    if (gap < -least) negative += " " + capital(axis->letter);
    found.emplace_back(axis, gap > least ? gap : 0.0);
  }
  if (!negative.empty())
    out.notes.push_back("The reversal of" + negative + " is negative (the slide leads its drive), which " +
                        title + " cannot hold; it is left out.");
  return found;
}

}  // namespace mm
