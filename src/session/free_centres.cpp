#include "session/free_centres.h"

#include <algorithm>
#include <vector>

#include "session/sphere_centre.h"

namespace mm {
namespace {

/// A pivot below this part of the largest: contacts on a flat patch say too little about the centre.
constexpr double kFlatPatch = 1e-3;

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
    std::vector<Eigen::Vector3d> tips;
    const Observation* first = nullptr;  // of the placement and stylus by which it is told
    for (const Observation& o : session.observations) {
      if (o.kind != ObservationKind::kContact || o.feature != static_cast<int>(f)) continue;
      if (first == nullptr) first = &o;
      if (o.placement == first->placement && o.stylus == first->stylus)
        tips.push_back(session.nominalProbe(o).position);
    }
    if (tips.empty())
      feature.position.setZero();
    else
      feature.position = feature.kind == FeatureKind::kBall ? centreOf(tips) : meanOf(tips);
  }
}

}  // namespace mm
