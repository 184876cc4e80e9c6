// What is told of the artifact: how its balls scatter, and where it lies as a whole.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "diagnosis/answers.h"
#include "diagnosis/wording.h"
#include "effects/registry.h"

namespace mm {
namespace {

/// What a block was in this session, beside all else that was found.
struct BlockFit {
  Eigen::VectorXd values, std;  // of the coefficients of its columns
};

/// @param ratio of the block, as it was found.
BlockFit fitOf(const Search& search, const Explanation& found, std::size_t block, double ratio) {
  Explanation others = found;
  others.scatter[block] = 0.0;
  others.members.emplace_back();
  others.members.back().size = ratio;
  others.members.back().columns = std::make_shared<RowMatrix>(search.questions().scatter[block].columns);
  const Evidence::Fit fit = search.evidenceAt(others)->fit(others.members);
  return {fit.values.back(), fit.covariance.back().diagonal().cwiseSqrt()};
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

/// "-4.7 ± 0.4 um (k = 2) at 212 mm": the position that differs most.
std::string largestOf(const Search& search, const Explanation& found, std::size_t block, const Joint& joint,
                      int number, double unit) {
  const Questions& q = search.questions();
  const BlockFit fit = fitOf(search, found, block, found.scatter[block]);
  Eigen::Index most = 0, row = 0;
  fit.values.cwiseAbs().maxCoeff(&most);
  q.scatter[block].columns.col(most).head(q.space->rows()).cwiseAbs().maxCoeff(&row);
  const Problem& problem = q.space->problem();
  const int o = problem.rows()[q.space->used()[static_cast<std::size_t>(row)]].observation;
  const bool linear = joint.kind == JointKind::kLinear;
  const double inUnit = unit / unitOf(!linear);
  return withFactor(expanded(fit.values[most] * inUnit, fit.std[most] * inUnit, nameOfUnit(!linear))) +
         " at " + shortNumber(problem.state(o).position[number] / (linear ? kMillimetre : kDegree)) +
         (linear ? " mm" : " deg");
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

bool isOfPositions(const ArtifactScatter& scatter) { return scatter.what.rfind(kPositionsOf, 0) == 0; }

std::string jointOfPositions(const ArtifactScatter& scatter) {
  return scatter.what.substr(std::string(kPositionsOf).size());
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
    s.std = found.scatter[b] * found.white * unit;
    s.stdStd = s.std /
               std::sqrt(2.0 * std::max<double>(1.0, static_cast<double>(q.scatter[b].columns.cols()) - 1.0));
    if (isOfPositions(s)) {
      if (isSaid(search, found, b)) {
        const Domain& domain = q.space->problem().model().domain();
        const int joint = domain.findJoint(jointOfPositions(s));
        s.where = largestOf(search, found, b, domain.joints[static_cast<std::size_t>(joint)], joint, unit);
        if (!domain.positions[static_cast<std::size_t>(joint)].empty())
          s.correctedBy = effectOfEachPosition(jointOfPositions(s));
        s.inWords = "the error of " + jointOfPositions(s) + " differs from position to position, most by " +
                    s.where + ", the same in each run: " + errorsOfPositions(s);
        out.artifactScatter.push_back(std::move(s));
      }
      continue;
    }
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
