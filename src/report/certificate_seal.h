#pragma once
#include <string>

namespace mm {

/// What the last line of a certificate says of it.
struct CertificateSeal {
  std::string calibration;  // id
  std::string sha256;       // 64 hexadecimal digits
};

/// Puts the seal behind a certificate: a comment, in HTML as in PDF, with the SHA-256 of every byte before
/// it. It finds any change; who can write the file can also seal it anew, so that the digest must be kept, or
/// printed, elsewhere where that is to be feared. @param content HTML or PDF, not sealed yet.
std::string sealedCertificate(const std::string& content, const std::string& calibration);

/// @param source path for messages. @throw InputError: no certificate, or changed after it was issued.
CertificateSeal checkCertificate(const std::string& content, const std::string& source);

/// SHA-256 as hexadecimal digits.
std::string sha256Of(const std::string& bytes);

}  // namespace mm
