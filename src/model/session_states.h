#pragma once
#include <memory>
#include <vector>

#include "effects/domain.h"
#include "effects/state.h"
#include "model/series_history.h"
#include "session/geometric_start.h"
#include "session/session.h"

namespace mm {

/// Courses of the temperatures as they were read, or without the scatter of the readings (`smoothed`).
enum class Temperatures { kAsLogged, kSmoothed };

/// The inputs of the effects at every observation of a session, in its order. The states point to a history
/// that this object keeps: it must outlive them.
class SessionStates {
 public:
  /// @param domain of the model: gives the order of sensors, covariates and features; one that the session
  /// does not have is NaN (or -1) in the states. @throw InputError when its joints are not those of the
  /// session's machine.
  SessionStates(const Session& session, const Domain& domain,
                Temperatures temperatures = Temperatures::kAsLogged);

  const std::vector<State>& states() const { return states_; }  ///< one an observation, SI
  const State& operator[](std::size_t observation) const { return states_[observation]; }
  std::size_t size() const { return states_.size(); }  ///< number of observations

  /// Points the contacts of a touch probe whose approach was not recorded from the nominal tip to the centre
  /// of their feature, and gives the contacts of a laser on a ball the surface's normal.
  void aim(const GeometricStart& start);

 private:
  std::vector<std::shared_ptr<const SeriesHistory>> histories_;  // a recording
  std::vector<State> states_;
  struct Seen {
    int aimAt = -1;      // feature of the artifact to aim at
    int surfaceOf = -1;  // ball whose surface a laser sees
    int placement = 0, stylus = 0;
  };
  std::vector<Seen> seen_;  // an observation
};

}  // namespace mm
