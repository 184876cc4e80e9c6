#include "tools/file_kind.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <sstream>

#include "base/read_file.h"
#include "base/text.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

// What is there is not known, so that it is not replaced.
constexpr const char* kRemedy = "name another file";

std::string beginningOf(const fs::path& file) {
  constexpr std::size_t kEnough = 64 * 1024;
  return readPartOfFile(file, 0, kEnough, kRemedy);
}

std::string endOf(const fs::path& file) {
  constexpr std::size_t kEnough = 512;
  const std::size_t size = fs::file_size(file);
  return readPartOfFile(file, size - std::min(size, kEnough), kEnough, kRemedy);
}

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// The keys at the outermost level of a YAML text, found without its parser: the text may be cut.
std::set<std::string> outermostKeys(const std::string& text) {
  std::set<std::string> keys;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    std::size_t end = 0;
    while (end < line.size() && (std::isalnum(static_cast<unsigned char>(line[end])) || line[end] == '_'))
      ++end;
    if (end > 0 && end < line.size() && line[end] == ':') keys.insert(line.substr(0, end));
  }
  return keys;
}

FileKind kindOfYaml(const std::string& text) {
  const std::set<std::string> keys = outermostKeys(text);
  const auto has = [&](const char* key) { return keys.count(key) > 0; };
  if (has("checksum") || has("covariance_si")) return FileKind::kCalibration;
  if (has("hidden") && has("features_mm")) return FileKind::kTruth;
  if (has("trial") && has("correction_on")) return FileKind::kKey;
  if (has("moves") && startsWith(text, "name: next_measurement\n")) return FileKind::kMoves;
  for (const char* key : {"touch", "postures", "reference", "moves"})
    if (has(key)) return FileKind::kPlan;
  if (has("effects")) return FileKind::kModel;
  if (has("balls") || has("points")) return FileKind::kArtifact;
  return FileKind::kOther;
}

FileKind kindOfTable(const std::string& header) {
  if (startsWith(header, "generation,rms_")) return FileKind::kCurve;
  if (holds(header, "corrected_x_mm")) return FileKind::kStates;
  return FileKind::kTable;
}

}  // namespace

FileKind kindOf(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) return FileKind::kNothing;
  if (fs::is_directory(status)) return FileKind::kOther;
  if (!fs::is_regular_file(status)) return FileKind::kStream;
  if (fs::file_size(file, error) == 0 && !error) return FileKind::kNothing;
  const std::string text = beginningOf(file);
  if (startsWith(text, "#ROSBAG")) return FileKind::kBag;
  if (startsWith(text, "%PDF-"))
    return holds(endOf(file), "%mm-certificate: ") ? FileKind::kCertificate : FileKind::kOther;
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos || holds(text, std::string(1, '\0'))) return FileKind::kOther;
  if (text[first] == '<') {
    if (holds(text, "measuring machine report</title>")) return FileKind::kPage;
    if (holds(text, "measuring machine certificate</title>") ||
        (holds(text, "<dcc:digitalCalibrationCertificate") &&
         holds(text, ">measuring_machine</dcc:content>")))
      return FileKind::kCertificate;
    if (holds(text, "<robot")) return FileKind::kMachine;
    return holds(text, "<svg") ? FileKind::kPicture : FileKind::kOther;
  }
  const FileKind yaml = kindOfYaml(text);
  if (yaml != FileKind::kOther) return yaml;
  const std::string header = text.substr(first, text.find('\n', first) - first);
  return holds(header, ",") || holds(header, ";") || holds(header, "\t") ? kindOfTable(header)
                                                                         : FileKind::kOther;
}

std::string nameOf(FileKind kind) {
  switch (kind) {
    case FileKind::kNothing:
      return "nothing";
    case FileKind::kStream:
      return "no regular file";
    case FileKind::kBag:
      return "a session's bag";
    case FileKind::kCalibration:
      return "a calibration";
    case FileKind::kPage:
      return "a report page";
    case FileKind::kCertificate:
      return "a certificate";
    case FileKind::kPicture:
      return "a picture (SVG)";
    case FileKind::kMachine:
      return "a machine (URDF)";
    case FileKind::kModel:
      return "a model";
    case FileKind::kArtifact:
      return "an artifact";
    case FileKind::kPlan:
      return "a measurement plan";
    case FileKind::kMoves:
      return "proposed moves";
    case FileKind::kKey:
      return "the key of a blind trial";
    case FileKind::kTruth:
      return "what a simulation hid";
    case FileKind::kTable:
      return "a table of measurements";
    case FileKind::kStates:
      return "a table of corrected states";
    case FileKind::kCurve:
      return "a convergence curve";
    case FileKind::kOther:
      break;
  }
  return "a file of another kind";
}

}  // namespace mm
