#pragma once
#include <string>
#include <vector>

#include "machine/machine.h"
#include "session/time_stamp.h"

namespace mm {

/// What a column of a table holds.
enum class CsvRole {
  kTime,
  kPosition,
  kVelocity,
  kReading,
  kFeature,
  kReference,
  kLength,
  kDeviation,
  kDeviationStd,
  kSetup,
  kPlacement,
  kStylus,
  kTemperature,
  kCovariate,
  // Only in other people's tables:
  kDate,       // the day of a time of day
  kMeasured,   // indicated by an independent instrument where kPosition was the target
  kDirection,  // of the motion to the target
  kIgnored
};

/// One column: its role, and which joint, component, sensor or covariate (`index`) it belongs to.
struct CsvColumn {
  CsvRole role = CsvRole::kTime;
  int index = 0;
  double factor = 1.0;  // value in SI (degC, a covariate's own unit) = cell * factor + offset
  std::string header;   // as written
  std::string name;     // of a sensor or covariate, without the unit
  std::string unit;
  double offset = 0.0;
  TimeForm timeForm = TimeForm::kNumber;
  std::string suffix;  // behind the number in each cell: "mm"
};

/// What the number in a column is.
enum class RoleQuantity {
  kNone,
  kTime,
  kLength,
  kTemperature,
  kReadingOfJoint,
  kErrorOfJoint,
  kSpeedOfJoint
};

/// What is known of a role, whatever a file calls its columns. In both texts % stands for the joint, for x, y
/// or z, or for the name of what was logged; in the column's name a rotary joint has deg for mm, arcsec for
/// um.
struct RoleFacts {
  CsvRole role;
  RoleQuantity quantity;
  const char* column;   // in the package's own format, or in a mapping
  const char* meaning;  // for people
};
const RoleFacts& factsOf(CsvRole role);  ///< every role has its own
/// One of the texts with the name in it. @param index of the joint or component.
std::string columnName(CsvRole role, int index, const std::string& name, const Machine& machine);
std::string roleText(CsvRole role, int index, const std::string& name, const Machine& machine);

/// The columns whose names are fixed by the machine: `time_s`, `x_mm`, `deviation_x_um`, ….
std::vector<std::string> fixedColumns(const Machine& machine);

/// Understands the header of a CSV in the import format. @param place `file:line` for messages.
/// @throw InputError for a column that is unknown, doubled, without a name or in another unit than the
/// format's.
std::vector<CsvColumn> parseCsvHeader(const std::vector<std::string>& names, const Machine& machine,
                                      const std::string& place);

}  // namespace mm
