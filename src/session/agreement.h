#pragma once
#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <vector>

#include "session/session.h"

namespace mm {

/// How the geometry agrees with the artifact, or with what the instrument found.
struct Agreement {
  double misfit = kNotMeasured;  // m; NaN: nothing to judge by
  double turn = 0.0;             // rad: rotation of the artifact that it takes
  double aligned =
      kNotMeasured;       // mean cosine between recorded approach and the direction to the ball's centre
  double cap = INFINITY;  // least extent of the tips on a ball, in radii; without a layout that says the size
  std::vector<Eigen::Vector3d> centres;
};

/// What is done to the readings of each row, or to its velocities: another unit, a sign, an exchange.
using Change = std::function<void(std::vector<double>&)>;

/// Judges how well the tips of a session lie on the artifact's balls, their centres in its layout, and the
/// readings where an instrument found them. A few hundred rows of each are enough, and one placement and
/// stylus of several: the one that was measured most.
class Geometry {
 public:
  /// @param session prepared; it must outlive this.
  explicit Geometry(const Session& session);
  /// @param change of the readings; may be empty.
  Agreement judge(const Change& change) const;
  /// @param base judge() of the readings as they are. @param change may be empty.
  /// @return mean cosine between the tip's motion by the recorded velocities, changed, and the direction to
  /// the ball's centre, over the touches that have them; NaN: none has.
  double travelling(const Agreement& base, const Change& change) const;
  /// @param names of the feature at each centre. @return m, RMS of a component; 0 where the layout says
  /// nothing. @param turned gets the rotation that it takes.
  double layout(const std::vector<Eigen::Vector3d>& centres, const std::vector<int>& names,
                Agreement& turned) const;
  /// Each feature under its own name.
  std::vector<int> names() const;

 private:
  void judgeFeature(std::size_t feature, const Change& change, Agreement& a, std::vector<double>& within,
                    double& aligned, int& approaches) const;
  Eigen::Vector3d tipOf(const Observation& o, const Change& change) const;
  double positions(const Change& change) const;

  const Session& session_;
  std::vector<std::vector<const Observation*>> of_;
  std::vector<const Observation*> positions_;
  int placement_ = 0, stylus_ = 0;  // that is judged
};

}  // namespace mm
