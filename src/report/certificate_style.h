#pragma once
#include <string>

namespace mm {

/// The style of a certificate's page, on screen and on paper. @param id stands at the foot of every sheet; it
/// may come from a foreign file.
std::string certificateStyle(const std::string& id);

}  // namespace mm
