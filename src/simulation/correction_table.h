#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "machine/machine.h"

namespace mm {

/// The compensation table that the simulated controller has loaded: what it adds to a commanded position
/// before it drives there. The operator and every record go on to see the commanded position, as on LinuxCNC
/// or a CNC with a pitch error table: a table that is right makes the tip go where it was sent.
///
/// A CSV: columns `<joint>_mm` (`_deg` of a rotary joint) and `<joint>_travel` (-1, +1) say where a row
/// holds, `correction_<joint>_um` (`_arcsec`) what is added there. The rows are a complete grid, in any
/// order; between its nodes it is linear in each coordinate, beyond them as at its edge. Immutable.
class CorrectionTable {
 public:
  /// @throw InputError naming file, line and column: unknown columns, no number, a grid with gaps.
  static CorrectionTable load(const std::filesystem::path& file, const Machine& machine);
  /// The same from text. @param source what messages call it.
  static CorrectionTable parse(const std::string& text, const std::string& source, const Machine& machine);

  /// Where the drives go for a command, m or rad. @param travel a joint: -1, +1, or 0 where it has not moved
  /// yet (then the mean of both directions).
  std::vector<double> drives(const std::vector<double>& command, const std::vector<double>& travel) const;

 private:
  /// One coordinate of the grid.
  struct Coordinate {
    int joint = 0;
    bool travel = false;
  };
  std::vector<Coordinate> coordinates_;
  std::vector<std::vector<double>> nodes_;  // of each, ascending, m or rad; -1, +1
  std::vector<int> corrected_;              // joints that have a correction
  std::vector<double> values_;  // node by node, the last coordinate fastest; a corrected joint each, m or rad
};

}  // namespace mm
