// What is told of the artifact and of what an axis has for itself: how balls scatter, where they lie as a
// whole, what differs from position to position, run to run, stop to stop.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>

#include "base/units.h"
#include "diagnosis/answers.h"
#include "diagnosis/shape_maker.h"
#include "diagnosis/wording.h"
#include "effects/registry.h"

namespace mm {
namespace {

/// What a block was in this session, beside all else that was found.
struct BlockFit {
  Eigen::VectorXd values, std;  // of the coefficients of its columns
  Eigen::MatrixXd covariance;
};

/// @param ratio of the block, as it was found.
BlockFit fitOf(const Search& search, const Explanation& found, std::size_t block, double ratio) {
  Explanation others = found;
  others.scatter[block] = 0.0;
  others.members.emplace_back();
  others.members.back().size = ratio;
  others.members.back().columns = std::make_shared<RowMatrix>(search.questions().scatter[block].columns);
  const Evidence::Fit fit = search.evidenceAt(others)->fit(others.members);
  const Eigen::MatrixXd& covariance = fit.covariance.back();
  return {fit.values.back(), covariance.diagonal().cwiseSqrt(), covariance};
}

/// Where the artifact lies as a whole, beside a place that is stated as known. @param block of the datum.
void fillDatum(const Search& search, const Explanation& found, std::size_t block, double unit,
               Diagnosis& out) {
  constexpr double kClearly = 4.0;  // standard uncertainties
  const BlockFit fit = fitOf(search, found, block, search.questions().scatter[block].ratio);
  const Eigen::VectorXd& shift = fit.values;
  if (!((shift.array().abs() > kClearly * fit.std.array()).any())) return;
  ArtifactScatter s;
  s.what = kDatum;
  s.std = shift.norm() * unit;
  s.inWords = "the artifact as a whole is displaced from its stated position, by";
  const char* const axes[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k)
    s.inWords += std::string(k == 0 ? " " : ", ") + shortNumber(shift[k] * unit / kMicrometre) + " ± " +
                 shortNumber(2.0 * fit.std[k] * unit / kMicrometre) + " um along " + axes[k];
  s.inWords += " (k = 2); leave its pose free, or correct its position";
  out.artifactScatter.push_back(std::move(s));
}

/// What an axis has from position to position or from run to run, with the largest of it.
void fillShared(const Search& search, const Explanation& found, std::size_t block, ArtifactScatter& s) {
  const Questions& q = search.questions();
  const Problem& problem = q.space->problem();
  const Domain& domain = problem.model().domain();
  const int number = domain.findJoint(jointOf(s));
  const Joint& joint = domain.joints[static_cast<std::size_t>(number)];
  const RowMatrix& columns = q.scatter[block].columns;
  const BlockFit fit = fitOf(search, found, block, found.scatter[block]);
  Eigen::Index most = 0, at = 0;
  fit.values.cwiseAbs().maxCoeff(&most);
  columns.col(most).head(q.space->rows()).cwiseAbs().maxCoeff(&at);
  const int row = q.space->used()[static_cast<std::size_t>(at)];
  // m or rad of the axis where a coefficient is 1
  const double ofOne =
      columns(at, most) * q.space->fitted().sigma[row] /
      q.space->linearisation().slotGradients()(row, problem.model().machine().layout().axis(number));
  s.angular = joint.kind != JointKind::kLinear;
  s.std = found.scatter[block] * found.white * std::abs(ofOne);
  s.stdStd = s.std / std::sqrt(2.0 * std::max<double>(1.0, static_cast<double>(columns.cols()) - 1.0));
  const double inUnit = ofOne / unitOf(s.angular);
  const std::string largest =
      "most by " + withFactor(expanded(fit.values[most] * inUnit, fit.std[most] * std::abs(inUnit),
                                       nameOfUnit(s.angular)));
  const std::string place = " at " +
                            shortNumber(problem.state(problem.rows()[row].observation).position[number] /
                                        (s.angular ? kDegree : kMillimetre)) +
                            (s.angular ? " deg" : " mm");
  const auto is = [&](const char* kind) { return s.what.rfind(kind, 0) == 0; };
  if (is(kPositionsOf)) {
    if (!domain.positions[static_cast<std::size_t>(number)].empty())
      s.correctedBy = effectOfEachPosition(joint.name);
    s.inWords = "the error of " + joint.name + " differs from position to position, " + largest + place +
                ", the same in each run: " + errorsOfPositions(s);
  } else if (is(kStopsOf)) {
    const std::vector<int> stood = positionNumbers(problem, number);
    int stops = 1;
    for (std::size_t o = 1; o < stood.size(); ++o) stops += stood[o] != stood[o - 1];
    const bool again = stops > distinctPositions(problem, number);
    s.inWords =
        again
            ? joint.name + " stops elsewhere each time, " + largest + place +
                  ": its clamp, brake or drive does not hold it; touch more at each stop, or tighten it"
            : "the error of " + joint.name + " differs from stop to stop, " + largest + place +
                  ": its scale or bearing at these angles, or its clamp, which one stop at each cannot tell "
                  "apart; come back to the same angles";
  } else if (is(kScaleOf)) {
    double sum = 0.0, farthest = 0.0, variance = 0.0;  // of steps, each of what was before it
    for (Eigen::Index k = 0; k < fit.values.size(); ++k) {
      sum += fit.values[k];
      if (!(std::abs(sum) > std::abs(farthest))) continue;
      farthest = sum;
      variance = fit.covariance.topLeftCorner(k + 1, k + 1).sum();
    }
    s.inWords =
        "the scale of " + joint.name + " wanders during the session, most by " +
        withFactor(expanded(std::abs(farthest * inUnit),
                            std::sqrt(std::max(0.0, variance)) * std::abs(inUnit), nameOfUnit(s.angular))) +
        " at the ends of its travel, counted from the middle: log the temperatures of its scale or screw "
        "and of the part";
  } else {
    const std::string kind = is(kRunsOf) ? "run" : "pass";
    s.inWords = "the zero of " + joint.name + " shifts from " + kind + " to " + kind + ", " + largest +
                " in " + kind + " " + std::to_string(most + 1) +
                ": the instrument or the part moved, or a zero was set anew; give each " + kind +
                " a setup of its own";
  }
}

/// What is not there at 100 to 1 is not spoken of.
bool isSaid(const Search& search, const Explanation& found, std::size_t block) {
  const double said = std::log(100.0);
  Explanation without = found;
  without.scatter[block] = 0.0;
  const auto evidenceOf = [&](const Explanation& at) {
    return search.evidenceAt(at)->given(at.members).logEvidence;
  };
  return evidenceOf(found) - evidenceOf(without) > said;
}

}  // namespace

std::string jointOf(const ArtifactScatter& scatter) {
  const std::string of = " of ";
  const std::size_t at = scatter.what.find(of);
  return at == std::string::npos ? "" : scatter.what.substr(at + of.size());
}

void fillScatter(const Search& search, const Explanation& found, double unit, Diagnosis& out) {
  const Questions& q = search.questions();
  for (std::size_t b = 0; b < q.scatter.size(); ++b) {
    if (q.scatterNames[b].empty() || !(found.scatter[b] > 0.0)) continue;
    if (q.scatterNames[b] == kDatum) {
      fillDatum(search, found, b, unit, out);
      continue;
    }
    ArtifactScatter s;
    s.what = q.scatterNames[b];
    if (!jointOf(s).empty()) {
      if (!isSaid(search, found, b)) continue;
      fillShared(search, found, b, s);
      out.artifactScatter.push_back(std::move(s));
      continue;
    }
    s.std = found.scatter[b] * found.white * unit;
    s.stdStd = s.std /
               std::sqrt(2.0 * std::max<double>(1.0, static_cast<double>(q.scatter[b].columns.cols()) - 1.0));
    const std::string size = shortNumber(s.std / kMicrometre) + " um";
    s.inWords = s.what == "centres"
                    ? "the balls' centres scatter by " + size +
                          " about the positions in the artifact file; calibrate the artifact, or state "
                          "their centre_std_um"
                : s.what == "radii"
                    ? "the balls' radii scatter by " + size +
                          " about the values in the artifact file; measure them, or state their "
                          "radius_std_um"
                    : "the form deviation of the balls is " + size +
                          "; clean them, turn one and measure it again, or use better ones";
    out.artifactScatter.push_back(std::move(s));
  }
}

}  // namespace mm
