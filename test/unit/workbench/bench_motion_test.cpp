// Who may move the machine, and what stops it.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <future>

#include "bench_fixture.h"

namespace mm {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
class BenchMotionTest : public test::BenchTest {
 protected:
  /// A plan that the machine runs until it is cancelled. @return the answer to who asked for it.
  WebAnswer runningPlan() {
    machine_.runsUntilCancelled = true;
    start(true);
    arm();
    const WebAnswer plan = bench_->post("/action/run", "", R"({"client": 1, "plan": "name: p"})", "test");
    EXPECT_TRUE(machine_.waitForOrders(1));
    return plan;
  }
};

TEST_F(BenchMotionTest, WithoutAMachineNothingMoves) {
  start();
  for (const char* motion : {"arm", "stop", "home", "run"})
    EXPECT_FALSE(act(motion, {{"client", 1}})["ok"]) << motion;
  EXPECT_TRUE(live()["machine"].is_null());
}

TEST_F(BenchMotionTest, AMachineThatAStopDoesNotReachIsNotArmed) {
  start(true);
  bench_->came(1);
  machine_.setDeaf("/axis_driver/stop is not connected");
  const json refused = act("arm", {{"client", 1}});
  EXPECT_FALSE(refused["ok"]);
  EXPECT_NE(
      refused["message"].get<std::string>().find("a stop would not reach the machine: /axis_driver/stop"),
      std::string::npos);
  EXPECT_EQ(live()["machine"]["no_stop"], "/axis_driver/stop is not connected");
  machine_.setDeaf("");
  EXPECT_EQ(live()["machine"]["no_stop"], "");
  arm();
  EXPECT_FALSE(live()["armed"].is_null());
  machine_.setDeaf("/axis_driver/stop is not connected");
  EXPECT_TRUE(machine_.waitForStops(1));
  EXPECT_FALSE(act("home", {{"client", 1}})["ok"]) << "its loss disarms";
}

TEST_F(BenchMotionTest, OnlyThePageThatIsArmedMovesTheMachine) {
  start(true);
  EXPECT_FALSE(act("home", {{"client", 1}})["ok"]);
  EXPECT_FALSE(act("arm", {{"client", 0}})["ok"]);
  const json unknown = act("arm", {{"client", 1}});
  EXPECT_FALSE(unknown["ok"]) << "nobody would notice if that page went";
  EXPECT_NE(unknown["message"].get<std::string>().find("no live connection"), std::string::npos);
  bench_->came(1);
  bench_->came(2);
  const std::uint64_t before = told_;
  EXPECT_TRUE(act("arm", {{"client", 1}, {"who", "Ada"}})["ok"]);
  EXPECT_GT(told_, before) << "the page learns of it late";
  const json second = act("arm", {{"client", 2}});
  EXPECT_FALSE(second["ok"]);
  EXPECT_NE(second["message"].get<std::string>().find("Ada"), std::string::npos);
  EXPECT_FALSE(act("run", {{"client", 2}, {"plan", "p"}})["ok"]);
  EXPECT_EQ(act("disarm", {{"client", 2}})["message"], "this page does not hold the machine");
  EXPECT_EQ(act("home", {{"client", 1}})["message"], "homed");
  bench_->gone(2);
  EXPECT_EQ(machine_.stops, 0);
  bench_->gone(1);
  EXPECT_EQ(machine_.stops, 1) << "the page that held the machine has gone, and it moves on";
  EXPECT_TRUE(live()["armed"].is_null());
  EXPECT_FALSE(act("home", {{"client", 1}})["ok"]);
  EXPECT_FALSE(act("arm", {{"client", 1}})["ok"]) << "it has gone";
  EXPECT_TRUE(act("stop")["ok"]) << "anybody may stop it";
  EXPECT_EQ(act("promote", {{"id", "c7"}})["message"], "c7 is active, says the machine");
  EXPECT_EQ(act("rollback")["message"], "nothing was active before");
}

TEST_F(BenchMotionTest, AMotionThatWaitedBeginsOnlyIfThePageIsStillThere) {
  start(true);
  arm();
  const WebAnswer first = bench_->post("/action/diagnose", "", "{}", "test");
  const WebAnswer home = bench_->post("/action/home", "", R"({"client": 1})", "test");
  bench_->gone(1);
  EXPECT_TRUE(ended(first)["ok"]);
  const json end = ended(home);
  EXPECT_FALSE(end["ok"]) << end;
  EXPECT_NE(end["message"].get<std::string>().find("was disarmed or armed again"), std::string::npos);
}

TEST_F(BenchMotionTest, AfterAStopNothingMovesThatWasAskedBefore) {
  start(true);
  arm();
  machine_.holdUp();
  const WebAnswer first = bench_->post("/action/home", "", R"({"client": 1})", "test");
  const WebAnswer second = bench_->post("/action/run", "", R"({"client": 1, "plan": "name: p"})", "test");
  ASSERT_TRUE(machine_.waitForOrders(1));
  EXPECT_TRUE(act("stop")["ok"]);
  EXPECT_TRUE(live()["armed"].is_null());
  ASSERT_TRUE(act("arm", {{"client", 1}})["ok"]);  // armed anew: what was asked before is not meant
  machine_.letThrough();
  ended(first);
  const json end = ended(second);
  EXPECT_FALSE(end["ok"]) << "it moved again after a stop: " << end;
  EXPECT_EQ(machine_.orders, 1);
  EXPECT_TRUE(act("home", {{"client", 1}})["ok"]) << "and what is asked now moves";
}

TEST_F(BenchMotionTest, AnOrderThatWasOnItsWayWhenItWasStoppedIsStoppedToo) {
  machine_.homesByItself = false;
  for (const char* how : {"stop", "disarm", "gone", "end"}) {
    start(true);
    arm();
    machine_.holdUp();
    const int stops = machine_.stops;
    const int orders = machine_.orders;
    const WebAnswer home = bench_->post("/action/home", "", R"({"client": 1})", "test");
    ASSERT_TRUE(machine_.waitForOrders(orders + 1));
    std::future<void> over;
    if (how == std::string("gone"))
      bench_->gone(1);
    else if (how == std::string("end"))
      over = std::async(std::launch::async, [this] { bench_.reset(); });
    else
      act(how, {{"client", 1}});
    ASSERT_TRUE(machine_.waitForStops(stops + 1)) << how;
    machine_.letThrough();  // the order arrives after the stop, and the machine begins to move
    if (over.valid()) {
      over.get();
      continue;
    }
    const json end = ended(home);
    EXPECT_EQ(end["message"], "stopped") << how << ": " << end;
  }
}

TEST_F(BenchMotionTest, APlanEndsWithItsArming) {
  const WebAnswer plan = runningPlan();
  act("stop");
  EXPECT_EQ(ended(plan)["message"], "the plan was cancelled");
}

TEST_F(BenchMotionTest, APauseHoldsNobodyUp) {
  runningPlan();
  machine_.pauseHeldUp = true;
  const WebAnswer pause = bench_->post("/action/pause", "", R"({"client": 1})", "test");
  EXPECT_EQ(pause.status, 202u);
  bench_->heard(1, "heartbeat");  // heard while the service has not answered yet
  {
    const std::lock_guard<std::mutex> lock(machine_.mutex);
    machine_.pauseHeldUp = false;
  }
  machine_.changed.notify_all();
  EXPECT_EQ(ended(pause)["message"], "paused") << "and it did not wait for the end of the plan";
  EXPECT_EQ(act("continue", {{"client", 1}})["message"], "goes on");
}

TEST_F(BenchMotionTest, WithoutAHeartbeatTheMachineIsStopped) {
  heartbeat_ = 100ms;
  start(true);
  arm();
  bench_->heard(1, "heartbeat");
  EXPECT_THROW(bench_->heard(1, "move"), InputError);
  EXPECT_TRUE(machine_.waitForStops(1));
  EXPECT_TRUE(live()["armed"].is_null());
}

TEST_F(BenchMotionTest, ADiskThatDoesNotAnswerStopsNoStop) {
  std::filesystem::create_directory(folder_.path("store"));
  const std::filesystem::path log = folder_.path("store") / "workbench.log";
  ASSERT_EQ(::mkfifo(log.c_str(), 0600), 0);  // whoever opens it to write waits for a reader
  heartbeat_ = 100ms;
  auto reader = std::async(std::launch::async, [&] {
    const bool stopped = machine_.waitForStops(2);
    return std::make_pair(::open(log.c_str(), O_RDWR | O_NONBLOCK), stopped);
  });
  start(true);
  arm();
  bench_->gone(1);
  bench_->came(1);
  bench_->post("/action/arm", "", R"({"client": 1})", "test");  // and its heartbeat stays away
  const auto [file, stopped] = reader.get();
  EXPECT_TRUE(stopped);
  ASSERT_GE(file, 0);
  bench_.reset();
  std::string text(1 << 16, ' ');
  const ssize_t got = ::read(file, text.data(), text.size());
  text.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  EXPECT_NE(text.find("no heartbeat"), std::string::npos) << text;
  ::close(file);
}

TEST_F(BenchMotionTest, WhatIsCancelledBeforeItBeganIsSaid) {
  const WebAnswer plan = runningPlan();
  const WebAnswer waits = bench_->post("/action/diagnose", "", R"({"who": "Ada"})", "test");
  EXPECT_EQ(live()["pending"], json::parse("[1,2]"));
  EXPECT_EQ(live()["asked"], 2);
  EXPECT_TRUE(act("cancel", {{"who", "Bob"}})["ok"]);
  const json end = ended(waits);
  EXPECT_FALSE(end["ok"]);
  EXPECT_EQ(end["message"], "cancelled before it began");
  EXPECT_FALSE(ended(plan)["ok"]);
  EXPECT_TRUE(live()["pending"].empty());
  const std::string log = data("log").dump();
  EXPECT_NE(log.find("diagnose: cancelled before it began, by Bob (test)"), std::string::npos) << log;
}

}  // namespace
}  // namespace mm
