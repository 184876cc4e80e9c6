#pragma once
#include <string>

namespace mm {

/// The style of a certificate's page, on screen and on paper. @param title, id stand at the foot of every
/// sheet; the id may come from a foreign file.
std::string certificateStyle(const std::string& title, const std::string& id);

}  // namespace mm
