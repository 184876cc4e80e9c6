#pragma once
#include <filesystem>
#include <string>

namespace mm {

/// What a file that `mm` reads or writes holds, as its first bytes tell.
enum class FileKind {
  kNothing,      // does not exist, or is empty
  kStream,       // a pipe, a terminal, /dev/null: nothing in it can be lost
  kBag,          // a session
  kCalibration,  // also a damaged one
  kPage,         // of mm report
  kCertificate,  // PDF, page or DCC
  kPicture,      // SVG
  kMachine,      // URDF
  kModel,
  kArtifact,
  kPlan,
  kMoves,   // the plan that a diagnosis proposes
  kKey,     // of a blind trial
  kTruth,   // what mm simulate hid
  kTable,   // a CSV of measurements
  kStates,  // the CSV that mm apply corrected
  kCurve,   // RMS of each generation
  kOther,
};

/// Reads at most 64 kB of it. A file that cannot be read is kOther.
FileKind kindOf(const std::filesystem::path& file);
/// "a session's bag": for messages.
std::string nameOf(FileKind kind);

}  // namespace mm
