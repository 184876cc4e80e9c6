#include "workbench/bench.h"

#include <algorithm>
#include <cmath>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "base/temporary_folder.h"
#include "base/text.h"
#include "base/units.h"
#include "machine/joint_units.h"
#include "report/json_parts.h"
#include "workbench/access.h"

namespace mm {
namespace {

constexpr double kShown = 1e-5;  // mm or deg: last digit of a position on the page

using namespace std::chrono_literals;

constexpr auto kMoving = 33ms, kWorking = 100ms, kAtRest = 500ms;  // between two states: 30, 10 and 2 Hz
constexpr std::size_t kMostTasks = 4, kEndedTold = 8;
constexpr std::size_t kLargestTable = 64 << 20;  // bytes; it stays in memory
const std::string kOpen = "open", kLook = "look", kFile = "file", kPreview = "preview";
const char* const kTables[] = {".csv", ".tsv", ".txt", ".log", ".dat", ".asc", ".tpt", ".cfg"};
// What the report may do within the page: draw itself.
const char* const kReportPolicy =
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'self'";

Json placeJson(const Eigen::Vector3d& at) {
  return orNull(at.allFinite(), roundedList(at / kMillimetre, kShown));
}

/// @param deaf why a stop would not reach the machine; empty: it would.
Json machineJson(const std::vector<Joint>& joints, const LiveMachine::State& s, const std::string& deaf) {
  Json readings = Json::array();
  for (std::size_t j = 0; j < joints.size() && j < s.readings.size(); ++j)
    readings.push_back(rounded(s.readings[j] / readingUnit(joints[j]).factor, kShown));
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
          {"share", s.share},
          {"no_stop", deaf}};
}

bool isMotion(const std::string& name) {
  static const std::set<std::string> motions = {"arm", "disarm", "stop", "home", "run", "pause", "continue"};
  return motions.count(name) > 0;
}

ImportWish wishOf(const RequestBody& body) {
  ImportWish wish;
  wish.file = body.number("file");
  wish.asked = body.number("asked");
  wish.session = body.number("session");
  wish.machine = body.text("machine");
  wish.urdf = body.text("urdf");
  wish.artifact = body.text("artifact");
  wish.artifactOfSession = body.text("artifact_from") == "session";
  wish.mapping = body.text("mapping");
  wish.format = body.text("format");
  wish.compensation = body.text("compensation");
  wish.output = body.text("output");
  return wish;
}

std::string personOf(const std::string& given, const std::string& peer) {
  const std::string person = personsName(given);
  return (person.empty() ? "somebody" : person) + " (" + peer + ")";
}

}  // namespace

Bench::Bench(BenchOptions options, BenchSources sources, std::string token, LiveMachine* live)
    : token_(std::move(token)),
      job_([this](const Job::State&) { news(); }),
      live_(live),
      heartbeat_(options.heartbeat),
      work_(std::move(options), std::move(sources), documents_, job_, live) {
  log_.goOnIn(work_.logFile());
  worker_ = std::thread([this] { serve(tasks_); });
  looker_ = std::thread([this] { serve(looks_); });
  if (live_ == nullptr) return;
  aside_ = std::thread([this] { serve(asides_); });
  watcher_ = std::thread([this] { watch(); });
}

Bench::~Bench() {
  onNews({});
  std::string holder;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
    tasks_.clear();
    asides_.clear();
    looks_.clear();
    if (armed_) holder = release();
  }
  if (!holder.empty()) log_.add(holder, "the workbench ends: the machine is stopped");
  job_.cancel();
  changed_.notify_all();
  worker_.join();
  looker_.join();
  if (aside_.joinable()) aside_.join();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    over_ = true;  // until here the watcher stops what was on its way
  }
  changed_.notify_all();
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
  std::string done;
  job_.run("open", [&] { done = work_.begin(); });
  log_.goOnIn(work_.logFile());
  log_.add("mm workbench", done);
}

