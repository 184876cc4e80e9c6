// What is told of the artifact: how its balls scatter, and where it lies as a whole.
#include <Eigen/Dense>

#include "base/units.h"
#include "diagnosis/answers.h"
#include "diagnosis/wording.h"

namespace mm {
namespace {

/// Where the artifact lies as a whole, beside a place that is stated as known. @param block of the datum.
void fillDatum(const Search& search, const Explanation& found, std::size_t block, double unit,
               Diagnosis& out) {
  constexpr double kClearly = 4.0;  // standard uncertainties
  const Questions& q = search.questions();
  const Evidence::Fit fit = search.evidenceAt(found)->fit(found.members);
  Eigen::VectorXd left = q.rows.target;
  for (std::size_t j = 0; j < found.members.size(); ++j) left -= *found.members[j].columns * fit.values[j];
  Eigen::MatrixXd columns = q.scatter[block].columns;
  q.space->project(columns);
  Eigen::MatrixXd products = columns.transpose() * columns;
  products.diagonal().array() += 1.0 / (q.scatter[block].ratio * q.scatter[block].ratio);
  const Eigen::MatrixXd covariance = products.inverse();
  const Eigen::VectorXd shift = covariance * (columns.transpose() * left);
  const Eigen::VectorXd std = found.white * covariance.diagonal().cwiseSqrt();
  if (!((shift.array().abs() > kClearly * std.array()).any())) return;
  ArtifactScatter s;
  s.what = kDatum;
  s.std = shift.norm() * unit;
  s.inWords = "the artifact as a whole is displaced from its stated position, by";
  const char* const axes[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k)
    s.inWords += std::string(k == 0 ? " " : ", ") + shortNumber(shift[k] * unit / kMicrometre) + " ± " +
                 shortNumber(2.0 * std[k] * unit / kMicrometre) + " um along " + axes[k];
  s.inWords += " (k = 2); leave its pose free, or correct its position";
  out.artifactScatter.push_back(std::move(s));
}

}  // namespace

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
