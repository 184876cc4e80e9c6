#include "diagnosis/verdict.h"

#include <algorithm>
#include <cmath>

#include "base/distributions.h"
#include "diagnosis/wording.h"

namespace mm {
namespace {

constexpr double kMoreThanStated = 1.3;  // repeatability from five runs is known to a third (ISO 230-2)
constexpr double kByChance = 0.01;       // that repeats come out so much smaller than the noise is

/// What the noise may be at the most, of a session in which nothing acts beside its repeatability, m or rad.
double mostNoise(const CalibrationResult& base) {
  double times = kMoreThanStated;
  if (base.repeatabilityFrom == "repeated" && base.repeated.dof > 0.0) {
    const double dof = base.repeated.dof;
    times = std::max(times, std::sqrt(dof / chiSquaredQuantile(kByChance, dof)));
  }
  return times * base.repeatability;
}

}  // namespace

const ArtifactScatter* beyondTheFile(const Diagnosis& d) {
  if (!(d.base.repeatability > 0.0) || d.base.repeatabilityFrom == "estimated") return nullptr;
  for (const ArtifactScatter& scatter : d.artifactScatter)
    if ((scatter.what == "centres" || scatter.what == "radii") && scatter.std > mostNoise(d.base))
      return &scatter;
  return nullptr;
}

const ArtifactScatter* ofAnAxis(const Diagnosis& d) {
  const auto found = std::find_if(d.artifactScatter.begin(), d.artifactScatter.end(),
                                  [](const ArtifactScatter& s) { return !jointOf(s).empty(); });
  return found == d.artifactScatter.end() ? nullptr : &*found;
}

const DriftResult* beyondTheRepeatability(const Diagnosis& d) {
  if (!(d.base.repeatability > 0.0) || d.base.repeatabilityFrom == "estimated") return nullptr;
  for (const DriftResult& drift : d.drift)
    if (isAngular(d, drift.direction) == d.angular && drift.quickStd > mostNoise(d.base)) return &drift;
  return nullptr;
}

bool hasRivals(const CandidateResult& missing) {
  return std::any_of(missing.confusableWith.begin(), missing.confusableWith.end(),
                     [](const Confusable& c) { return !c.same; });
}

void decide(Diagnosis& out) {
  const bool confusable = std::any_of(out.missing.begin(), out.missing.end(), hasRivals);
  const bool known = out.base.repeatabilityFrom != "estimated";
  out.verdict = !out.profiles.empty()  ? Verdict::kUnknownEffect
                : confusable           ? Verdict::kConfusable
                : !out.missing.empty() ? Verdict::kMissingEffect
                : known && out.outliers.inCommon.empty() && out.noise < mostNoise(out.base) &&
                        beyondTheFile(out) == nullptr && ofAnAxis(out) == nullptr &&
                        beyondTheRepeatability(out) == nullptr
                    ? Verdict::kExplained
                    : Verdict::kScatter;
}

}  // namespace mm
