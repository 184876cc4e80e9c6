#include "import/date_in_head.h"

#include <algorithm>
#include <cstdint>

#include "base/text.h"
#include "base/utc_now.h"
#include "import/column_words.h"
#include "session/csv_cells.h"
#include "session/time_stamp.h"

namespace mm {
namespace {

/// What exporters write before it, in small letters: what can only be of the measurement, then what may be
/// that of the print as well.
constexpr std::string_view kDateNames[] = {
    "date of measurement|measurement date|date measured|measured on|date of test|test date|messdatum|"
    "datum der messung|gemessen am|messung vom|prüfdatum|date de mesure|date de la mesure|mesuré le|"
    "data di misura|data della misura|fecha de medición|fecha de la medición|meetdatum",
    "date|date time|date and time|datum|datum zeit|datum uhrzeit|data|fecha"};

/// What follows one of these names in a line; empty: it has none of them.
std::string_view behindName(std::string_view line, std::string_view names) {
  const std::size_t end = std::min(line.size(), line.find_first_of(":=;,\t0123456789"));
  if (!isOneOf(joined(wordsOf(line.substr(0, end)), " "), names)) return {};
  return trim(line.substr(end), " \t:=;,\"");
}

struct DateText {
  std::optional<std::int64_t> stamp;  // ns since 1970
  bool ambiguous = false;             // month or day first
};

/// The longest beginning of a text that is a date.
DateText dateAtBeginning(std::string_view text, const std::string& order) {
  for (;; text = trim(text.substr(0, text.find_last_of(" \t;,")), " \t;,\"")) {
    if (const auto stamp = parseCalendar(text)) return {stamp};
    const auto month = parseSlashed(text, true), day = parseSlashed(text, false);
    if (month && day && month != day && order.empty()) return {{}, true};
    if (month || day) return {month && (!day || order != "day_first") ? month : day};
    if (text.find_first_of(" \t;,") == std::string_view::npos) return {};
  }
}

}  // namespace

std::optional<double> dateInHead(const ImportContext& context) {
  constexpr std::size_t kHead = 40;  // lines
  const auto& lines = context.file.lines();
  for (const std::string_view names : kDateNames)
    for (std::size_t n = 1; n <= std::min(kHead, lines.size()); ++n) {
      const auto [stamp, ambiguous] =
          dateAtBeginning(behindName(lines[n - 1], names), context.mapping.setting("date"));
      const std::string line = "line " + std::to_string(n);
      if (ambiguous)
        context.note(line +
                     ": the order of month and day is ambiguous, and the date of measurement not used; " +
                     addToMapping("date", "day_first") + " (or month_first)");
      if (!stamp) continue;
      const double date = secondsBetween(0, *stamp);
      context.note("date of measurement " + utcText(date, "%Y-%m-%d") + ", from " + line);
      return date;
    }
  return std::nullopt;
}

}  // namespace mm
