#pragma once
#include <string>

namespace mm {

/// Number of one issue of a certificate: the calibration's id, when it was issued, to the millisecond, and
/// its count among the issues of this calibration that are known.
struct IssueNumber {
  std::string calibration;  // id
  std::string stamp;        // 20260302T080000123Z
  int count = 0;            // from 1; 0: no number

  std::string text() const;  // 20260301T093000Z-00c0ffee-20260302T080000123Z-1
  /// @return `count` 0: it is no such number.
  static IssueNumber parsed(const std::string& text);
};

/// Number of the certificate that a file holds. @param calibration id. @return `count` 0: it is of another
/// one, or damaged.
IssueNumber issueIn(const std::string& content, const std::string& source, const std::string& calibration);

/// Stamp of the present moment.
std::string issueStamp();

}  // namespace mm
