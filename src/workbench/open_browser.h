#pragma once
#include <string>

namespace mm {

/// Opens an address in the browser of the desktop (xdg-open). @return whether there is one to ask.
bool openBrowser(const std::string& url);

}  // namespace mm