void Bench::serve(std::deque<Task>& tasks) {
  const bool aside = &tasks != &tasks_;
  for (;;) {
    Task task;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(lock, [&] { return ending_ || !tasks.empty(); });
      if (ending_) return;
      task = std::move(tasks.front());
      tasks.pop_front();
      if (!aside) running_ = task.who;
    }
    Ended ended = carryOut(task, aside);
    if (task.name != kLook && task.name != kPreview)
      log_.add(task.who, task.name + ": " + (ended.ok ? "" : "refused: ") + ended.message);
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!aside) running_.clear();
      end(std::move(ended));
    }
    news();
  }
}

Bench::Ended Bench::carryOut(const Task& task, bool aside) {
  Ended ended{task.number, task.name, {}, false};
  try {
    if (aside) {
      const CancelScope scope([this] { return ending_.load(); });
      ended.message = task.work();
    } else {
      job_.run(task.name, [&] { ended.message = task.work(); });
    }
    ended.ok = true;
  } catch (const std::exception& e) {
    ended.message = e.what();
  }
  if (!aside) log_.goOnIn(work_.logFile());  // it may have opened a session of another machine
  return ended;
}

void Bench::end(Ended ended) {
  pending_.erase(ended.number);
  ended_.push_back(std::move(ended));
  if (ended_.size() > kEndedTold) ended_.pop_front();
}

WebAnswer Bench::enqueue(const std::string& name, const std::string& who, std::function<std::string()> work) {
  return enqueue(tasks_, name, who, std::move(work));
}

WebAnswer Bench::enqueue(std::deque<Task>& tasks, const std::string& name, const std::string& who,
                         std::function<std::string()> work) {
  std::uint64_t number = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (tasks.size() >= kMostTasks && &tasks != &tasks_)
      return WebAnswer::say(
          409, std::to_string(tasks.size()) + " others wait before '" + name + "'; ask again in a moment");
    if (tasks.size() >= kMostTasks)
      return WebAnswer::say(409, "'" + job_.state().task + "' runs and " + std::to_string(tasks.size()) +
                                     " tasks wait; wait for them, or cancel");
    const bool another =
        std::any_of(tasks.begin(), tasks.end(), [&](const Task& t) { return t.name == name; });
    if ((name == kOpen || name == kFile) && another)  // each waits with its file in memory
      return WebAnswer::say(409, "another file is waiting to be read; send this one again after it is open");
    number = ++numbers_;
    pending_.insert(number);
    tasks.push_back({number, name, who, std::move(work)});
  }
  changed_.notify_all();
  WebAnswer answer = WebAnswer::text(jsonLine({{"number", number}, {"message", name + " begins"}}));
  answer.status = 202;
  return answer;
}

WebAnswer Bench::get(const std::string& path) {
  if (path == "/") return page_.index(token_);
  if (std::optional<WebAnswer> part = page_.part(path)) return *part;
  if (path == "/data/contacts" && live_ != nullptr) return contacts_.of(live_->contacts());
  if (path == "/data/log") return WebAnswer::text(log_.json());
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
        work_.judgeFormula(asked.text("direction"), asked.text("formula"), asked.text("start")));
  }
  if (startsWith(path, "/action/")) return action(path.substr(8), body, who);
  return WebAnswer::say(404, "there is no such action");
}

WebAnswer Bench::action(const std::string& name, const std::string& json, const std::string& peer) {
  const RequestBody body(json);
  body.refuseOthers(name,
                    {"who",      "client",        "effect",  "id",     "model",        "method",  "seed",
                     "plan",     "controller",    "file",    "asked",  "session",      "machine", "urdf",
                     "artifact", "artifact_from", "mapping", "format", "compensation", "output"});
  const std::string who = personOf(body.text("who"), peer);
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
  if (name == "export")
    return enqueue(name, who,
                   [this, controller = body.text("controller")] { return work_.exportTo(controller); });
  if (name == kLook)
    return enqueue(looks_, name, who, [this, plan = body.text("plan")] { return work_.lookAt(plan); });
  if (name == kPreview)
    return enqueue(looks_, name, who, [this, wish = wishOf(body)] { return work_.preview(wish); });
  if (name == "import") return enqueue(name, who, [this, wish = wishOf(body)] { return work_.import(wish); });
  if (name == "take_live") return enqueue(name, who, [this] { return work_.openLive(); });
  if (name == "calibrate")
    return enqueue(name, who,
                   [this, model = body.text("model"), method = body.text("method"),
                    seed = body.number("seed")] { return work_.calibrate(model, method, seed); });
  if (name == "cancel") return cancel(who);
  if (live_ == nullptr && isMotion(name))
    return WebAnswer::say(409, "there is no machine: this workbench shows a recorded session");
  if (name == "stop") return stop(who);
  if (name == "arm") return arm(body.number("client"), who);
  if (name == "disarm") return disarm(body.number("client"));
  if (isMotion(name)) return motion(name, body, who);
  return WebAnswer::say(404, "there is no action '" + name.substr(0, 40) + "'");
}

