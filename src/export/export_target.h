#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "export/needed_correction.h"

namespace mm {

/// A file of an export: its place in the folder and what it is for.
struct ExportedFile {
  std::string path, what, text;
};

/// What an exporter makes of a calibration: tables in the target's own form, and what its page must say.
struct Exported {
  std::vector<ExportedFile> files;
  std::string holds;                     // what this target has a place for, in one sentence
  std::vector<std::string> load;         // what to load where, in this order
  std::string reference;                 // from which point positions count
  std::vector<std::string> unverified;   // what public documents do not say
  std::vector<std::string> notes;        // what else was decided
  std::vector<std::string> notFollowed;  // curves that bend between the points of any table that fits
  /// What a program of ours adds beside the tables: m, an axis' letter each. Null: there is none.
  std::function<std::map<std::string, double>(const State&)> alsoAdds;
  std::map<std::string, std::string> sensors;  // the controller's name of a sensor -> the calibration's
};

/// Takes over what notFollowed() tells of a table.
void addNotFollowed(const std::vector<std::string>& told, Exported& out);
/// The state as the controller knows it, sensors by its names, too.
CommandedState commandTo(const NeededCorrection& needed, const State& state, const Exported& exported);

/// What a user may choose.
struct ExportOptions {
  std::map<std::string, std::string> letters;  // joint -> letter of the controller's axis
  double detectionUnit = 1e-6;                 // m, of Fanuc's pitch error data
  bool tablesAlone = false;                    // of LinuxCNC: without external offsets
  double rapidRate = 0.0;                      // m/s, of Fanuc; 0: the velocity limit of each joint
};

/// One controller.
struct ExportTarget {
  std::string name;   // as it is typed: linuxcnc
  std::string title;  // for people: LinuxCNC
  Exported (*write)(const NeededCorrection& needed, const ExportOptions& options);
};

/// All of them, in the order of the documents. A new one is a file pair and a line here.
const std::vector<ExportTarget>& exportTargets();
/// @throw InputError naming the targets that there are.
const ExportTarget& exportTarget(const std::string& name);
std::vector<std::string> exportTargetNames();

/// A number with `digits` behind the point and no minus before a zero.
std::string fixed(double value, int digits);
/// "X", of "x".
std::string capital(const std::string& letter);

}  // namespace mm
