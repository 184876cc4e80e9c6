#include "workbench/bench_log.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "base/utc_now.h"

namespace mm {
namespace {

std::string oneLineOf(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  return text;
}

}  // namespace

void BenchLog::add(const std::string& who, const std::string& what) {
  const std::lock_guard<std::mutex> lock(mutex_);
  lines_.push_front({utcNow(), oneLineOf(who), oneLineOf(what)});
  if (lines_.size() > kKept) lines_.pop_back();
  if (file_.empty()) return;
  std::error_code failed;
  std::filesystem::create_directories(file_.parent_path(), failed);
  std::ofstream out(file_, std::ios::app);
  const Line& line = lines_.front();
  out << line.time << "  " << line.who << "  " << line.what << '\n';
  if (out.flush()) return;
  lines_.front().what += " (this line could not be written to " + file_.string() + ")";
}

std::string BenchLog::json() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Line& line : lines_)
    list.push_back({{"time", line.time}, {"who", line.who}, {"what", line.what}});
  return nlohmann::ordered_json{{"lines", std::move(list)}, {"file", file_.string()}}.dump(
      -1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace mm
