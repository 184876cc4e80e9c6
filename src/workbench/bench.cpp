#include "workbench/bench.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/text.h"
#include "base/units.h"
#include "report/json_parts.h"
#include "workbench/access.h"
#include "workbench/compact_json.h"
#include "workbench/temporary_file.h"

namespace mm {
namespace {

using Json = nlohmann::ordered_json;
using namespace std::chrono_literals;

constexpr auto kMoving = 33ms, kWorking = 100ms, kAtRest = 500ms;  // between two states: 30, 10 and 2 Hz
constexpr auto kHeartbeat = 1000ms;  // without one for so long, the machine is stopped
constexpr std::size_t kMostTasks = 4, kEndedTold = 8;
// What the report may do within the page: draw itself.
const char* const kReportPolicy =
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'self'";

Json placeJson(const Eigen::Vector3d& at) {
  return at.allFinite() ? roundedList(at / kMillimetre, 1e-5) : Json(nullptr);
}

WebAnswer contactsAnswer(const std::vector<Eigen::Vector3d>& contacts) {
  Json at = Json::array();
  for (const Eigen::Vector3d& tip : contacts) at.push_back(roundedList(tip / kMillimetre, kPlaceStep));
  return WebAnswer::text(compact({{"at_mm", std::move(at)}}), "application/json");
}

Json machineJson(LiveMachine& live) {
  const LiveMachine::State s = live.state();
  const std::vector<Joint>& joints = live.machine().joints();
  Json readings = Json::array();
  for (std::size_t j = 0; j < joints.size() && j < s.readings.size(); ++j)
    readings.push_back(
        rounded(s.readings[j] / (joints[j].kind == JointKind::kRotary ? kDegree : kMillimetre), 1e-5));
  return {{"readings", std::move(readings)},
          {"moving", s.moving},
          {"nominal_mm", placeJson(s.nominal)},
          {"corrected_mm", placeJson(s.corrected)},
          {"candidate_mm", placeJson(s.candidate)},
          {"std_um", rounded(s.sigma / kMicrometre, 1e-4)},
          {"calibration", s.calibration},
          {"status", s.status},
          {"observations", s.observations},
          {"measuring", s.measuring},
          {"share", number(s.share)}};
}

}  // namespace

Bench::Bench(BenchOptions options, BenchSources sources, std::string token, LiveMachine* live)
    : token_(std::move(token)),
      job_([this](const Job::State&) { news(); }),
      live_(live),
      work_(options, std::move(sources), documents_, job_, live),
      log_(options.store.empty() ? std::filesystem::path() : options.store / "workbench.log") {
  worker_ = std::thread([this] { serve(); });
  if (live_ != nullptr) watcher_ = std::thread([this] { watch(); });
}

Bench::~Bench() {
  onNews({});
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
    tasks_.clear();
    if (armed_) disarm("the workbench ends");
  }
  job_.cancel();
  changed_.notify_all();
  worker_.join();
  if (watcher_.joinable()) watcher_.join();
}

void Bench::onNews(std::function<void()> wake) {
  const std::lock_guard<std::mutex> lock(wakeMutex_);
  wake_ = std::move(wake);
}

void Bench::news() {
  const std::lock_guard<std::mutex> lock(wakeMutex_);
  if (wake_) wake_();
}

void Bench::begin() {
  job_.run("open", [this] { log_.add("mm workbench", work_.begin()); });
}

void Bench::serve() {
  for (;;) {
    Task task;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(lock, [this] { return ending_ || !tasks_.empty(); });
      if (ending_) return;
      task = std::move(tasks_.front());
      tasks_.pop_front();
      running_ = task.who;
    }
    Ended ended{task.number, task.name, {}, false};
    try {
      job_.run(task.name, [&] { ended.message = task.work(); });
      ended.ok = true;
    } catch (const std::exception& e) {
      ended.message = e.what();
    }
    log_.add(task.who, task.name + ": " + (ended.ok ? "" : "refused: ") + ended.message);
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      running_.clear();
      ended_.push_back(std::move(ended));
      if (ended_.size() > kEndedTold) ended_.pop_front();
    }
    news();
  }
}

/// A machine that is left alone is stopped whether or not anybody asks for the state.
void Bench::watch() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!ending_) {
    changed_.wait_for(lock, 50ms, [this] { return ending_; });
    if (armed_ && Clock::now() - armed_->heard > kHeartbeat)
      disarm("no heartbeat of the page for " + std::to_string(kHeartbeat.count()) +
             " ms: the machine is stopped");
  }
}

