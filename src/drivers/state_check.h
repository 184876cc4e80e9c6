#pragma once
#include <optional>
#include <string>
#include <vector>

#include "drivers/axis_controller.h"

namespace mm {

/// Says whether what a controller says of its axes can be true: sizes, numbers, a clock that ascends, and no
/// position that the axes could not have reached in the time since.
class StateCheck {
 public:
  StateCheck(std::vector<Joint> joints, std::vector<AxisCapability> capabilities);

  /// @return what is wrong, for people; empty: nothing, and the next state is compared with this one.
  std::string complaint(const AxesState& state);
  /// The last complaint was of a position: the zero of the axes is in doubt.
  bool jumped() const { return jumped_; }
  /// Positions may change: after a reset, or during homing. The next state is taken as it is.
  void forget() { last_.reset(); }

 private:
  std::string sizes(const AxesState& state) const;

  std::vector<Joint> joints_;
  std::vector<AxisCapability> capabilities_;
  std::optional<AxesState> last_;
  bool jumped_ = false;
};

}  // namespace mm