WebAnswer Bench::cancel(const std::string& who) {
  std::deque<Task> dropped;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    dropped.swap(tasks_);
    for (const Task& task : dropped) end({task.number, task.name, "cancelled before it began", false});
  }
  const Job::State running = job_.cancel();
  log_.add(who, "cancel");
  for (const Task& task : dropped) log_.add(task.who, task.name + ": cancelled before it began, by " + who);
  news();
  std::string said = running.task.empty() ? "nothing is running" : "'" + running.task + "' was asked to stop";
  if (!dropped.empty()) said += "; " + std::to_string(dropped.size()) + " that waited do not begin";
  return WebAnswer::say(200, said);
}

WebAnswer Bench::upload(const std::string& query, std::string body, const std::string& peer) {
  const std::string given = queryValue(query, "name"), name = shownFileName(given);
  const std::string kind = lower(given.substr(given.size() - std::min<std::size_t>(4, given.size())));
  const bool table = std::find(std::begin(kTables), std::end(kTables), kind) != std::end(kTables);
  if (kind != ".bag" && !table)
    return WebAnswer::say(
        415, "'" + name + "' is neither a bag nor a text of measurements; the name must end in .bag, " +
                 joined({std::begin(kTables), std::end(kTables)}, ", "));
  if (body.empty()) return WebAnswer::say(400, "'" + name + "' is empty");
  if (table && body.size() > kLargestTable)
    return WebAnswer::say(413, "'" + name + "' has more than " + std::to_string(kLargestTable >> 20) +
                                   " MB; import it with mm import, and open the bag");
  const std::string who = personOf(queryValue(query, "who"), peer);
  const auto content = std::make_shared<std::string>(std::move(body));
  if (table)
    return enqueue(looks_, kFile, who, [this, content, name] { return work_.receive(name, content); });
  return enqueue(kOpen, who, [this, content, name, kind] {
    const TemporaryFolder folder;
    const std::string file = folder.path().filename().string() + kind;  // a name that no page sends
    folder.write(file, *content);
    std::string().swap(*content);
    return work_.open(folder.path() / file, name);
  });
}

std::string Bench::live() {
  const Job::State running = job_.state();
  Json documents = documents_.numbers(), machine;
  if (live_ != nullptr) {
    const LiveMachine::State state = live_->state();
    if (state.observations > 0) documents["contacts"] = state.observations;
    machine = machineJson(live_->machine().joints(), state, live_->deaf());
  }
  const auto ended = [](const Ended& e) -> Json {
    return {{"number", e.number}, {"name", e.name}, {"ok", e.ok}, {"message", e.message}};
  };
  const std::lock_guard<std::mutex> lock(mutex_);
  const Json task{{"name", running.task},
                  {"stage", running.stage},
                  {"share", running.share},
                  {"seconds", rounded(running.seconds, 0.1)},
                  {"who", running_}};
  const std::string object =
      jsonLine({{"documents", documents},
                {"machine", machine},
                {"task", orNull(!running.task.empty(), task)},
                {"waiting", tasks_.size()},
                {"asked", numbers_},
                {"pending", pending_},
                {"ended", jsonList(ended_, ended)},
                {"armed", armed_ ? Json{{"client", armed_->client}, {"who", armed_->who}} : Json()}});
  return object.substr(1, object.size() - 2);
}

std::chrono::milliseconds Bench::period() {
  if (live_ != nullptr && live_->state().moving) return kMoving;
  return job_.state().task.empty() ? kAtRest : kWorking;
}

}  // namespace mm
