#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "workbench/bench_log.h"
#include "workbench/bench_work.h"
#include "workbench/documents.h"
#include "workbench/page.h"
#include "workbench/request_body.h"
#include "workbench/web_handler.h"
#include "workflow/job.h"

namespace mm {

/// The workbench behind the server: hands out the page and its documents, lets one task after the other work
/// in a thread of its own, and lets one page at a time move the machine while its heartbeat is heard. A
/// motion belongs to the arming under which it was asked for: when that ends, by a stop or otherwise, what
/// waits does not begin and what runs is stopped until it has ended.
class Bench : public WebHandler {
 public:
  /// @param token that the page shows with every request. @param live null: a recorded session alone; must
  /// outlive it. @throw InputError: a file of the page is missing.
  Bench(BenchOptions options, BenchSources sources, std::string token, LiveMachine* live);
  ~Bench() override;  ///< stops what runs, the machine first

  /// Called from any thread when the state is new; must return at once, and is not called any more once
  /// another is given.
  void onNews(std::function<void()> wake);
  /// Reads what the options name, in the caller's thread and before a server is there.
  /// @throw as BenchWork::begin.
  void begin();

  WebAnswer get(const std::string& path) override;
  WebAnswer post(const std::string& path, const std::string& query, std::string body,
                 const std::string& who) override;
  std::string live() override;
  std::chrono::milliseconds period() override;
  void came(std::uint64_t client) override;
  void heard(std::uint64_t client, const std::string& text) override;
  void gone(std::uint64_t client) override;

 private:
  using Clock = std::chrono::steady_clock;
  struct Task {
    std::uint64_t number = 0;
    std::string name, who;
    std::function<std::string()> work;  // returns what to say
  };
  struct Ended {
    std::uint64_t number = 0;
    std::string name, message;
    bool ok = false;
  };
  struct Armed {
    std::uint64_t arming = 0, client = 0;
    std::string who;
    Clock::time_point heard;
  };
  class Motion;

  WebAnswer action(const std::string& name, const std::string& body, const std::string& peer);
  WebAnswer upload(const std::string& query, std::string body, const std::string& peer);
  WebAnswer motion(const std::string& name, const RequestBody& body, const std::string& who);
  WebAnswer cancel(const std::string& who);
  WebAnswer stop(const std::string& who);
  WebAnswer arm(std::uint64_t client, const std::string& who);
  WebAnswer disarm(std::uint64_t client);
  /// Stops the machine and frees it; the caller holds the mutex and has looked whether it is armed. @return
  /// who held it, to be logged when the mutex is free: a disk may be slow.
  std::string release();
  bool held(std::uint64_t arming) const;  ///< whether it is still in force; the caller holds the mutex
  WebAnswer enqueue(const std::string& name, const std::string& who, std::function<std::string()> work);
  WebAnswer enqueue(std::deque<Task>& tasks, const std::string& name, const std::string& who,
                    std::function<std::string()> work);
  void serve(std::deque<Task>& tasks);
  Ended carryOut(const Task& task, bool aside);
  void end(Ended ended);  ///< the caller holds the mutex
  void watch();
  void news();

  std::string token_;
  Documents documents_;
  Job job_;
  LiveMachine* live_;
  const std::chrono::milliseconds heartbeat_;
  BenchWork work_;
  Page page_;
  ContactsDocument contacts_;  // of the server's thread
  BenchLog log_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::mutex wakeMutex_;  // guards the next alone
  std::function<void()> wake_;
  std::deque<Task> tasks_, asides_;  // what must not wait for a plan: pausing it
  std::deque<Task> looks_;           // what only looks, at any time: at a plan that is being written
  std::set<std::uint64_t> pending_;  // what waits or runs
  std::deque<Ended> ended_;
  std::set<std::uint64_t> clients_;  // with a live connection
  std::optional<Armed> armed_;
  std::uint64_t numbers_ = 0, armings_ = 0;
  std::uint64_t moving_ = 0;         // the arming under which it moves; 0: it does not
  std::string running_;              // who asked for what runs
  std::atomic<bool> ending_{false};  // written under the mutex
  bool over_ = false;
  std::thread worker_, aside_, looker_, watcher_;
};

}  // namespace mm
