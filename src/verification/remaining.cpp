#include <cmath>

#include "verification/decision.h"
#include "verification/figures.h"
#include "verification/loading_evidence.h"
#include "verification/verify_words.h"

namespace mm {

void fillShares(const FreshPoints& points, const PointSystem& system, const Calibration& calibration,
                bool loaded, Verification& found) {
  const LoadingEvidence evidence(points, system, calibration);
  const Projection& projection = evidence.asCalibrated();
  const int count = static_cast<int>(points.axes().size());
  Eigen::MatrixXd own(points.length(), count + (points.hasOffsets() ? 1 : 0));
  for (int a = 0; a < count; ++a) own.col(a) = points.own(a);
  if (points.hasOffsets()) own.col(count) = points.offsets();
  const bool restIsThere = !loaded || points.tabled();  // no table has it
  const Eigen::VectorXd raw = points.raw() - (restIsThere ? 1.0 : 0.0) * points.rest();
  const Eigen::VectorXd y = projection.left(system.whiten(raw));
  const auto remaining = [&](double share) { return loaded ? share : 1.0 - share; };
  const Eigen::VectorXd ownSizes = rmsOf(points, own), effectSizes = rmsOf(points, points.byEffect());
  const Shares axes = sharesOf(projection.left(system.whiten(own)), y);
  for (int a = 0; a < count; ++a) {
    RemainingOfAxis axis;
    axis.axis = points.axes()[static_cast<std::size_t>(a)];
    axis.size = ownSizes[a];
    axis.remaining = remaining(axes.value[a]);
    axis.std = axes.std[a];
    axis.inWords = inWords(axis);
    found.axes.push_back(axis);
  }
  if (points.hasOffsets()) {
    RemainingShare offsets;
    offsets.size = ownSizes[count];
    offsets.remaining = remaining(axes.value[count]);
    offsets.std = axes.std[count];
    offsets.inWords = inWords(offsets);
    found.offsets = offsets;
  }
  const Eigen::VectorXd all = projection.left(system.whiten(points.raw()));
  const Eigen::MatrixXd columns = projection.left(system.whiten(points.byEffect()));
  const Shares effects = sharesOf(columns, all);
  const Eigen::VectorXd notCarried =
      points.tabled() ? sharesOf(columns, projection.left(system.whiten(points.rest()))).value
                      : Eigen::VectorXd::Zero(columns.cols());
  for (std::size_t e = 0; e < points.effects().size(); ++e) {
    const auto k = static_cast<Eigen::Index>(e);
    RemainingOfEffect effect;
    effect.effect = calibration.effects[static_cast<std::size_t>(points.indices()[e])];
    effect.size = effectSizes[k];
    effect.remaining = remaining(effects.value[k]);
    effect.std = effects.std[k];
    effect.notCarried = notCarried[k];
    effect.inWords = inWords(effect);
    found.effects.push_back(effect);
  }
  // What the offsets leave is no other axis's correction.
  const Shares crossed = sharesOf(
      projection.left(system.whiten(beside({points.crossed(), own.rightCols(own.cols() - count)}))), y);
  constexpr double kThere = 4.0, kTold = 0.25;
  for (int on = 0; on < count; ++on)
    for (int of = 0; of < count; ++of) {
      const int k = on * count + of;
      if (on == of || !(crossed.std[k] < kTold) || std::abs(crossed.value[k]) < kThere * crossed.std[k])
        continue;
      found.crossed.push_back({points.axes()[static_cast<std::size_t>(of)],
                               points.axes()[static_cast<std::size_t>(on)],
                               loaded ? -crossed.value[k] : crossed.value[k], crossed.std[k]});
    }
}

}  // namespace mm
