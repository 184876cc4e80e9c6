#include "tools/file_kind.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <sstream>

#include "base/read_file.h"
#include "base/text.h"
#include "design/moves.h"

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
  if (has("moves") && startsWith(text, kMovesBegin)) return FileKind::kMoves;
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
  static const std::map<FileKind, const char*> kNames = {{FileKind::kNothing, "nothing"},
                                                         {FileKind::kStream, "no regular file"},
                                                         {FileKind::kBag, "a session's bag"},
                                                         {FileKind::kCalibration, "a calibration"},
                                                         {FileKind::kPage, "a report page"},
                                                         {FileKind::kCertificate, "a certificate"},
                                                         {FileKind::kPicture, "a picture (SVG)"},
                                                         {FileKind::kMachine, "a machine (URDF)"},
                                                         {FileKind::kModel, "a model"},
                                                         {FileKind::kArtifact, "an artifact"},
                                                         {FileKind::kPlan, "a measurement plan"},
                                                         {FileKind::kMoves, "proposed moves"},
                                                         {FileKind::kKey, "the key of a blind trial"},
                                                         {FileKind::kTruth, "what a simulation hid"},
                                                         {FileKind::kTable, "a table of measurements"},
                                                         {FileKind::kStates, "a table of corrected states"},
                                                         {FileKind::kCurve, "a convergence curve"},
                                                         {FileKind::kOther, "a file of another kind"}};
  return kNames.at(kind);
}

}  // namespace mm
