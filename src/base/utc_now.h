#pragma once
#include <string>

namespace mm {

/// A time, UTC, by a format of strftime. @param epoch s since 1970. Empty: it is no time.
std::string utcText(double epoch, const char* format = "%Y-%m-%dT%H:%M:%SZ");

/// The time now, UTC, by a format of strftime; by default as ISO 8601 writes it: 2026-03-01T09:30:00Z.
std::string utcNow(const char* format = "%Y-%m-%dT%H:%M:%SZ");

}  // namespace mm
