#include "tools/outside_programs.h"

#include <chrono>

#include "base/error.h"
#include "base/temporary_folder.h"
#include "calibration_file/atomic_file.h"
#include "fleet/child_process.h"
#include "tools/interrupt.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

const std::string kInstead = "write a page (-o certificate.html) and print it from any browser";

/// Runs a program to its end. @return its exit status. @throw InputError: `tooLong`;
/// Cancelled by Ctrl-C.
int ran(const std::vector<std::string>& words, const fs::path& log, std::chrono::minutes patience,
        const std::string& tooLong) {
  constexpr double kLook = 0.1;  // s, between two looks at Ctrl-C
  ChildProcess process(words, log);
  const auto until = std::chrono::steady_clock::now() + patience;
  while (!process.endsWithin(kLook)) {
    Interrupt::check();
    if (std::chrono::steady_clock::now() > until) throw InputError(tooLong);
  }
  return process.status();
}

/// Whether it wrote anything: on a full disk it may leave nothing.
bool wrote(const fs::path& file) {
  std::error_code missing;
  return fs::is_regular_file(file, missing) && fs::file_size(file, missing) > 0;
}

/// Runs xmlsec1 with its key by name alone: what else a document says of its key is not used.
/// @return its exit status.
int ranXmlSigner(std::vector<std::string> words, const fs::path& log) {
  words.insert(words.begin(), "xmlsec1");
  words.insert(words.begin() + 2, {"--enabled-key-data", "key-name"});
  return ran(words, log, std::chrono::minutes(1), "xmlsec1 has not ended within a minute; try again");
}

}  // namespace

void requirePdfPrinter() {
  if (!onPath("weasyprint"))
    throw InputError(
        "a PDF is printed by weasyprint, which is not on the path; install it (apt install weasyprint), or " +
        kInstead);
}

std::string printedPdf(const std::string& html) {
  const TemporaryFolder folder;
  folder.write("certificate.html", html);
  const fs::path pdf = folder.path() / "certificate.pdf";
  const int status =
      ran({"weasyprint", "--quiet", folder.path() / "certificate.html", pdf}, folder.path() / "log",
          std::chrono::minutes(2), "weasyprint has not printed within two minutes; " + kInstead);
  // On a full disk it may leave the half of a document.
  if (status != 0)
    throw InputError("weasyprint failed to print (exit status " + std::to_string(status) +
                     "); is the disk full? Else " + kInstead);
  if (!wrote(pdf)) throw InputError("weasyprint printed nothing; " + kInstead);
  return readFile(pdf);
}

void requireXmlSigner() {
  if (!onPath("xmlsec1"))
    throw InputError(
        "an XML certificate is signed and verified by xmlsec1, which is not on the path; install it (apt "
        "install xmlsec1), or write the certificate without --sign");
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
  if (status != 0 || !wrote(out))
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
