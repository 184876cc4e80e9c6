#pragma once
#include <string>

#include "session/session.h"

namespace mm {

/// A session in the format of `mm import`: readings in mm and deg, features, references, temperatures at each
/// row. The artifact is not in it.
std::string sessionCsv(const Session& session);

}  // namespace mm
