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

}  // namespace mm
