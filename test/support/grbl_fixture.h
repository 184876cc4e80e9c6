#pragma once
#include "drivers/grbl_controller.h"
#include "motion_fixture.h"

namespace mm {

// A ball at x 20, y 30, z 10 mm of the joints; the control's zero lies 40 mm above theirs.
inline const std::vector<std::string> kDouble = {
    "test/doubles/grbl_double.py", "--ball", "-20", "-10", "-30", "5"};
inline const std::vector<double> kNear = {32, 34, 36},
                                 kBeside = {31, 34, 36};  // mm, not far from the switches
inline constexpr const char* kZero = "x:-40 y:-40 z:-40 a:-40 b:-40 c:-40";

/// A grbl control of six axes, as its double, under motion control.
class GrblTest : public DeviceMotionFixture {
 protected:
  GrblTest() : DeviceMotionFixture("test/data/six_axis.urdf") {}
  void begin(std::vector<std::string> extra = {}, AxisController::Parameters parameters = {}) {
    std::vector<std::string> arguments = kDouble;
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    double_ = std::make_unique<DeviceDouble>(arguments);
    connect(std::move(parameters));
  }
  void connect(AxisController::Parameters parameters = {}) {
    controller_ = std::make_shared<GrblController>();
    parameters.emplace("address", double_->address());
    parameters.emplace("zero", kZero);
    parameters.emplace("report_rate", "100");
    parameters.emplace("connect_timeout", std::to_string(kConnect));
    parameters.emplace("silence", std::to_string(linkSilence_));
    parameters.emplace("dead_man", std::to_string(linkSilence_));
    control(controller_, parameters);
  }
  double shown(std::size_t j) { return 1e3 * control_->view().state.position[j]; }

  std::shared_ptr<GrblController> controller_;
};

}  // namespace mm
