#include "session/free_centres.h"

#include <algorithm>
#include <vector>

#include "base/dense.h"
#include "base/error.h"
#include "session/sphere_centre.h"

namespace mm {
namespace {

/// A pivot below this part of the largest: contacts on a flat patch say too little about the centre.
constexpr double kFlatPatch = 1e-3;

/// Lengths to tips.
struct Lengths {
  std::vector<Eigen::Vector3d> tips;
  std::vector<double> lengths;  // m
  bool fromZero = false;        // all are too long by one unknown length
};

/// Where they begin; nothing where they do not determine it: tips on a plane have a mirror image.
std::optional<Eigen::Vector3d> beginOf(const Lengths& all) {
  constexpr double kPlane = 1e-4;  // below it noise of a ten thousandth of the extent would decide
  const auto n = static_cast<Eigen::Index>(all.tips.size());
  const Eigen::Vector3d mean = meanOf(all.tips);
  double size = 0.0, usual = 0.0;
  for (const auto& tip : all.tips) size = std::max(size, (tip - mean).norm());
  for (const double length : all.lengths) usual += length / static_cast<double>(n);
  // |tip - begin|^2 = (l + m)^2 with l a length less the usual one, and m the usual one less the zero: linear
  // in begin, m and m^2 - begin^2
  Eigen::MatrixXd a(n, all.fromZero ? 5 : 4);
  Eigen::VectorXd b(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d d = (all.tips[static_cast<std::size_t>(i)] - mean) / size;
    const double l = (all.lengths[static_cast<std::size_t>(i)] - usual) / size;
    a.row(i).head<4>() << 2.0 * d.transpose(), 1.0;
    b[i] = d.squaredNorm() - l * l - (all.fromZero ? 0.0 : 2.0 * l * usual / size);
    if (all.fromZero) a(i, 4) = 2.0 * l;
  }
  if (n < a.cols() || !(size > 0.0) || rankOf(a, kPlane) < a.cols()) return std::nullopt;
  return mean + size * leastSquares(a, b).head<3>();
}

/// The sphere through the tips; their mean where they do not determine one.
Eigen::Vector3d centreOf(const std::vector<Eigen::Vector3d>& tips) {
  const Eigen::Vector3d mean = meanOf(tips);
  double size = 0.0;
  for (const auto& tip : tips) size = std::max(size, (tip - mean).norm());
  return algebraicSphereCentre(tips, size, kFlatPatch).value_or(mean);
}

}  // namespace

void startFreeFeatures(Session& session) {
  for (std::size_t f = 0; f < session.artifact.features.size(); ++f) {
    Feature& feature = session.artifact.features[f];
    if (feature.known || !feature.position.hasNaN()) continue;
    Lengths touched, measured;
    const Observation* first = nullptr;  // of the placement and stylus by which it is told
    for (const Observation& o : session.observations) {
      if (o.feature != static_cast<int>(f)) continue;
      if (first == nullptr) first = &o;
      if (o.placement != first->placement || o.stylus != first->stylus) continue;
      Lengths& mine = o.kind == ObservationKind::kLength ? measured : touched;
      mine.tips.push_back(session.nominalProbe(o).position);
      mine.lengths.push_back(o.length);
      mine.fromZero = o.setup >= 0;
    }
    if (!touched.tips.empty()) {
      feature.position = feature.kind == FeatureKind::kBall ? centreOf(touched.tips) : meanOf(touched.tips);
    } else if (measured.tips.empty()) {
      feature.position.setZero();
    } else if (const auto begin = beginOf(measured)) {
      feature.position = *begin;
    } else {
      throw InputError(
          session.source + ": where '" + feature.name + "' stands is not told by its " +
          std::to_string(measured.tips.size()) +
          " lengths (too few, or all tips on a plane); state about where in the artifact file: " +
          "position_mm: [x, y, z]");
    }
  }
}

}  // namespace mm
