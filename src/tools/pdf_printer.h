#pragma once
#include <string>

namespace mm {

/// @throw InputError: WeasyPrint, which prints a page on paper, is not on the path.
void requirePdfPrinter();

/// Prints a page on paper. @param html the page, one file. @return the bytes of the PDF. @throw InputError:
/// it cannot be printed; the message says what to do.
std::string printedPdf(const std::string& html);

}  // namespace mm
