#pragma once
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "session/input_faults.h"

namespace mm {

/// A line that a mapping lacks, with a value that it takes.
struct MappingLine {
  std::string key, value;  // "decimal", "axis", "columns" …
  std::string column;      // which, where the key is "columns"
};
/// "add to the mapping (--columns): key: value".
std::string addToMapping(const std::string& key, const std::string& value);

/// The faults of a file that is imported, and the lines of the mapping that would mend them.
class ImportFaults : public FaultList {
 public:
  /// Keeps a line, each once. @return addToMapping() of it, for the sentence of its fault.
  std::string ask(const std::string& key, const std::string& value);
  void askColumn(const std::string& column, const std::string& value);  ///< keeps what a column is
  const std::vector<MappingLine>& lines() const { return lines_; }      ///< in the order of the faults

 private:
  void keep(MappingLine line);
  std::vector<MappingLine> lines_;
  std::set<std::pair<std::string, std::string>> kept_;  // key and column
};

}  // namespace mm
