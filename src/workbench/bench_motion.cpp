// Who may move the machine, and what stops it.
#include "base/error.h"
#include "base/text.h"
#include "design/moves.h"
#include "workbench/bench.h"
#include "workbench/sent_yaml.h"

namespace mm {

/// A motion from before its first order until nothing of it moves any more. While it lives the watcher stops
/// a machine whose arming has ended: an order may have been on its way when it was stopped.
class Bench::Motion {
 public:
  /// @throw InputError: the arming has ended.
  Motion(Bench& bench, std::uint64_t arming) : bench_(bench) {
    const std::lock_guard<std::mutex> lock(bench_.mutex_);
    if (!bench_.held(arming))
      throw InputError("the machine was disarmed or armed again after this request; nothing was moved");
    bench_.moving_ = arming;
  }
  ~Motion() {
    const std::lock_guard<std::mutex> lock(bench_.mutex_);
    bench_.moving_ = 0;
  }
  Motion(const Motion&) = delete;
  Motion& operator=(const Motion&) = delete;

 private:
  Bench& bench_;
};

bool Bench::held(std::uint64_t arming) const { return armed_ && armed_->arming == arming; }

std::string Bench::release() {
  live_->stop();
  std::string who = armed_->who;
  armed_.reset();
  return who;
}

/// A machine that is left alone is stopped whether or not anybody asks for the state.
void Bench::watch() {
  constexpr std::chrono::milliseconds kWatch{50};  // between two looks
  std::unique_lock<std::mutex> lock(mutex_);
  while (!over_) {
    changed_.wait_for(lock, kWatch, [this] { return over_; });
    if (moving_ != 0 && !held(moving_)) live_->stop();
    if (!armed_) continue;
    std::string why = live_->deaf();
    if (Clock::now() - armed_->heard > heartbeat_)
      why = "no heartbeat of the page for " + std::to_string(heartbeat_.count()) + " ms";
    if (why.empty()) continue;
    const std::string who = release();
    lock.unlock();
    log_.add(who, why + ": the machine is stopped");
    news();
    lock.lock();
  }
}

/// Anybody may stop a machine, armed or not.
WebAnswer Bench::stop(const std::string& who) {
  bool held = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    held = armed_.has_value();
    if (held)
      release();
    else
      live_->stop();
  }
  log_.add(who, held ? "stop, and disarmed" : "stop");
  news();
  return WebAnswer::say(200, held ? "every axis was told to stop; arm the machine to move it again"
                                  : "every axis was told to stop");
}

WebAnswer Bench::arm(std::uint64_t client, const std::string& who) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (clients_.count(client) == 0)
      return WebAnswer::say(409, "this page has no live connection, so its loss would go unnoticed");
    if (armed_ && armed_->client != client)
      return WebAnswer::say(409, armed_->who + " holds the machine until that page is disarmed or closed");
    const std::string deaf = live_->deaf();
    if (!deaf.empty())
      return WebAnswer::say(409, "not armed, because a stop would not reach the machine: " + deaf);
    const std::uint64_t arming = armed_ ? armed_->arming : ++armings_;
    armed_ = Armed{arming, client, who, Clock::now()};
  }
  log_.add(who, "armed");
  news();
  return WebAnswer::say(200, "armed: the machine moves as long as this page is open");
}

WebAnswer Bench::disarm(std::uint64_t client) {
  std::string who;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!armed_ || armed_->client != client)
      return WebAnswer::say(200, "this page does not hold the machine");
    who = release();
  }
  log_.add(who, "disarmed");
  news();
  return WebAnswer::say(200, "disarmed: all motion was stopped");
}

WebAnswer Bench::motion(const std::string& name, const RequestBody& body, const std::string& who) {
  std::uint64_t arming = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!armed_ || armed_->client != body.number("client"))
      return WebAnswer::say(409, "the machine is not armed from this page; arm it first");
    arming = armed_->arming;
  }
  if (name == "pause" || name == "continue")  // the service may take seconds to answer
    return enqueue(asides_, name, who, [this, name] { return live_->pause(name == "pause"); });
  const std::string plan = body.text("plan");
  return enqueue(name, who, [this, name, arming, plan] {
    if (name == "home") {
      const Motion motion(*this, arming);
      return live_->home();
    }
    const std::string checked = sentPlan(plan);
    std::string measured;
    {
      const Motion motion(*this, arming);  // it may have waited behind other tasks
      measured = live_->run(checked, [this, arming] {
        const std::lock_guard<std::mutex> lock(mutex_);
        return job_.cancelled() || !held(arming);
      });
    }
    // what a diagnosis proposed is answered with what it was proposed for
    return measured + "; " + work_.openLive(startsWith(checked, kMovesBegin));
  });
}

void Bench::came(std::uint64_t client) {
  const std::lock_guard<std::mutex> lock(mutex_);
  clients_.insert(client);
}

void Bench::heard(std::uint64_t client, const std::string& text) {
  if (text != "heartbeat") throw InputError("a page may send only 'heartbeat'");
  const std::lock_guard<std::mutex> lock(mutex_);
  if (armed_ && armed_->client == client) armed_->heard = Clock::now();
}

void Bench::gone(std::uint64_t client) {
  std::string who;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    clients_.erase(client);
    if (!armed_ || armed_->client != client) return;
    who = release();
  }
  log_.add(who, "the page that held the machine was closed: the machine is stopped");
  news();
}

}  // namespace mm
