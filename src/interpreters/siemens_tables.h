#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "interpreters/table_sum.h"

namespace mm {

/// A compensation table of SINUMERIK as its system variables give it; mm and degrees.
struct SiemensTable {
  std::map<int, double> values;          // by interpolation point; 0 where none is given
  std::string input, output;             // joints
  std::optional<double> step, min, max;  // of the base axis
  std::optional<int> mostPoints;         // $MN_MM_CEC_MAX_POINTS, $MA_MM_ENC_COMP_MAX_POINTS
  int direction = 0;                     // +1, -1: only that direction of the base axis
  int multipliedBy = 0;                  // number of the other table (index + 1), 0: none
  bool modulo = false, enabled = true;
  double weight = 1.0;
  FilePlace place;  // where it was first named
};

/// What the files of a folder assign.
struct SiemensData {
  std::map<int, SiemensTable> cec;                // sag compensation, by index
  std::map<std::string, SiemensTable> encoder;    // leadscrew error compensation, by joint
  std::map<std::string, double> backlash;         // by joint, mm, deg
  std::map<std::string, bool> cecEnabled;         // by compensated joint, where it is said
  std::map<std::string, bool> referencedToMinus;  // $MA_REFP_CAM_DIR_IS_MINUS
};

/// Reads every *.mpf, *.spf and *.ini of the folder in the order of their names. @throw InputError naming
/// file, line and variable for what is no assignment, and for a variable of the compensations that does not
/// exist.
SiemensData readSiemensFiles(const std::filesystem::path& folder);

}  // namespace mm
