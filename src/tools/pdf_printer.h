#pragma once
#include <string>

namespace mm {

/// The first of chromium, chromium-browser, google-chrome and google-chrome-stable on the path, or what
/// $MM_CHROMIUM names; empty: none.
std::string findBrowser();

/// Prints a page on paper by a browser without a window. @param browser as findBrowser. @param html the page,
/// one file. @return the bytes of the PDF. @throw InputError: it cannot be started, or printed nothing within
/// two minutes; the message says what to do. Cancelled.
std::string printedPdf(const std::string& browser, const std::string& html);

}  // namespace mm
