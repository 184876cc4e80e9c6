#include "report/certificate_seal.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <chrono>

#include "base/checksum.h"
#include "base/error.h"
#include "base/format.h"
#include "base/pattern.h"
#include "base/text.h"
#include "base/utc_now.h"
#include "report/dcc_signature.h"

namespace mm {
namespace {

constexpr const char* kSealMark = "mm-certificate: calibration ";
constexpr const char* kNumberMark = " number ";
constexpr const char* kChecksumMark = " crc64 ";
constexpr const char* kSessionMark = " session ";
constexpr const char* kDigestMark = " sha256 ";
constexpr const char* kChecksumLine = "checksum: crc64-";
constexpr std::size_t kChecksumLength = 16;
constexpr std::size_t kDigestLength = 64;

/// Takes what stands behind a mark off the end of a text; empty: the mark is not there.
std::string takenOff(std::string& text, const char* mark) {
  const std::size_t at = text.find(mark);
  if (at == std::string::npos) return {};
  const std::string behind = text.substr(at + std::string(mark).size());
  text.resize(at);
  return behind;
}

}  // namespace

std::string checksumIn(const std::string& file, const std::string& source) {
  const std::string line = file.substr(0, file.find('\n'));
  if (!startsWith(line, kChecksumLine) || line.size() < std::string(kChecksumLine).size() + kChecksumLength)
    throw InputError(source + ": its first line is not a checksum, so it is not a calibration file");
  return line.substr(std::string(kChecksumLine).size(), kChecksumLength);
}

std::string sha256Of(const std::string& bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1)
    throw Error("SHA-256 is not available in this system's OpenSSL");
  return hexDigits(digest.data(), size);
}

std::string sealedCertificate(const std::string& content, const CertificateSeal& seal) {
  const bool pdf = startsWith(content, "%PDF-");
  std::string sealed = content;
  if (sealed.empty() || sealed.back() != '\n') sealed += '\n';
  sealed += std::string(pdf ? "%" : "<!-- ") + kSealMark + seal.calibration;
  if (!seal.number.empty()) sealed += kNumberMark + seal.number;
  if (!seal.checksum.empty()) sealed += kChecksumMark + seal.checksum;
  if (!seal.session.empty()) sealed += kSessionMark + seal.session;
  sealed += kDigestMark;
  // of all that stands before the digest, what the seal says of the calibration too
  return sealed + sha256Of(sealed) + (pdf ? "\n" : " -->\n");
}

std::optional<CertificateSeal> sealOf(const std::string& content) {
  const std::size_t mark = content.rfind(kSealMark), digest = content.rfind(kDigestMark);
  if (mark == std::string::npos || digest == std::string::npos || digest < mark) return std::nullopt;
  CertificateSeal seal;
  const std::size_t id = mark + std::string(kSealMark).size();
  seal.calibration = content.substr(id, digest - id);
  seal.session = takenOff(seal.calibration, kSessionMark);
  seal.checksum = takenOff(seal.calibration, kChecksumMark);
  seal.number = takenOff(seal.calibration, kNumberMark);
  seal.sha256 = content.substr(digest + std::string(kDigestMark).size(), kDigestLength);
  return seal;
}

CertificateSeal checkCertificate(const std::string& content, const std::string& source) {
  const std::optional<CertificateSeal> seal = sealOf(content);
  if (!seal)
    throw InputError(source + ": has no seal of mm certificate at its end: it is another file, or truncated");
  const std::size_t value = content.rfind(kDigestMark) + std::string(kDigestMark).size();
  const std::string actual = sha256Of(content.substr(0, value));
  const std::string after = content.substr(std::min(content.size(), value + kDigestLength));
  if (seal->sha256 != actual)
    throw InputError(source + ": its content does not match its checksum: its last line says SHA-256 " +
                     seal->sha256.substr(0, 16) + "…, the content has " + actual.substr(0, 16) +
                     "…; ask the issuer for the original");
  if (after != (startsWith(content, "%PDF-") ? "\n" : " -->\n"))
    throw InputError(
        source +
        ": there is text after its checksum, which does not cover it; ask the issuer for the original");
  return *seal;
}

std::string IssueNumber::text() const { return calibration + "-" + stamp + "-" + std::to_string(count); }

IssueNumber IssueNumber::parsed(const std::string& text) {
  static const Pattern form("(.+)-([0-9]{8}T[0-9]{9}Z)-([1-9][0-9]{0,5})");
  constexpr std::size_t kLongest = 200;  // the search goes as deep as a text is long, of a foreign file too
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
