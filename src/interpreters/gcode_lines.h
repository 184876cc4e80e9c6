#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "interpreters/interpreter.h"
#include "interpreters/table_text.h"

namespace mm {

/// A command of a file of G-code: `M852 I0.001` is command M852 with the rest ` I0.001`.
struct GcodeCommand {
  std::string name;  // letter and number in capitals, M852
  std::string rest;
  FilePlace place;

  /// Letters of the rest with their numbers; a letter may stand without one.
  /// @throw InputError for what is neither, and for a letter that is there twice.
  std::map<char, std::optional<double>> words() const;
};

/// The commands of a file, remarks (`;`, parentheses), numbers of lines and checksums taken off.
std::vector<GcodeCommand> gcodeCommands(const std::filesystem::path& file);

/// Backlash of axes as firmware of printers takes it up: the whole of it is added at a change of direction,
/// and the motion before the first one is taken as a positive one, so that positive motions add nothing.
class ReversalBacklash {
 public:
  void set(const std::string& joint, double distance) { distances_[joint] = distance; }  ///< m, rad
  /// What is added to the motor of a joint. @param direction of its last motion, 0: not known.
  double added(const std::string& joint, int direction) const;
  void addTo(JointPoints& points) const;  ///< the joints that have one

 private:
  std::map<std::string, double> distances_;
};

}  // namespace mm
