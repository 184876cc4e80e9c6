#pragma once
#include <optional>
#include <string>

namespace mm {

/// What the last line of a certificate says of it.
struct CertificateSeal {
  std::string calibration;  // id
  std::string number;       // of the issue; empty: an older seal
  std::string checksum;     // CRC-64 of the calibration's file, 16 hexadecimal digits; empty: an older seal
  std::string session;      // hash of the session by which it was calibrated; empty: not known
  std::string sha256;       // 64 hexadecimal digits
};

/// Puts the seal behind a certificate: a comment, in HTML as in PDF, with the SHA-256 of every byte before
/// it. It has no key: it shows a change, but not who made it; who can write the file can also seal it anew.
/// @param content HTML or PDF, not sealed yet. @param seal what it shall say; its SHA-256 is found here.
std::string sealedCertificate(const std::string& content, const CertificateSeal& seal);

/// @param source path for messages. @throw InputError: no certificate, or its content does not match its
/// checksum.
CertificateSeal checkCertificate(const std::string& content, const std::string& source);

/// What a certificate of mm says of itself, its SHA-256 not compared. @return empty: it is none.
std::optional<CertificateSeal> sealOf(const std::string& content);

/// CRC-64 of a calibration's file as its first line states it. @throw InputError: it has no such line.
std::string checksumIn(const std::string& calibrationFile, const std::string& source);

/// SHA-256 as hexadecimal digits.
std::string sha256Of(const std::string& bytes);

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
