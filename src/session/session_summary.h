#pragma once
#include <string>

#include "session/session.h"

namespace mm {

/// What a session holds, in lines for people: observations, features, ranges of the joints (mm, deg),
/// temperatures, covariates, what was assumed and set aside, and the warning if there is one.
std::string summarize(const Session& session);

/// What was assumed where nothing was recorded, in one sentence; empty: nothing.
std::string assumedText(const Session& session);

/// What of the session is lost or set aside, in one line: its warning, and how much is set aside with the
/// first of it; empty: nothing.
std::string lossText(const Session& session);

/// "line 17 of plate.csv is set aside: x = -1236.4 mm; all others are within …".
std::string setAsideText(const Session& session, const SetAside& aside);

/// A line for each that is set aside; of rows that are there twice, which come by the hundred, the first
/// three and how many more.
std::vector<std::string> setAsideLines(const Session& session);

}  // namespace mm
