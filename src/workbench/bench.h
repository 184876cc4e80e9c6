#pragma once
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "workbench/bench_log.h"
#include "workbench/bench_work.h"
#include "workbench/documents.h"
#include "workbench/page.h"
#include "workbench/request_body.h"
#include "workbench/web_handler.h"
#include "workflow/job.h"

namespace mm {

/// The workbench behind the server: hands out the page and its documents, lets one task after the other work
/// in a thread of its own, and lets one page at a time move the machine while its heartbeat is heard.
class Bench : public WebHandler {
 public:
  /// @param token that the page shows with every request. @param live null: a recorded session alone; must
  /// outlive it. @throw InputError: a file of the page is missing.
  Bench(BenchOptions options, BenchSources sources, std::string token, LiveMachine* live);
  ~Bench() override;  ///< stops what runs

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
    std::uint64_t client = 0;
    std::string who;
    Clock::time_point heard;
  };

  WebAnswer action(const std::string& name, const std::string& body, const std::string& peer);
  WebAnswer upload(const std::string& query, std::string body, const std::string& peer);
  WebAnswer motion(const std::string& name, const RequestBody& body, const std::string& who);
  WebAnswer immediately(const std::string& name, const RequestBody& body, const std::string& who);
  WebAnswer arm(std::uint64_t client, const std::string& who);
  void disarm(const std::string& why);  ///< stops the machine; the caller holds the mutex
  /// @throw InputError: the page does not hold the machine any more.
  void requireArmed(std::uint64_t client);
  WebAnswer enqueue(const std::string& name, const std::string& who, std::function<std::string()> work);
  void log(const std::string& who, const std::string& what);
  void serve();
  void watch();
  void news();

  std::string token_;
  Documents documents_;
  Job job_;
  LiveMachine* live_;
  BenchWork work_;
  Page page_;
  BenchLog log_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::mutex wakeMutex_;  // guards the next alone
  std::function<void()> wake_;
  std::deque<Task> tasks_;
  std::deque<Ended> ended_;
  std::optional<Armed> armed_;
  std::uint64_t numbers_ = 0;
  std::string running_;  // who asked for what runs
  bool ending_ = false;
  std::thread worker_, watcher_;
};

}  // namespace mm
