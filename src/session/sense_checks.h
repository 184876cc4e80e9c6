#pragma once
#include <string>
#include <vector>

#include "session/session.h"

namespace mm {

/// A question about a session: what is likely not in the unit, sign or order that its name says.
struct Doubt {
  std::string question;          // one line, with the figures
  double before = kNotMeasured;  // m: how badly the geometry agrees as it is; NaN: not judged by the geometry
  double after = kNotMeasured;   // m: and how well with what is asked
  /// What was read is so far from what can be that it must be answered before any physics is asked.
  bool first = false;
};

/// Asks about units, signs and names before any physics: temperatures in kelvin or Fahrenheit; readings in
/// inches, metres or micrometres, in radians or degrees; reversed or exchanged joints, permuted balls, a
/// reversed approach, a reference that is the reading itself. A geometric question is asked only where the
/// balls (or the instrument's positions) disagree far beyond any machine's errors, and agree when it is
/// answered with yes. Empty: nothing strange.
/// @param session prepared.
std::vector<Doubt> sensibleDoubts(const Session& session);

/// Those of them that need no geometry: readings far beyond the machine's travel (another unit), joints that
/// are within their travels only when exchanged, deviations that are too large or too small for any machine
/// (positions, another unit), rows that are there twice, times that go back or last too long. Each question
/// has its evidence.
/// @param session prepared. @param travels whether readings beyond the travel are asked for: where the
/// geometry has already told which unit or joint is wrong, they need no question of their own.
std::vector<Doubt> rowDoubts(const Session& session, bool travels = true);

}  // namespace mm
