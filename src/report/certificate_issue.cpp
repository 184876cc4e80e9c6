#include "report/certificate_issue.h"

#include <chrono>

#include "base/error.h"
#include "base/format.h"
#include "base/pattern.h"
#include "base/utc_now.h"
#include "report/dcc_signature.h"

namespace mm {

std::string IssueNumber::text() const { return calibration + "-" + stamp + "-" + std::to_string(count); }

IssueNumber IssueNumber::parsed(const std::string& text) {
  static const Pattern form("(.+)-([0-9]{8}T[0-9]{9}Z)-([1-9][0-9]{0,5})");
  constexpr std::size_t kLongest =
      200;  // the search goes as deep as the text is long, and it may be a foreign file's
  if (text.size() > kLongest) return {};
  const std::vector<std::string> parts = form.parts(text);
  if (parts.empty()) return {};
  return {parts[1], parts[2], std::stoi(parts[3])};
}

IssueNumber issueIn(const std::string& content, const std::string& source, const std::string& calibration) {
  std::optional<CertificateSeal> seal;
  try {
    seal = isDcc(content) ? dccContents(content, source) : sealOf(content);
  } catch (const InputError&) {
    return {};
  }
  const IssueNumber found = seal ? IssueNumber::parsed(seal->number) : IssueNumber();
  return found.calibration == calibration ? found : IssueNumber();
}

std::string issueStamp() {
  using namespace std::chrono;
  const auto milli = duration_cast<milliseconds>(system_clock::now().time_since_epoch()).count();
  return utcText(static_cast<double>(milli / 1000), "%Y%m%dT%H%M%S") +
         format("%03dZ", static_cast<int>(milli % 1000));
}

}  // namespace mm
