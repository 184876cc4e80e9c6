#include "estimation/noise_rows.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace mm {

Directions directionsOf(const Linearisation& at, const std::vector<int>& used) {
  const Problem& problem = at.problem();
  const int rows = static_cast<int>(used.size());
  const ErrorLayout layout = problem.model().machine().layout();
  Directions directions;
  const auto add = [&](const std::string& name, auto value) {
    Eigen::VectorXd column(rows);
    for (int i = 0; i < rows; ++i) column[i] = value(used[i]);
    if (!(column.norm() > 0.0)) return;
    directions.names.push_back(name);
    directions.factors.conservativeResize(rows, directions.names.size());
    directions.factors.rightCols<1>() = column;
  };
  const auto& joints = problem.model().machine().joints();
  const auto& g = at.slotGradients();
  std::set<std::string> taken;
  const char* const axes[] = {"x", "y", "z"};
  for (int j = 0; j < static_cast<int>(joints.size()); ++j)
    if (joints[j].kind == JointKind::kLinear ||
        std::any_of(problem.rows().begin(), problem.rows().end(), [](auto& r) { return r.angular; })) {
      add(joints[j].name, [&](int row) { return g(row, layout.axis(j)); });
      taken.insert(joints[j].name);
    }
  bool linear = std::any_of(problem.rows().begin(), problem.rows().end(), [](auto& r) { return !r.angular; });
  for (int k = 0; k < 3 && linear; ++k)
    if (!taken.count(axes[k])) add(axes[k], [&](int row) { return g(row, layout.volume(k)); });
  add("approach", [&](int row) {
    const Eigen::Vector3d a = problem.state(problem.rows()[row].observation).approach;
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) sum += a[k] * g(row, layout.volume(k));
    return std::isfinite(sum) ? sum : 0.0;
  });
  return directions;
}

LinearisedRows noiseRows(const Linearisation& at, const std::vector<int>& used, const Eigen::VectorXd& sigma,
                         Eigen::VectorXd target, RowMatrix base) {
  LinearisedRows out;
  const Problem& problem = at.problem();
  const Directions directions = directionsOf(at, used);
  const int n = static_cast<int>(used.size()), count = static_cast<int>(directions.names.size());
  double unit = 0.0;  // m or rad of a row of unit noise
  for (const int row : used) unit += sigma[row] / n;
  for (const int row : used)
    out.rows.time.push_back(problem.session().observations[problem.rows()[row].observation].time);
  out.rows.factors.resize(n, count);
  for (int d = 0; d < count; ++d) {
    const double size = std::sqrt(directions.factors.col(d).squaredNorm() / n);
    // along a direction of unit factors the drift is in the unit of the rows; a turn that acts on a lever is
    // not
    const double scale = size > 0.1 && size < 10.0 ? unit : unit / size;
    out.directions.push_back(directions.names[d]);
    out.directionScale.push_back(scale);
    for (int i = 0; i < n; ++i) out.rows.factors(i, d) = directions.factors(i, d) * scale / sigma[used[i]];
  }
  out.rows.target = std::move(target);
  out.rows.base = std::move(base);
  return out;
}

}  // namespace mm
