#include "workbench/bench_log.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "base/json_text.h"
#include "base/utc_now.h"

namespace mm {
namespace {

std::string oneLineOf(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  return text;
}

/// @return the last character of a file that is open; a line's end where it has none, or cannot be read.
char lastOf(const std::filesystem::path& file, int descriptor) {
  struct stat now {};
  char last = '\n';
  if (::fstat(descriptor, &now) != 0 || now.st_size == 0) return last;
  const int reader = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (reader < 0) return last;
  if (::pread(reader, &last, 1, now.st_size - 1) != 1) last = '\n';
  ::close(reader);
  return last;
}

/// Appends a line. One that the disk cut short before stays as it is: the next begins behind it. @return
/// whether all of it was written.
bool append(const std::filesystem::path& file, std::string line) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0) return false;
  if (lastOf(file, descriptor) != '\n') line.insert(0, 1, '\n');
  std::size_t done = 0;
  while (done < line.size()) {
    const ssize_t more = ::write(descriptor, line.data() + done, line.size() - done);
    if (more < 0 && errno == EINTR) continue;
    if (more <= 0) break;
    done += static_cast<std::size_t>(more);
  }
  return ::close(descriptor) == 0 && done == line.size();
}

}  // namespace

BenchLog::BenchLog() : writer_([this] { write(); }) {}

BenchLog::~BenchLog() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  writer_.join();
}

void BenchLog::goOnIn(const std::filesystem::path& file) {
  const std::lock_guard<std::mutex> lock(mutex_);
  file_ = file;
}

void BenchLog::add(const std::string& who, const std::string& what) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    lines_.push_front({++numbers_, utcNow(), oneLineOf(who), oneLineOf(what)});
    if (lines_.size() > kKept) lines_.pop_back();
    if (file_.empty()) return;
    Waiting next{lines_.front(), file_};
    if (waiting_.size() >= kMostWaiting) return markUnwritten(next);
    waiting_.push_back(std::move(next));
  }
  changed_.notify_all();
}

void BenchLog::write() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return ending_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    const Waiting next = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    std::error_code failed;
    std::filesystem::create_directories(next.file.parent_path(), failed);
    const bool written =
        append(next.file, next.line.time + "  " + next.line.who + "  " + next.line.what + "\n");
    lock.lock();
    if (!written) markUnwritten(next);
  }
}

void BenchLog::markUnwritten(const Waiting& lost) {
  for (Line& line : lines_)
    if (line.number == lost.line.number)
      line.what += " (this line could not be written to " + lost.file.string() + ")";
}

std::string BenchLog::json() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto entry = [](const Line& line) -> Json {
    return {{"time", line.time}, {"who", line.who}, {"what", line.what}};
  };
  return jsonLine({{"lines", jsonList(lines_, entry)}, {"file", file_.string()}});
}

}  // namespace mm
