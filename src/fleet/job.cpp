#include "fleet/job.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>

#include "base/checksum.h"
#include "base/error.h"
#include "base/number_text.h"
#include "base/version.h"
#include "base/yaml_mapping.h"
#include "calibration_file/atomic_file.h"
#include "fleet/fields.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

/// SHA-1 of parts, each with its length before it, so that no two lists of parts give the same bytes.
class PartsHash {
 public:
  PartsHash() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha1(), nullptr) != 1)
      throw InputError("OpenSSL has no SHA-1 here; jobs cannot be named: use a build of it that has");
  }
  void part(const std::string& text) {
    length(text.size());
    bytes(text.data(), text.size());
  }
  /// A file's bytes, which may be many.
  void file(const fs::path& path) {
    std::error_code failed;
    const auto size = fs::file_size(path, failed);
    std::ifstream in(path, std::ios::binary);
    if (failed || !in)
      throw InputError(path.string() + ": cannot be read (" +
                       (failed ? failed.message() : std::strerror(errno)) +
                       "); check the path and its permissions");
    length(size);
    std::vector<char> block(kBlock);
    std::uintmax_t read = 0;
    while (in.read(block.data(), kBlock) || in.gcount() > 0) {
      bytes(block.data(), in.gcount());
      read += in.gcount();
    }
    if (in.bad())
      throw InputError(path.string() + ": cannot be read to its end: the disk reports an error; run again");
    if (read != size)
      throw InputError(path.string() + ": " + std::to_string(read) + " of its " + std::to_string(size) +
                       " bytes could be read; wait until it is complete, and run again");
  }
  /// The first 32 hexadecimal digits.
  std::string digits() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    EVP_DigestFinal_ex(context_.get(), digest.data(), nullptr);
    return hexDigits(digest.data(), 16);
  }
  void bytes(const char* data, std::size_t size) { EVP_DigestUpdate(context_.get(), data, size); }

 private:
  void length(std::uintmax_t size) {
    const std::string head = std::to_string(size) + ':';
    bytes(head.data(), head.size());
  }
  static constexpr std::streamsize kBlock = 1 << 18;
  std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context_;
};

/// The URDF that a model names by a path; empty: it names none, or one of the package.
std::string machineFileOf(const std::string& model, const fs::path& file) {
  const YAML::Node root = YamlMapping::load(model, file.string());
  if (!root.IsMap() || !root["machine"] || !root["machine"].IsScalar()) return {};
  const fs::path named = file.parent_path() / root["machine"].as<std::string>();
  std::error_code ignored;
  return fs::is_regular_file(named, ignored) ? readFile(named) : std::string();
}

}  // namespace

const std::vector<std::string>& batchSteps() {
  static const std::vector<std::string> steps{"check",   "calibrate", "diagnose",
                                              "add_all", "verify",    "report"};
  return steps;
}

bool BatchJob::does(const std::string& step) const {
  return std::find(steps.begin(), steps.end(), step) != steps.end();
}

std::string keyOf(const BatchJob& job) {
  PartsHash hash;
  static const std::string kKind = "mm job 2\n";
  hash.bytes(kKind.data(), kKind.size());
  hash.part(kVersion);
  hash.file(job.bag);
  const std::string model = job.model.empty() ? std::string() : readFile(job.model);
  hash.part(model);
  hash.part(job.model.empty() ? std::string() : machineFileOf(model, job.model));
  hash.part(job.calibration.empty() ? std::string() : readFile(job.calibration));
  hash.part(job.space);
  for (const std::string& step : job.steps) hash.part(step);
  hash.part(job.method);
  hash.part(std::to_string(job.seed));
  hash.part(numberText(job.repeatability));
  hash.part(job.does("verify") && job.loaded ? "loaded" : "");
  hash.part(job.does("report") ? job.serial : std::string());
  return hash.digits();
}

nlohmann::json jobJson(const BatchJob& job) { return fieldsJson<nlohmann::json>(job); }

BatchJob jobOf(const nlohmann::json& json) {
  BatchJob job;
  readFields(json, job);
  return job;
}

}  // namespace mm
