#pragma once
#include <functional>
#include <string>
#include <vector>

#include "session/plan.h"

namespace mm {

/// Writes the moves of a plan as YAML: every joint in each, groups that are repeated. m, rad, s.
class PlanScript {
 public:
  using Readings = std::vector<double>;  // of all joints, m or rad

  explicit PlanScript(const Machine& machine) : machine_(machine) {}  ///< outlives it

  /// A point at which the lengths of a beam begin. @return its index.
  int addPoint(const std::string& name, const Eigen::Vector3d& workpiece);
  void remark(const std::string& text) { text_ += indent() + "# " + text + "\n"; }
  void go(const Readings& to, double wait = 0.0);
  void deviation(int joint, const Readings& at, double wait, const std::string& setup);
  void position(const Readings& at, double wait, const std::string& setup);
  void length(int point, const Readings& at, double wait);  ///< its setup is the name of the point
  void repeat(int times, const std::function<void()>& group);

  /// Keys `artifact` and `moves`; empty: nothing was written.
  std::string yaml() const;

 private:
  std::string indent() const { return std::string(2 + 4 * static_cast<std::size_t>(depth_), ' '); }
  void write(PlanMove move);

  const Machine& machine_;
  Plan plan_;  // its artifact
  std::string text_;
  int depth_ = 0;
};

}  // namespace mm
