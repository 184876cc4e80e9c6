#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

namespace mm {

/// A calendar time as people and loggers write it, in ns since 1970-01-01 UTC: ISO 8601
/// (2026-11-21T10:15:03.25, a blank for the T, Z or +01:00 at the end, without a zone taken as UTC),
/// 2026/11/21 10:15, or day first with points (21.11.2026 10:15:03,5). A day without a time is its midnight.
/// Nothing for what may be read in two ways (11/12/2026) or is no such time.
std::optional<std::int64_t> parseCalendar(std::string_view text);

/// A calendar time with slashes, month first (11/21/2026 2:05 PM) or day first (21/11/2026 14:05): which of
/// the two must be known.
std::optional<std::int64_t> parseSlashed(std::string_view text, bool monthFirst);

/// A time of day, `10:15`, `10:15:03.5`, `2:05:01 PM`: ns since midnight.
std::optional<std::int64_t> parseClock(std::string_view text);

}  // namespace mm
