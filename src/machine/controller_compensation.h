#pragma once
#include <string>
#include <vector>

namespace mm {

/// What a controller compensated by itself while a session was measured. What the session shows is what
/// remained beside it.
struct ControllerCompensation {
  enum class Stated { kNot, kNone, kFiles };
  struct File {
    std::string path, text;  // path: inside the folder, separated by '/'
  };
  Stated stated = Stated::kNot;
  std::string target;       // of files: the controller, as `mm export --to` names it
  std::vector<File> files;  // ascending by path

  /// CRC-64 of target, paths and texts; empty where there are no files.
  std::string checksum() const;
  /// "not stated", "none", "tables of linuxcnc (3 files, crc64-…)".
  std::string inWords() const;
};

/// The same statement, file by file.
bool operator==(const ControllerCompensation& a, const ControllerCompensation& b);
inline bool operator!=(const ControllerCompensation& a, const ControllerCompensation& b) { return !(a == b); }

/// `{"stated": "files", "target": "linuxcnc", "checksum": "crc64-…", "files": [{"path": …, "text": …}]}`; or
/// `{"stated": "none"}`; or "not_stated".
std::string compensationJson(const ControllerCompensation& compensation);
/// @param source for messages. @throw InputError: no such object, a file without its text, a checksum that
/// does not fit.
ControllerCompensation parseCompensation(const std::string& json, const std::string& source);

}  // namespace mm