WebAnswer Bench::enqueue(const std::string& name, const std::string& who, std::function<std::string()> work) {
  std::uint64_t number = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (tasks_.size() >= kMostTasks)
      return WebAnswer::say(409, "'" + job_.state().task + "' runs and " + std::to_string(tasks_.size()) +
                                     " tasks wait; wait for them, or cancel");
    number = ++numbers_;
    tasks_.push_back({number, name, who, std::move(work)});
  }
  changed_.notify_all();
  WebAnswer answer =
      WebAnswer::text(compact({{"number", number}, {"message", name + " begins"}}), "application/json");
  answer.status = 202;
  return answer;
}

WebAnswer Bench::get(const std::string& path) {
  if (path == "/") return page_.index(token_);
  if (std::optional<WebAnswer> part = page_.part(path)) return *part;
  if (path == "/data/contacts" && live_ != nullptr) return contactsAnswer(live_->contacts());
  if (path == "/data/log") return WebAnswer::text(log_.json(), "application/json");
  if (startsWith(path, "/data/"))
    if (std::optional<WebAnswer> found = documents_.find(path.substr(6))) {
      found->fileName.clear();
      if (path == "/data/report") found->policy = kReportPolicy;
      return *found;
    }
  if (startsWith(path, "/download/"))
    if (std::optional<WebAnswer> found = documents_.find(path.substr(10))) {
      if (found->fileName.empty()) found->fileName = path == "/download/report" ? "report.html" : "data.json";
      return *found;
    }
  return WebAnswer::say(404, "there is no such page");
}

WebAnswer Bench::post(const std::string& path, const std::string& query, std::string body,
                      const std::string& who) {
  if (path == "/upload") return upload(query, std::move(body), who);
  if (path == "/formula") {
    const RequestBody asked(body);
    asked.refuseOthers("formula", {"direction", "formula", "start"});
    return WebAnswer::text(
        work_.judgeFormula(asked.text("direction"), asked.text("formula"), asked.text("start")),
        "application/json");
  }
  if (startsWith(path, "/action/")) return action(path.substr(8), body, who);
  return WebAnswer::say(404, "there is no such action");
}

WebAnswer Bench::action(const std::string& name, const std::string& json, const std::string& peer) {
  const RequestBody body(json);
  body.refuseOthers(name, {"who", "client", "effect", "id", "model", "method", "seed", "plan"});
  const std::string person = personsName(body.text("who"));
  const std::string who = (person.empty() ? "somebody" : person) + " (" + peer + ")";
  const std::string effect = body.text("effect"), id = body.text("id");
  if (name == "diagnose") return enqueue(name, who, [this] { return work_.diagnose(); });
  if (name == "add") return enqueue(name, who, [this, effect] { return work_.add(effect); });
  if (name == "remove") return enqueue(name, who, [this, effect] { return work_.remove(effect); });
  if (name == "add_all") return enqueue(name, who, [this] { return work_.addAll(); });
  if (name == "use") return enqueue(name, who, [this, id] { return work_.use(id); });
  if (name == "promote") return enqueue(name, who, [this, id] { return work_.promote(id); });
  if (name == "rollback") return enqueue(name, who, [this, id] { return work_.rollback(id); });
  if (name == "verify") return enqueue(name, who, [this] { return work_.verify(); });
  if (name == "report") return enqueue(name, who, [this] { return work_.report(); });
  if (name == "take_live") return enqueue(name, who, [this] { return work_.openLive(); });
  if (name == "calibrate") {
    const std::string model = body.text("model"), method = body.text("method");
    const std::uint64_t seed = body.number("seed");
    return enqueue(name, who, [this, model, method, seed] { return work_.calibrate(model, method, seed); });
  }
  return immediately(name, body, who);
}

WebAnswer Bench::immediately(const std::string& name, const RequestBody& body, const std::string& who) {
  if (name == "cancel") {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      tasks_.clear();
    }
    const Job::State running = job_.cancel();
    log_.add(who, "cancel");
    return WebAnswer::say(
        200, running.task.empty() ? "nothing is running" : "'" + running.task + "' was asked to stop");
  }
  if (name == "stop") {  // anybody may stop a machine, armed or not
    if (live_ == nullptr)
      return WebAnswer::say(409, "no machine is there: this workbench shows a recorded session");
    live_->stop();
    log_.add(who, "stop");
    return WebAnswer::say(200, "every axis was told to stop");
  }
  if (name == "arm") return arm(body.number("client"), who);
  if (name == "disarm") {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (armed_ && armed_->client == body.number("client")) disarm("disarmed");
    return WebAnswer::say(200, "disarmed: what moved was stopped");
  }
  if (name == "home" || name == "run" || name == "pause" || name == "continue")
    return motion(name, body, who);
  return WebAnswer::say(404, "there is no action '" + name.substr(0, 40) + "'");
}

