#include "tools/pdf_printer.h"

#include "base/error.h"
#include "base/text.h"
#include "fleet/child_process.h"
#include "tools/interrupt.h"
#include "workbench/temporary_file.h"

namespace mm {
namespace {

const std::string kInstead = "write a page (-o certificate.html) and print it from any browser";

}  // namespace

void requirePdfPrinter() {
  if (!onPath("weasyprint"))
    throw InputError(
        "a PDF is printed by weasyprint, which is not on the path; install it (apt install weasyprint), or " +
        kInstead);
}

std::string printedPdf(const std::string& html) {
  const TemporaryFile page(".html", html);
  int status = 0;
  std::string pdf = outputOf({"weasyprint", "--quiet", page.path().string(), "-"}, status);
  Interrupt::check();
  // On a full disk it may leave the half of a document.
  if (status != 0)
    throw InputError("weasyprint failed to print (exit status " + std::to_string(status) +
                     "); is the disk full? Else " + kInstead);
  if (pdf.empty()) throw InputError("weasyprint printed nothing; " + kInstead);
  return pdf;
}

}  // namespace mm
