#pragma once
#include <map>
#include <string>
#include <vector>

#include "session/plan.h"

namespace mm {

/// Puts the moves of a plan together: keeps within the machine's limits, goes round the balls, and knows
/// where the probe touches when everything is where it should be. SI units.
class PlanBuilder {
 public:
  PlanBuilder(Plan& plan, const Machine& machine);

  double approachDistance = 1.5e-3;  // m before the surface
  double overtravel = 1.0e-3;        // m beyond the expected contact
  double approachSpeed = 2e-3;       // m/s
  double overrun = 0.2e-3;           // m beyond a position that is to be reached from one side
  double overrunRotary = 0.0175;     // rad
  std::map<int, double> clearance;   // a joint: reading at which everything can be passed

  const Machine& machine() const { return machine_; }              ///< that moves
  const Plan& plan() const { return plan_; }                       ///< as far as it is built
  const std::vector<double>& current() const { return current_; }  ///< readings, m or rad
  /// How the artifact stands, and what touches it, from the next move on: indices of the plan and its
  /// artifact.
  void stand(int placement, int stylus) { placement_ = placement, stylus_ = stylus; }
  /// Starts a group of moves of one line of the file; messages name it.
  void at(int line, std::string what) { line_ = line, what_ = std::move(what); }

  void go(const std::vector<double>& position, double speed = 0.0, double wait = 0.0);  ///< m or rad, m/s, s
  /// Goes beyond a position on the sides given (-1, +1 or 0 a joint), so that it is then reached from there.
  void comeFrom(const std::vector<int>& sides, std::vector<double> position);
  /// Touches a ball so that the tip's centre would arrive at `contact` (workpiece) along `approach`.
  /// @param sides as for comeFrom, of the start of the approach; may be empty.
  void touchAt(int feature, const Eigen::Vector3d& contact, const Eigen::Vector3d& approach, double speed,
               std::vector<double> rotary, const std::vector<int>& sides = {}, double wait = 0.0);
  /// Touches a ball from a start along a direction; a start too near to the surface is drawn back.
  void touchFrom(int feature, const std::vector<double>& start, Eigen::Vector3d approach, double speed,
                 const std::vector<int>& sides, double wait);
  void readLaser(int feature, const std::vector<double>& position, double wait);
  void reference(MoveKind kind, int joint, const std::vector<double>& position, double speed, double wait,
                 const std::string& setup);
  /// Has an instrument measure the length from a point of the artifact to the tip. @throw InputError
  void length(int feature, const std::vector<double>& position, double speed, double wait,
              const std::string& setup);
  /// The moves from number `first` on, so many times more.
  void again(std::size_t first, int times);

  Eigen::Vector3d tip(const std::vector<double>& readings) const;   ///< nominal, of the stylus, workpiece
  Eigen::Vector3d beam(const std::vector<double>& readings) const;  ///< of a laser, workpiece
  /// Linear joints that put the nominal tip there; rotary ones stay. @throw InputError
  std::vector<double> reach(const Eigen::Vector3d& tip, std::vector<double> readings) const;
  bool withinLimits(const std::vector<double>& readings) const;
  /// R + r (m). @throw InputError for a point, or a centre without a start value.
  double contactDistance(int feature) const;
  Eigen::Vector3d centre(int feature) const;  ///< in workpiece, m
  [[noreturn]] void fail(const std::string& message) const;

 private:
  void checkLimits(const std::vector<double>& readings) const;
  void goAround(const std::vector<double>& position);
  bool blocked(const std::vector<double>& from, const std::vector<double>& to) const;
  void checkCount(std::size_t more) const;
  void append(PlanMove move);

  Plan& plan_;
  const Machine& machine_;
  std::vector<double> current_;
  Eigen::Vector3d offset() const;
  int line_ = 0, placement_ = 0, stylus_ = 0;
  std::string what_;
};

}  // namespace mm
