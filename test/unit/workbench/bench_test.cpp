#include "workbench/bench.h"

#include <gtest/gtest.h>

#include <condition_variable>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "session_files.h"
#include "simulation/simulate.h"
#include "workbench/temporary_file.h"

namespace mm {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

/// A plate that was measured on a machine with 3 um of play in x.
const Session& plate() {
  static const Session session = [] {
    const Machine machine = Machine::load("three_axis");
    SimulationRequest request;
    request.hide = {"backlash:x=3um"};
    request.seed = 5;
    Session measured =
        simulate(machine, Plan::load("config/plans/nine_ball_plate.yaml", machine), request).session;
    measured.source = "plate.bag";
    return measured;
  }();
  return session;
}

/// A machine that does as it is told, and counts.
class ObedientMachine : public LiveMachine {
 public:
  const Machine& machine() const override { return plate().machine; }
  State state() override {
    State s;
    s.readings = {1e-3, 2e-3, 3e-3};
    s.moving = moving;
    s.observations = plate().observations.size();
    return s;
  }
  Session session() override { return plate(); }
  std::vector<Eigen::Vector3d> contacts() override { return {Eigen::Vector3d(1e-3, 2e-3, 3e-3)}; }
  std::string space() const override { return "/"; }
  std::string promote(const std::string& id) override { return id + " is active, says the machine"; }
  std::string rollback(const std::string&) override { throw InputError("nothing was active before"); }
  std::string home() override { return "homed"; }
  std::string run(const std::string& yaml, const std::function<bool()>&) override {
    return "measured " + yaml;
  }
  std::string pause(bool yes) override { return yes ? "paused" : "goes on"; }
  void stop() override {
    const std::lock_guard<std::mutex> lock(mutex);
    ++stops;
    changed.notify_all();
  }
  bool waitForStops(int count) {
    std::unique_lock<std::mutex> lock(mutex);
    return changed.wait_for(lock, 20s, [&] { return stops >= count; });
  }
  bool moving = false;
  int stops = 0;
  std::mutex mutex;
  std::condition_variable changed;
};

class BenchTest : public ::testing::Test {
 protected:
  test::Folder folder_;
  ObedientMachine machine_;
  std::unique_ptr<Bench> bench_;
  std::mutex mutex_;
  std::condition_variable news_;
  std::uint64_t told_ = 0;

  void start(bool live = false) {
    BenchOptions options;
    options.bag = "plate.bag";
    options.store = folder_.path("store");
    BenchSources sources;
    sources.readBag = [](const std::filesystem::path& file, const ProgressCallback&, const Machine*) {
      if (file.filename() != "plate.bag") throw InputError(file.string() + ": is not a bag");
      return plate();
    };
    sources.spaceOf = [](const std::filesystem::path&) { return std::string(); };
    bench_ = std::make_unique<Bench>(options, sources, "secret", live ? &machine_ : nullptr);
    bench_->onNews([this] {
      const std::lock_guard<std::mutex> lock(mutex_);
      ++told_;
      news_.notify_all();
    });
    bench_->begin();
  }
  ~BenchTest() override {
    if (bench_) bench_->onNews({});
  }

