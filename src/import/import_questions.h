#pragma once
#include <string>
#include <vector>

#include "import/import_faults.h"
#include "machine/machine.h"

namespace mm {

/// What a file does not say and the mapping must.
struct ImportQuestion {
  std::string key;                   // of the mapping: "decimal", "axis", "columns" …
  std::string column;                // which, where the key is "columns"
  std::string suggested;             // a value that the mapping takes
  std::vector<std::string> choices;  // likely ones, the suggested first; empty: a number or a list
};

/// The lines that a mapping lacks, with likely answers.
std::vector<ImportQuestion> questionsOf(const std::vector<MappingLine>& lines, const Machine& machine);

/// What a column of a table may be: as the mapping writes it, in words, and under which heading.
struct ColumnChoice {
  std::string value, words, group;
};
std::vector<ColumnChoice> columnChoices(const Machine& machine);  ///< in the order of the joints

}  // namespace mm
