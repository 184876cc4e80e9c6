#pragma once
#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/text.h"
#include "nine_ball_plate.h"
#include "session_files.h"
#include "simulation/simulate.h"
#include "workbench/bench.h"

namespace mm::test {

using namespace std::chrono_literals;
using nlohmann::json;

/// A plate that was measured on a machine with 3 um of play in x.
inline const Session& plate() {
  static const Session session = [] {
    const Machine machine = Machine::load("three_axis");
    SimulationRequest request;
    request.hide = {"backlash:x=3um"};
    request.seed = 5;
    Session measured = simulate(machine, nineBallPlate(machine, 12), request).session;
    measured.source = "plate.bag";
    return measured;
  }();
  return session;
}

/// The same machine, measured once more.
inline Session fresh() {
  const Machine machine = Machine::load("three_axis");
  SimulationRequest request;
  request.hide = {"backlash:x=3um"};
  request.seed = 6;
  return simulate(machine, Plan::load("config/plans/nine_ball_plate.yaml", machine), request).session;
}

/// The plate, measured on a machine of that name, or with that serial.
inline Session named(const std::string& name) {
  Session session = plate();
  session.machine = Machine(session.machine.urdf(), name);
  return session;
}
inline Session withSerial(const std::string& serial) {
  Session session = plate();
  std::string urdf = session.machine.urdf();
  urdf.insert(urdf.rfind("</robot>"), "<serial>" + serial + "</serial>\n");
  session.machine = Machine(urdf, session.machine.name());
  return session;
}

/// The plate, measured on a machine whose bed is drawn by a file.
inline Session withMesh(const std::string& name) {
  Session session = plate();
  std::string urdf = session.machine.urdf();
  urdf.insert(urdf.find("<visual>"),
              "<visual><geometry><mesh filename=\"" + name + "\"/></geometry></visual>\n");
  session.machine = Machine(urdf, session.machine.name());
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
  std::vector<Eigen::Vector3d> contacts() override { return touched; }
  std::string space() const override { return "/"; }
  std::string promote(const std::string& id) override { return id + " is active, says the machine"; }
  std::string rollback(const std::string&) override { throw InputError("nothing was active before"); }
  /// Holds up the next order until it is let through: what is on its way when something else happens.
  void holdUp() {
    const std::lock_guard<std::mutex> lock(mutex);
    heldUp = true;
  }
  void letThrough() {
    const std::lock_guard<std::mutex> lock(mutex);
    heldUp = false;
    changed.notify_all();
  }
  std::string home() override {
    order();
    if (!homesByItself) return untilStopped();
    return "homed";
  }
  std::string run(const std::string& yaml, const std::function<bool()>& cancelled) override {
    order();
    while (runsUntilCancelled && !cancelled()) std::this_thread::yield();
    if (runsUntilCancelled) throw InputError("the plan was cancelled");
    return "measured " + yaml;
  }
  std::string pause(bool yes) override {
    std::unique_lock<std::mutex> lock(mutex);
    changed.wait(lock, [this] { return !pauseHeldUp; });
    return yes ? "paused" : "goes on";
  }
  void setDeaf(const std::string& why) {
    const std::lock_guard<std::mutex> lock(mutex);
    deafness = why;
  }
  std::string deaf() override {
    const std::lock_guard<std::mutex> lock(mutex);
    return deafness;
  }
  void stop() override {
    const std::lock_guard<std::mutex> lock(mutex);
    ++stops;
    changed.notify_all();
  }
  bool waitForStops(int count) {
    return waitFor([&] { return stops >= count; });
  }
  bool waitForOrders(int count) {
    return waitFor([&] { return orders >= count; });
  }
  template <typename Condition>
  bool waitFor(Condition condition) {
    std::unique_lock<std::mutex> lock(mutex);
    return changed.wait_for(lock, 20s, condition);
  }
  std::atomic<bool> moving{false}, runsUntilCancelled{false}, homesByItself{true};
  std::string deafness;
  int stops = 0, orders = 0;
  bool heldUp = false, pauseHeldUp = false;
  std::vector<Eigen::Vector3d> touched = {Eigen::Vector3d(1e-3, 2e-3, 3e-3)};
  std::mutex mutex;
  std::condition_variable changed;

 private:
  void order() {
    std::unique_lock<std::mutex> lock(mutex);
    ++orders;
    changed.notify_all();
    changed.wait(lock, [this] { return !heldUp; });
  }
  /// Moves until a stop comes that is later than the order.
  std::string untilStopped() {
    std::unique_lock<std::mutex> lock(mutex);
    const int before = stops;
    if (changed.wait_for(lock, 20s, [&] { return stops > before; })) throw InputError("stopped");
    return "homed";
  }
};

class BenchTest : public ::testing::Test {
 protected:
  Folder folder_;
  ObedientMachine machine_;
  std::unique_ptr<Bench> bench_;
  std::mutex mutex_;
  std::condition_variable news_;
  std::uint64_t told_ = 0;
  std::chrono::milliseconds heartbeat_ = 1h;
  std::string store_ = "store";
  std::string bag_ = "plate.bag";           // empty: none is open
  std::map<std::string, Session> written_;  // by name of the bag
  bool cancelsOpening_ = false;             // of any other bag
  Session (*session_)() = [] { return plate(); };

  void start(bool live = false) {
    BenchOptions options;
    options.bag = bag_;
    options.folder = folder_.path("");
    options.heartbeat = heartbeat_;
    if (!store_.empty()) options.store = folder_.path(store_);
    BenchSources sources;
    sources.readBag = [this](const std::filesystem::path& file, const ProgressCallback&, const Machine*) {
      if (file.filename() == "plate.bag") return session_();
      if (cancelsOpening_) throw Cancelled("cancelled; nothing was changed");
      if (const auto one = written_.find(file.filename().string()); one != written_.end()) return one->second;
      const std::string content = readAll(file);
      if (content == "fresh points") return fresh();
      if (startsWith(content, "serial ")) return withSerial(content.substr(7));
      if (startsWith(content, "mesh ")) return withMesh(content.substr(5));
      throw InputError(file.string() + ": is not a bag");
    };
    sources.writeBag = [this](const Session& session, const std::filesystem::path& file,
                              const std::vector<MotionSample>&, const ProgressCallback&) {
      std::ofstream(file) << "a bag";
      written_.emplace(file.filename().string(), session);
    };
    sources.spaceOf = [](const std::filesystem::path&) { return std::string(); };
    sources.packageFolder = [this](const std::string&) {
      return std::filesystem::path(folder_.path("package"));
    };
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

  /// The page number 1 comes and is armed.
  void arm() {
    bench_->came(1);
    ASSERT_TRUE(act("arm", {{"client", 1}})["ok"]);
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

}  // namespace mm::test
