#pragma once
#include <map>
#include <set>
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
  std::set<std::string> axes;            // letters of the axes that they are for: those of the others stay
  std::string holds;                     // what this target has a place for, in one sentence
  std::vector<std::string> load;         // the steps that put them into the controller, in this order
  std::string reference;                 // from which point positions count
  std::vector<std::string> unverified;   // what public documents do not say, or the figures leave out
  std::vector<std::string> notes;        // what else was decided
  std::vector<std::string> notFollowed;  // curves that bend between the points of any table that fits
  bool offsets = false;                  // a program of ours adds more, beside the tables (ExternalOffsets)
  std::map<std::string, std::string> sensors;  // the controller's name of a sensor -> the calibration's
};

/// What a user may choose.
struct ExportOptions {
  std::map<std::string, std::string> letters;  // joint -> letter of the controller's axis
  double detectionUnit = 1e-6;                 // m, of Fanuc's pitch error data
  bool tablesAlone = false;                    // of LinuxCNC: without external offsets
  double rapidRate = 0.0;                      // m/s, of Fanuc; 0: the velocity limit of each joint
};

/// One controller.
struct ExportTarget {
  std::string name;    // as it is typed: linuxcnc
  std::string title;   // for people: LinuxCNC
  std::string remark;  // what a remark begins with; empty: its files have none
  std::string beside;  // what else compensates the same errors in this controller
  Exported (*write)(const NeededCorrection& needed, const ExportOptions& options);
};

/// What a target makes of a calibration, with the statement which compensation was active in its first file
/// that has a place for remarks, and with what of that stays as it was (folder `kept`).
/// @throw InputError: another controller's compensation was active; as ExportTarget::write.
Exported exportedFor(const ExportTarget& target, const NeededCorrection& needed,
                     const ExportOptions& options);

/// Which compensation was active while measuring, what was assumed where nobody stated it, and what the
/// tables do with it: one or two sentences.
std::string activeWords(const ExportTarget& target, const NeededCorrection& needed, const Exported& exported);

/// All of them, in the order of the documents. A new one is a file, and a line here and in targets.h.
const std::vector<ExportTarget>& exportTargets();
/// @throw InputError naming the targets that there are.
const ExportTarget& exportTarget(const std::string& name);
std::vector<std::string> exportTargetNames();

/// A number with `digits` behind the point and no minus before a zero.
std::string fixed(double value, int digits);
/// "X", of "x".
std::string capital(const std::string& letter);

}  // namespace mm
