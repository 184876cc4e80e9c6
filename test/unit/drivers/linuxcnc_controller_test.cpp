#include "drivers/linuxcnc_controller.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <future>
#include <sstream>

#include "base/error.h"
#include "device_double.h"
#include "drivers/motion_control.h"

namespace mm {
namespace {

// s for a stop to come through: the machine's as much as the driver's. One that waits behind what blocks the
// device takes seconds.
constexpr double kLate = 0.5;

/// LinuxCNC's double with X Y Z A B and a ball at x 20, y 30, z 10 mm.
class LinuxCncTest : public ::testing::Test {
 protected:
  static Machine fiveAxes() {
    std::ifstream in("test/ros/linuxcnc/machine.urdf");
    std::stringstream text;
    text << in.rdbuf();
    return Machine(text.str(), "machine.urdf");
  }
  void SetUp() override {
    controller_->open(controllerSetup(machine_, {{"address", double_.address()},
                                                 {"coordinates", "XYZAB"},
                                                 {"poll_rate", "100"},
                                                 {"connect_timeout", "0.8"}}));
    MotionControl::Settings settings;
    settings.reconnect = 0.1;
    settings.restTimeout = 0.8;
    control_ = std::make_unique<MotionControl>(controller_, machine_, settings);
    loop_ = std::thread([this] {
      while (!ending_) {
        std::this_thread::sleep_for(std::chrono::milliseconds(4));
        const auto seen = control_->cycle(4e-3, steadySeconds());
        const std::lock_guard<std::mutex> lock(mutex_);
        if (seen) edges_.insert(edges_.end(), seen->edges.begin(), seen->edges.end());
      }
    });
  }
  void TearDown() override {
    ending_ = true;
    if (loop_.joinable()) loop_.join();
    control_.reset();
  }
  bool await(const std::function<bool()>& condition, double seconds = 5.0) {
    const double end = steadySeconds() + seconds;
    while (steadySeconds() < end && !condition()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return condition();
  }
  AxesMotion to(const std::vector<double>& mm, double speed, bool probing) {
    std::vector<double> target(5, 0.0);
    for (std::size_t j = 0; j < 3; ++j) target[j] = mm[j] * 1e-3;
    AxesMotion motion =
        straightMotion(machine_.joints(), control_->view().state.position, target, speed, 0.7);
    motion.probing = probing;
    return motion;
  }
  MotionControl::Report go(const std::vector<double>& mm, double speed = 0.04, bool probing = false) {
    return control_->move(to(mm, speed, probing), {"test", 0}, control_->stops());
  }
  std::future<MotionControl::Report> start(const std::vector<double>& mm, double speed) {
    const AxesMotion motion = to(mm, speed, false);
    const std::uint32_t stops = control_->stops();
    auto report = std::async(std::launch::async, [=] { return control_->move(motion, {"test", 0}, stops); });
    EXPECT_TRUE(await([&] { return double_.tell("machine")["moving"].get<bool>(); }));
    return report;
  }
  std::string refusal(const std::function<void()>& call) {
    try {
      call();
    } catch (const std::exception& e) {
      return e.what();
    }
    return {};
  }
  void ready() {
    ASSERT_TRUE(await([&] { return refusal([&] { control_->resetEmergencyStop(); }).empty(); }));
    ASSERT_TRUE(await([&] { return refusal([&] {
                                     control_->home({}, {"test", 0});
                                   })
                                .empty(); }, 10.0))
        << control_->view().fault;
  }
  void expectWords(const std::string& text, const std::string& words) {
    EXPECT_NE(text.find(words), std::string::npos) << text;
  }

  Machine machine_ = fiveAxes();
  DeviceDouble double_{{"test/doubles/linuxcnc_double.py", "--ball", "20", "30", "10", "5"}};
  std::shared_ptr<LinuxCncController> controller_ = std::make_shared<LinuxCncController>();
  std::unique_ptr<MotionControl> control_;
  std::atomic<bool> ending_{false};
  std::mutex mutex_;
  std::vector<ProbeEdge> edges_;
  std::thread loop_;
};

TEST_F(LinuxCncTest, HomesGoesProbesStops) {
  expectWords(refusal([&] { control_->home({}, {"test", 0}); }), "emergency stop");
  ready();
  ASSERT_EQ(go({20, 30, 17}).outcome, Outcome::kReached);
  MotionControl::Report report = go({20, 30, 14}, 3e-3, true);
  ASSERT_EQ(report.outcome, Outcome::kTripped) << report.message;
  ASSERT_TRUE(await([&] {
    const std::lock_guard<std::mutex> lock(mutex_);
    return !edges_.empty();
  }));
  EXPECT_TRUE(edges_[0].probing && edges_[0].actual);
  EXPECT_NEAR(edges_[0].position[2], 16e-3, 5e-6) << "work offsets taken off";
  EXPECT_EQ(go({20, 30, 25}).outcome, Outcome::kReached);
  report = go({20, 30, 5});
  EXPECT_EQ(report.outcome, Outcome::kTripped);
  EXPECT_EQ(go({20, 30, 25}).outcome, Outcome::kReached);
  auto stopped = start({100, 30, 25}, 0.01);
  control_->stop("/panel");
  EXPECT_EQ(stopped.get().outcome, Outcome::kStopped);
  EXPECT_FALSE(double_.tell("machine")["moving"]);
  auto held = start({60, 30, 25}, 0.03);
  control_->hold(true);
  ASSERT_TRUE(await([&] { return control_->view().state.held; }));
  control_->hold(false);
  report = held.get();
  EXPECT_EQ(report.outcome, Outcome::kReached) << report.message;
  EXPECT_EQ(refusal([&] { control_->home({"z"}, {"test", 0}); }), "");
}

TEST_F(LinuxCncTest, EveryFaultOfTheLineIsSaidAndTheEmergencyStopComesThrough) {
  const std::vector<std::pair<std::string, std::string>> faults = {{"off", "the connection ended"},
                                                                   {"stuck", "has given no state"},
                                                                   {"garbage", "no language of linuxcncrsh"},
                                                                   {"wrong", "the position of x jumped by"},
                                                                   {"slow", "late"},
                                                                   {"intermittent", "has given no state"}};
  for (const auto& [fault, words] : faults) {
    ready();
    ASSERT_EQ(go({0, 0, 4}).outcome, Outcome::kReached) << fault;
    auto report = start({-90, 0, 4}, 0.01);
    double_.tell("fault " + fault);
    const MotionControl::Report ended = report.get();
    std::printf("linuxcnc %s: %s, %s\n", fault.c_str(), outcomeName(ended.outcome).c_str(),
                ended.message.c_str());
    EXPECT_EQ(ended.outcome, Outcome::kLost) << fault;
    // of the watches of a silent line the one that bites first speaks
    EXPECT_TRUE(ended.message.find(words) != std::string::npos ||
                ended.message.find("has not answered") != std::string::npos ||
                ended.message.find("states arrive") != std::string::npos)
        << ended.message;
    EXPECT_FALSE(double_.tell("machine")["moving"]) << fault;
    const double asked = steadySeconds();
    const std::string failed = control_->emergencyStop("/panel");
    EXPECT_LT(steadySeconds() - asked, kLate) << fault;
    if (fault != "off") {
      EXPECT_EQ(failed, "") << fault;
      EXPECT_TRUE(await([&] {
        const auto machine = double_.tell("machine");
        return machine["told"].back()[0] == "reset" &&
               machine["told"].back()[1].get<double>() - asked < kLate;
      })) << fault;
    }
    double_.tell("fault ok");
    ASSERT_TRUE(await([&] { return control_->view().lost.empty(); }, 10.0))
        << fault << ": " << control_->view().lost;
  }
}

}  // namespace
}  // namespace mm
