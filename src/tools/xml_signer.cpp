#include "tools/xml_signer.h"

#include <chrono>

#include "base/error.h"
#include "base/temporary_folder.h"
#include "calibration_file/atomic_file.h"
#include "fleet/child_process.h"
#include "tools/interrupt.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::minutes kSignerPatience(1);
constexpr double kSignerLook = 0.1;  // s, between two looks at Ctrl-C

/// Runs xmlsec1 with its key by name alone: what else a document says of its key is not used.
/// @return its exit status.
int ranXmlSigner(std::vector<std::string> words, const fs::path& log) {
  words.insert(words.begin(), "xmlsec1");
  words.insert(words.begin() + 2, {"--enabled-key-data", "key-name"});
  ChildProcess process(words, log);
  const auto until = std::chrono::steady_clock::now() + kSignerPatience;
  while (!process.endsWithin(kSignerLook)) {
    Interrupt::check();
    if (std::chrono::steady_clock::now() > until)
      throw InputError("xmlsec1 has not ended within a minute; try again");
  }
  return process.status();
}

}  // namespace

void requireXmlSigner() {
  if (!onPath("xmlsec1"))
    throw InputError(
        "an XML certificate is signed and verified by xmlsec1, which is not on the path; install it (apt "
        "install "
        "xmlsec1), or write the certificate without --sign");
}

std::string signedXml(const std::string& prepared, const fs::path& key, const std::string& name) {
  const TemporaryFolder folder;
  folder.write("prepared.xml", prepared);
  // A comma in the path would divide it; the key itself is not copied.
  fs::create_symlink(fs::absolute(key), folder.path() / "key.pem");
  const fs::path out = folder.path() / "signed.xml", log = folder.path() / "log";
  const int status = ranXmlSigner({"--sign", "--privkey-pem:" + name, folder.path() / "key.pem", "--output",
                                   out, folder.path() / "prepared.xml"},
                                  log);
  std::error_code missing;
  if (status != 0 || !fs::is_regular_file(out, missing) || fs::file_size(out, missing) == 0)
    throw InputError("xmlsec1 did not sign with " + key.string() + " (exit status " + std::to_string(status) +
                     "): " + lastWordsOf(log) + "; is the disk full? Else name another key");
  return readFile(out);
}

bool signatureIsValid(const std::string& xml, const std::string& publicKey, const std::string& name) {
  const TemporaryFolder folder;
  folder.write("signed.xml", xml);
  folder.write("public.pem", publicKey);
  const fs::path log = folder.path() / "log";
  const int status = ranXmlSigner(
      {"--verify", "--pubkey-pem:" + name, folder.path() / "public.pem", folder.path() / "signed.xml"}, log);
  if (status > 1)  // it ended before it could judge
    throw InputError("xmlsec1 could not verify the signature (exit status " + std::to_string(status) +
                     "): " + lastWordsOf(log) + "; try again");
  return status == 0;
}

}  // namespace mm
