#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "session/session.h"

namespace mm {

/// What the workbench asks of a machine that is there, whatever stands between (ROS, or a double in a test).
class LiveMachine {
 public:
  struct State {
    std::vector<double> readings;  // a joint of the machine, m or rad; NaN: not known
    bool moving = false;
    Eigen::Vector3d nominal = Eigen::Vector3d::Constant(kNotMeasured);    // tip in workpiece, m
    Eigen::Vector3d corrected = Eigen::Vector3d::Constant(kNotMeasured);  // NaN: not published
    Eigen::Vector3d candidate = Eigen::Vector3d::Constant(kNotMeasured);
    double sigma = kNotMeasured;  // m, of the corrected tip
    std::string calibration;      // id of the active one; empty: none
    std::string status;           // why nothing is corrected, in the words of the service; empty: all is well
    std::size_t observations = 0;  // of the live session
    std::string measuring;         // the plan that runs, in words; empty: none
    double share = 0.0;            // of it that is done
  };

  virtual ~LiveMachine() = default;
  virtual const Machine& machine() const = 0;  ///< as it was described
  virtual State state() = 0;                   ///< now; returns at once, from any thread
  /// The session that was measured so far. @throw InputError: there is nothing yet.
  virtual Session session() = 0;
  /// Nominal tips of its contacts (m, workpiece), as they came; quick, from any thread.
  virtual std::vector<Eigen::Vector3d> contacts() = 0;
  /// Namespace of the nodes that measure, "/" or "/m1".
  virtual std::string space() const = 0;
  /// The next three wait for their answer. @return it. @throw InputError: refused, in the words of the
  /// service.
  virtual std::string promote(const std::string& id) = 0;
  virtual std::string rollback(const std::string& id) = 0;
  virtual std::string home() = 0;
  /// Measures a plan. @param yaml of the plan. @param cancelled asked now and then: ends the plan. @return
  /// what became of it. @throw InputError.
  virtual std::string run(const std::string& yaml, const std::function<bool()>& cancelled) = 0;
  virtual std::string pause(bool yes) = 0;  ///< between two contacts
  /// Why `stop` would not reach the machine, for people; empty: it would. Returns at once.
  virtual std::string deaf() = 0;
  /// Every motion ends, as fast as the axes may. Returns at once: it is asked for when a page has gone.
  virtual void stop() = 0;
};

}  // namespace mm
