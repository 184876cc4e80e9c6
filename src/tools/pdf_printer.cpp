#include "tools/pdf_printer.h"

#include <chrono>

#include "base/error.h"
#include "base/temporary_folder.h"
#include "calibration_file/atomic_file.h"
#include "fleet/child_process.h"
#include "tools/interrupt.h"

namespace mm {
namespace {

constexpr std::chrono::minutes kPatience(2);
constexpr double kLook = 0.1;  // s, between two looks at Ctrl-C
const std::string kInstead = "write a page (-o certificate.html) and print it from any browser";

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
  const std::filesystem::path pdf = folder.path() / "certificate.pdf";
  ChildProcess print({"weasyprint", "--quiet", folder.path() / "certificate.html", pdf},
                     folder.path() / "log");
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (!print.endsWithin(kLook)) {
    Interrupt::check();
    if (std::chrono::steady_clock::now() > until)
      throw InputError("weasyprint has not printed within two minutes; " + kInstead);
  }
  std::error_code missing;
  // On a full disk it may leave the half of a document.
  if (print.status() != 0)
    throw InputError("weasyprint failed to print (exit status " + std::to_string(print.status()) +
                     "); is the disk full? Else " + kInstead);
  if (!std::filesystem::is_regular_file(pdf, missing) || std::filesystem::file_size(pdf, missing) == 0)
    throw InputError("weasyprint printed nothing; " + kInstead);
  return readFile(pdf);
}

}  // namespace mm
