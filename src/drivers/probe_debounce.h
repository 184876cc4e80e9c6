#pragma once
#include <optional>
#include <string>

#include "drivers/axis_controller.h"

namespace mm {

/// Makes one contact of the edges of a probe's switch: the first closing edge of a probing motion, once the
/// switch has stayed closed. What bounces is swallowed; the latched position is always that of the first
/// edge.
class ProbeDebounce {
 public:
  struct Settings {
    double settle = 2e-3;    // s that the switch must be closed in the end
    double longest = 20e-3;  // s after the first edge within which it must have settled
    double stuck = 5.0;      // s closed outside of a probing motion: stuck
  };

  explicit ProbeDebounce(Settings settings) : settings_(settings) {}  ///< settings in s
  ProbeDebounce() : ProbeDebounce(Settings()) {}

  /// Edges in the order of their time.
  void edge(const ProbeEdge& edge);
  /// @param time s on the clock of the edges. @param closed the switch's level now. @param probing a probing
  /// motion is under way. @return a contact that has just been confirmed.
  std::optional<ProbeEdge> poll(double time, bool closed, bool probing);

  /// What is wrong with the probe, for people; empty: nothing.
  const std::string& complaint() const { return complaint_; }
  int bounces() const { return bounces_; }  ///< edges swallowed
  int refused() const { return refused_; }  ///< trips that gave no contact
  /// Forgets everything; e.g. after the clock went back.
  void reset();

 private:
  void refuse(const std::string& why);

  Settings settings_;
  std::optional<ProbeEdge> pending_;
  double lastEdge_ = 0.0;
  bool level_ = false;                 // after the edges so far
  bool settled_ = false;               // the contact of this closing was given or refused
  std::optional<double> closedSince_;  // outside of probing
  std::string complaint_;
  int bounces_ = 0, refused_ = 0;
};

}  // namespace mm
