#pragma once
#include <optional>
#include <string>
#include <vector>

#include "drivers/axis_controller.h"

namespace mm {

/// Makes one trip of the edges of a probe's switch: its first closing edge, once the switch has stayed
/// closed. What bounces is swallowed; what was latched is always that of the first edge.
class ProbeDebounce {
 public:
  struct Settings {
    double settle = 2e-3;    // s that the switch must be closed in the end
    double longest = 20e-3;  // s after the first edge within which it must have settled
    double stuck = 5.0;      // s closed outside of a probing motion: stuck
  };

  explicit ProbeDebounce(Settings settings) : settings_(settings) {}  ///< settings in s
  ProbeDebounce() : ProbeDebounce(Settings()) {}

  /// @param edges since the last call, oldest first. @param state after them, on their clock. @param probing
  /// a probing motion is under way. @return trips that have settled since.
  std::vector<ProbeEdge> take(const std::vector<ProbeEdge>& edges, const AxesState& state, bool probing);

  /// What is wrong with the switch, for people; empty: nothing.
  const std::string& complaint() const { return complaint_; }
  int bounces() const { return bounces_; }  ///< edges swallowed
  int jolts() const { return jolts_; }      ///< closings that did not last
  void forget();                            ///< a trip that has not settled; e.g. after a reset

 private:
  void takeEdge(const ProbeEdge& edge);
  void settle(double time, std::vector<ProbeEdge>& trips);
  void watchLevel(const AxesState& state, bool probing);

  Settings settings_;
  std::optional<ProbeEdge> pending_;
  double lastEdge_ = 0.0;
  bool level_ = false;                 // after the edges so far
  bool settled_ = false;               // this closing was a trip, or a jolt
  std::optional<double> closedSince_;  // outside of probing
  std::string complaint_;
  int bounces_ = 0, jolts_ = 0;
};

}  // namespace mm
