#pragma once
#include <string>

#include "verification/verify.h"

namespace mm {

/// What `mm verify --json` prints and the service `verify` answers in `json`: one object, in the units of
/// people. A figure that does not exist is null.
std::string verifyJson(const Verification& verification);
/// The same for people: the sentence, then a table by axis and by effect.
std::string verifyText(const Verification& verification);
/// The table's lines of the axes as one line, for the service.
std::string axesText(const Verification& verification);

}  // namespace mm
