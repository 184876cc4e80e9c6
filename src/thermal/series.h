#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

namespace mm {

/// Quantities sampled together: one row a sample, in the order of time, one named column a quantity, in the
/// unit of its name (temperatures in degC, displacements in um or mm).
struct SampledSeries {
  std::vector<std::string> names;
  Eigen::MatrixXd values;  // samples x columns

  int samples() const { return static_cast<int>(values.rows()); }  ///< rows
  /// Index of a column by its exact name. Throws InputError that lists the names there are.
  int column(const std::string& name) const;
};

/// Reads a CSV with one line of names and then numbers only. Lines that are empty or begin with '#' are
/// skipped. Throws InputError, naming file and line, for doubled or empty names, rows that are too short or
/// too long, and cells that are not finite numbers.
SampledSeries readSeries(const std::string& path);

/// True for the columns that hold the time of a sample rather than a measurement: t, time, or time_<unit>.
bool isTimeColumn(const std::string& name);

/// Factor from the unit at the end of a column's name (_nm, _um, _mm, _m) to micrometres; 1 without such an
/// ending.
double micrometresPerUnit(const std::string& name);

}  // namespace mm