WebAnswer Bench::arm(std::uint64_t client, const std::string& who) {
  if (live_ == nullptr)
    return WebAnswer::say(409, "no machine is there: this workbench shows a recorded session");
  const std::lock_guard<std::mutex> lock(mutex_);
  if (client == 0)
    return WebAnswer::say(409, "this page has no live connection, so nobody would notice if it went");
  if (armed_ && armed_->client != client)
    return WebAnswer::say(
        409, armed_->who + " holds the machine; it is free when that page is disarmed or closed");
  armed_ = Armed{client, who, Clock::now()};
  log_.add(who, "armed");
  return WebAnswer::say(200, "armed: the machine moves as long as this page is open");
}

void Bench::disarm(const std::string& why) {
  if (!armed_) return;
  log_.add(armed_->who, why);
  armed_.reset();
  if (live_ != nullptr) live_->stop();
}

WebAnswer Bench::motion(const std::string& name, const RequestBody& body, const std::string& who) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (live_ == nullptr)
      return WebAnswer::say(409, "no machine is there: this workbench shows a recorded session");
    if (!armed_ || armed_->client != body.number("client"))
      return WebAnswer::say(409, "the machine is not armed from this page; arm it first");
  }
  if (name == "pause" || name == "continue") {
    log_.add(who, name);
    return WebAnswer::say(200, live_->pause(name == "pause"));
  }
  const std::uint64_t client = body.number("client");
  const std::string plan = body.text("plan");
  return enqueue(name, who, [this, name, client, plan] {
    requireArmed(client);  // it may have waited behind other tasks
    if (name == "home") return live_->home();
    const std::string measured = live_->run(plan, [this] { return job_.cancelled(); });
    return measured + "; " + work_.openLive();
  });
}

void Bench::requireArmed(std::uint64_t client) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!armed_ || armed_->client != client)
    throw InputError("the machine is not armed any more from the page that asked; nothing was moved");
}

WebAnswer Bench::upload(const std::string& query, std::string body, const std::string& peer) {
  const std::string name = personsName(queryValue(query, "name"));
  const std::string kind = name.size() > 4 ? name.substr(name.size() - 4) : "";
  if (kind != ".bag" && kind != ".csv")
    return WebAnswer::say(415, "'" + name + "' is neither a bag nor a CSV; its name ends in .bag or .csv");
  if (body.empty()) return WebAnswer::say(400, "'" + name + "' is empty");
  const auto file = std::make_shared<TemporaryFile>(kind, body);
  return enqueue("open", "somebody (" + peer + ")", [this, file, name, kind] {
    return kind == ".bag" ? work_.open(file->path(), name) : work_.importTable(file->path(), name);
  });
}

std::string Bench::live() {
  const Job::State running = job_.state();
  Json out;
  out["documents"] = documents_.numbers();
  if (live_ != nullptr) {
    const std::size_t contacts = live_->state().observations;
    if (contacts > 0) out["documents"]["contacts"] = contacts;
  }
  out["machine"] = live_ != nullptr ? machineJson(*live_) : Json(nullptr);
  const std::lock_guard<std::mutex> lock(mutex_);
  out["task"] = running.task.empty() ? Json(nullptr)
                                     : Json{{"name", running.task},
                                            {"stage", running.stage},
                                            {"share", number(running.share)},
                                            {"seconds", rounded(running.seconds, 0.1)},
                                            {"who", running_}};
  out["waiting"] = tasks_.size();
  out["ended"] = Json::array();
  for (const Ended& e : ended_)
    out["ended"].push_back({{"number", e.number}, {"name", e.name}, {"ok", e.ok}, {"message", e.message}});
  out["armed"] = armed_ ? Json{{"client", armed_->client}, {"who", armed_->who}} : Json(nullptr);
  const std::string object = compact(out);
  return object.substr(1, object.size() - 2);
}

std::chrono::milliseconds Bench::period() {
  if (live_ != nullptr && live_->state().moving) return kMoving;
  return job_.state().task.empty() ? kAtRest : kWorking;
}

void Bench::heard(std::uint64_t client, const std::string& text) {
  if (text != "heartbeat") throw InputError("a page says 'heartbeat' and nothing else");
  const std::lock_guard<std::mutex> lock(mutex_);
  if (armed_ && armed_->client == client) armed_->heard = Clock::now();
}

void Bench::gone(std::uint64_t client) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (armed_ && armed_->client == client) disarm("the page that held the machine has gone: it is stopped");
}

}  // namespace mm