  json live() { return json::parse("{" + bench_->live() + "}"); }
  json data(const std::string& name) {
    const WebAnswer answer = bench_->get("/data/" + name);
    return answer.status == 200 ? json::parse(*answer.body) : json();
  }
  /// Asks for an action that takes a while. @return how it ended.
  json act(const std::string& action, const json& body = json::object()) {
    return ended(bench_->post("/action/" + action, "", body.dump(), "test"));
  }
  json ended(const WebAnswer& answer) {
    const json begun = json::parse(*answer.body);
    if (answer.status != 202) return {{"ok", answer.status == 200}, {"message", begun["message"]}};
    std::uint64_t seen = 0;
    for (;;) {
      const json state = live();
      for (const json& e : state["ended"])
        if (e["number"] == begun["number"]) return e;
      std::unique_lock<std::mutex> lock(mutex_);
      if (!news_.wait_for(lock, 120s, [&] { return told_ > seen; }))
        return {{"ok", false}, {"message", "no news"}};
      seen = told_;
    }
  }
};

TEST_F(BenchTest, TheWholeLoop) {
  start();
  const double before = data("compare")["rms_um"];
  EXPECT_GT(before, 0.7);
  const json points = data("points");
  EXPECT_EQ(points["rows"], plate().observations.size());
  for (const json& column : points["columns"])
    EXPECT_EQ(column["values"].size(), points["rows"]) << column["name"];

  const json diagnosed = act("diagnose");
  ASSERT_TRUE(diagnosed["ok"]) << diagnosed;
  EXPECT_NE(diagnosed["message"].get<std::string>().find("backlash of x"), std::string::npos);
  const json missing = data("diagnosis")["missing"];
  ASSERT_EQ(missing.size(), 1u);
  EXPECT_EQ(missing[0]["effect"]["type"], "backlash");

  const json added = act("add", {{"effect", "{type: backlash, axis: x}"}, {"who", "Ada"}});
  ASSERT_TRUE(added["ok"]) << added;
  EXPECT_LT(data("compare")["rms_um"].get<double>(), 0.5 * before);
  const json calibration = data("calibration");
  EXPECT_TRUE(calibration["kept"]);
  ASSERT_EQ(calibration["effects"].size(), 1u);
  EXPECT_NEAR(std::abs(calibration["effects"][0]["values"][0]["value"].get<double>()), 3.0, 0.2);
  EXPECT_GT(calibration["effects"][0]["values"][0]["std"].get<double>(), 0.0);
  EXPECT_EQ(calibration["ledger"].size(), 2u);
  EXPECT_TRUE(data("diagnosis").is_null()) << "a diagnosis of another model stayed";
  EXPECT_EQ(data("points")["before"].size(), points["rows"]);

  const std::string id = calibration["id"];
  EXPECT_EQ(act("promote", {{"id", id}})["message"], id + " is active");
  EXPECT_TRUE(data("history")["calibrations"][0]["active"]);
  EXPECT_EQ(data("correct")["active"]["id"], id);
  EXPECT_GT(data("correct")["active"]["at_mm"].size(), 100u);
  const json verified = act("verify");
  ASSERT_TRUE(verified["ok"]) << verified;
  EXPECT_EQ(verified["message"], data("verify")["in_words"]);

  const json removed = act("remove", {{"effect", "{type: backlash, axis: x}"}});
  ASSERT_TRUE(removed["ok"]) << removed;
  EXPECT_NEAR(data("compare")["rms_um"].get<double>(), before, 0.01);
  EXPECT_TRUE(act("use", {{"id", id}})["ok"]);
  EXPECT_LT(data("compare")["rms_um"].get<double>(), 0.5 * before);

  const json log = data("log")["lines"];
  bool ada = false;
  for (const json& line : log)
    ada = ada || (line["who"] == "Ada (test)" && line["what"].get<std::string>().find("add: ") == 0);
  EXPECT_TRUE(ada) << log;
  EXPECT_NE(test::readAll(folder_.path("store") / "workbench.log").find("Ada (test)"), std::string::npos);
}

TEST_F(BenchTest, RefusalsAreTheServicesWords) {
  start();
  EXPECT_NE(
      act("add", {{"effect", "{type: backlsh, axis: x}"}})["message"].get<std::string>().find("backlash"),
      std::string::npos);
  EXPECT_FALSE(act("remove", {{"effect", "{type: backlash, axis: x}"}})["ok"]);
  EXPECT_FALSE(act("use", {{"id", "../../etc/passwd"}})["ok"]);
  EXPECT_FALSE(act("promote", {{"id", "nosuch"}})["ok"]);
  EXPECT_NE(act("verify")["message"].get<std::string>().find("no calibration is active"), std::string::npos);
  EXPECT_FALSE(act("calibrate", {{"model", "effects: [{type: nothing}]"}})["ok"]);
  EXPECT_FALSE(act("fly")["ok"]);
  EXPECT_THROW(bench_->post("/action/add", "", "{\"efect\": \"x\"}", "test"), InputError);
  EXPECT_EQ(bench_->get("/data/../../etc/passwd").status, 404u);
  EXPECT_EQ(bench_->get("/app/nosuch.js").status, 404u);
  EXPECT_EQ(bench_->post("/upload", "name=x.exe", "abc", "test").status, 415u);
  const json opened = ended(bench_->post("/upload", "name=other.bag", "no bag", "test"));
  EXPECT_FALSE(opened["ok"]);
  EXPECT_NE(opened["message"].get<std::string>().find("is not a bag"), std::string::npos);
  EXPECT_EQ(data("session")["name"], "plate.bag") << "a bag that cannot be read took the session's place";
  EXPECT_TRUE(data("history")["calibrations"].empty()) << "something was written";
}

TEST_F(BenchTest, FormulasAreJudgedAsTheyAreTyped) {
  start();
  const auto judged = [&](const json& body) {
    return json::parse(*bench_->post("/formula", "", body.dump(), "test").body);
  };
  EXPECT_TRUE(judged({{"direction", "x"}, {"formula", "k1*x*y"}})["ok"]);
  for (const char* bad : {"k1*", "k1*nosuch", "x*y", "k1*x)", "((((", "", "k1*x/0*0 +"})
    EXPECT_FALSE(judged({{"direction", "x"}, {"formula", bad}})["ok"]) << bad;
  EXPECT_FALSE(judged({{"direction", "q"}, {"formula", "k1*x"}})["ok"]);
  const auto began = std::chrono::steady_clock::now();
  EXPECT_FALSE(judged({{"direction", "x"}, {"formula", "k1*" + std::string(100000, '(') + "x"}})["ok"]);
  EXPECT_FALSE(judged(
      {{"direction", "x"}, {"formula", std::string(250, '(') + "k1*x" + std::string(240, ')')}})["ok"]);
  EXPECT_LT(std::chrono::steady_clock::now() - began, 5s);
  const json effect = judged({{"direction", "x"}, {"formula", "k1*sin(2*pi*x/k2)"}, {"start", "1, 5"}});
  EXPECT_TRUE(effect["ok"]) << effect;
  EXPECT_NE(effect["effect"].get<std::string>().find("start: [1, 5]"), std::string::npos) << effect;
}

TEST_F(BenchTest, WithoutAMachineNothingMoves) {
  start();
  for (const char* motion : {"arm", "stop", "home", "run"})
    EXPECT_FALSE(act(motion, {{"client", 1}})["ok"]) << motion;
  EXPECT_TRUE(live()["machine"].is_null());
}

TEST_F(BenchTest, OnlyThePageThatIsArmedMovesTheMachine) {
  start(true);
  EXPECT_FALSE(act("home", {{"client", 1}})["ok"]);
  EXPECT_FALSE(act("arm", {{"client", 0}})["ok"]);
  EXPECT_TRUE(act("arm", {{"client", 1}, {"who", "Ada"}})["ok"]);
  const json second = act("arm", {{"client", 2}});
  EXPECT_FALSE(second["ok"]);
  EXPECT_NE(second["message"].get<std::string>().find("Ada"), std::string::npos);
  EXPECT_FALSE(act("run", {{"client", 2}, {"plan", "p"}})["ok"]);
  EXPECT_EQ(act("home", {{"client", 1}})["message"], "homed");
  bench_->gone(2);
  EXPECT_EQ(machine_.stops, 0);
  bench_->gone(1);
  EXPECT_EQ(machine_.stops, 1) << "the page that held the machine has gone, and it moves on";
  EXPECT_TRUE(live()["armed"].is_null());
  EXPECT_FALSE(act("home", {{"client", 1}})["ok"]);
  EXPECT_TRUE(act("stop")["ok"]) << "anybody may stop it";
  EXPECT_EQ(act("promote", {{"id", "c7"}})["message"], "c7 is active, says the machine");
  EXPECT_EQ(act("rollback")["message"], "nothing was active before");
}

TEST_F(BenchTest, AMotionThatWaitedBeginsOnlyIfThePageIsStillThere) {
  start(true);
  ASSERT_TRUE(act("arm", {{"client", 1}})["ok"]);
  const WebAnswer first = bench_->post("/action/diagnose", "", "{}", "test");
  const WebAnswer home = bench_->post("/action/home", "", R"({"client": 1})", "test");
  bench_->gone(1);
  EXPECT_TRUE(ended(first)["ok"]);
  const json end = ended(home);
  EXPECT_FALSE(end["ok"]) << end;
  EXPECT_NE(end["message"].get<std::string>().find("not armed any more"), std::string::npos);
}

TEST_F(BenchTest, WithoutAHeartbeatTheMachineIsStopped) {
  start(true);
  ASSERT_TRUE(act("arm", {{"client", 1}})["ok"]);
  bench_->heard(1, "heartbeat");
  EXPECT_THROW(bench_->heard(1, "move"), InputError);
  EXPECT_TRUE(machine_.waitForStops(1));
  EXPECT_TRUE(live()["armed"].is_null());
}

TEST_F(BenchTest, StatesComeThirtyTimesASecondWhileItMoves) {
  start(true);
  machine_.moving = true;
  EXPECT_LE(bench_->period(), 34ms);
  machine_.moving = false;
  EXPECT_EQ(bench_->period(), 500ms);
  EXPECT_EQ(live()["documents"]["contacts"], plate().observations.size());
  EXPECT_EQ(data("contacts")["at_mm"], json::parse("[[1.0,2.0,3.0]]"));
  EXPECT_EQ(live()["machine"]["readings"], json::parse("[1.0,2.0,3.0]"));
}

TEST_F(BenchTest, ATableOfTheSameMachineIsASessionToo) {
  start();
  const json refused = ended(bench_->post("/upload", "name=t.csv", "x_mm,what\n1,2\n", "test"));
  EXPECT_FALSE(refused["ok"]);
  std::string csv = "time_s,x_mm,y_mm,z_mm,reference_x_mm,reference_y_mm,reference_z_mm\n";
  for (int i = 0; i < 27; ++i) {
    const int x = 5 * (i % 3), y = 5 * (i / 3 % 3), z = 5 * (i / 9);
    const std::string place = std::to_string(x) + "," + std::to_string(y) + "," + std::to_string(z);
    csv += std::to_string(10 * i) + "," + place + "," + place + "\n";
  }
  const json opened = ended(bench_->post("/upload", "name=t.csv", csv, "test"));
  EXPECT_TRUE(opened["ok"]) << opened;
  EXPECT_EQ(data("session")["name"], "t.csv");
  EXPECT_EQ(data("points")["rows"], 81);
}

TEST_F(BenchTest, ThePageNamesNoOtherSite) {
  start();
  const WebAnswer page = bench_->get("/");
  EXPECT_EQ(page.body->find("https://"), std::string::npos);
  EXPECT_NE(page.policy.find("frame-ancestors 'none'"), std::string::npos);
  EXPECT_NE(page.body->find("/t/secret/app/main.js"), std::string::npos);
  EXPECT_EQ(page.body->find("{{"), std::string::npos);
  EXPECT_EQ(bench_->get("/app/main.js").status, 200u);
  EXPECT_EQ(bench_->get("/lib/three.core.js").status, 200u);
}

TEST(TemporaryFile, GoesWithItsOwner) {
  std::filesystem::path path;
  {
    const TemporaryFile file(".bag", "content");
    path = file.path();
    EXPECT_EQ(test::readAll(path), "content");
    EXPECT_EQ(path.extension(), ".bag");
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace mm
