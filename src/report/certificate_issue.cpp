#include "report/certificate_issue.h"

#include <chrono>
#include <ctime>
#include <regex>

#include "base/format.h"

namespace mm {

std::string IssueNumber::text() const { return calibration + "-" + stamp + "-" + std::to_string(count); }

IssueNumber IssueNumber::parsed(const std::string& text) {
  static const std::regex form("(.+)-([0-9]{8}T[0-9]{9}Z)-([1-9][0-9]{0,5})");
  std::smatch parts;
  if (!std::regex_match(text, parts, form)) return {};
  return {parts[1], parts[2], std::stoi(parts[3])};
}

std::string issueStamp() {
  using namespace std::chrono;
  const auto milli = duration_cast<milliseconds>(system_clock::now().time_since_epoch()).count();
  const auto now = static_cast<std::time_t>(milli / 1000);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  return std::string(text, std::strftime(text, sizeof text, "%Y%m%dT%H%M%S", &utc)) +
         format("%03dZ", static_cast<int>(milli % 1000));
}

}  // namespace mm
