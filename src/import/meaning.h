#pragma once
#include <optional>
#include <string>

#include "import/unit.h"
#include "machine/machine.h"
#include "session/csv_columns.h"

namespace mm {

/// What a column is, before its unit is looked at.
struct Meaning {
  CsvRole role = CsvRole::kIgnored;
  int index = 0;                 // of the joint or component
  std::string name;              // of a sensor or covariate
  std::string why;               // of a column that is left out
  bool reversed = false;         // an error (indicated minus true) is a deviation with its sign changed
  std::optional<UnitKind> kind;  // what its unit must be
  bool axisOfTable = false;      // its joint is that of the table, not of its name
  bool needsAxis = false;        // which joint is not said
  bool unclearSign = false;      // "error"
};

/// A length for a linear joint, an angle for a rotary one.
UnitKind unitKindOf(const Machine& machine, int joint);
/// A meaning with the kind of unit that it wants.
Meaning meaningOf(CsvRole role, int index, const Machine& machine, const std::string& name = "");
/// A column that is left out. @param why in words.
Meaning leftOut(const std::string& why);
/// What a column of the import format is.
Meaning meaningOf(const CsvColumn& column, const Machine& machine);

/// "reading of joint x", "temperature bed", "left out: a note".
std::string meaningText(const Meaning& meaning, const Machine& machine);
/// How it is written into a mapping: "deviation_x_um".
std::string exampleOf(const Meaning& meaning, const Machine& machine);

/// The joint of that name in any case, or -1.
int jointOf(const Machine& machine, const std::string& name);
/// "x, y, z": for messages.
std::string jointNames(const Machine& machine);

}  // namespace mm
