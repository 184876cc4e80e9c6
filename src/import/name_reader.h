#pragma once
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "import/column_words.h"
#include "import/meaning.h"
#include "import/table_layout.h"

namespace mm {

/// What the words of a file say together: by it `measured` and `date` are understood.
struct NameContext {
  int axis = -1;           // joint of columns that do not say theirs; -1: it is not known
  bool hasTarget = false;  // one of the columns is a target
  int timeColumns = 0;     // of clocks or numbers
};

/// Understands the name of a column by its words, in any order.
class NameReader {
 public:
  explicit NameReader(const Machine& machine) : machine_(machine) {}  ///< its joints are the names

  /// The classes of a name's words and its joint (-1: none). @param rest gets the words that say nothing.
  std::pair<std::set<WordClass>, int> classesOf(const std::vector<std::string>& words,
                                                std::vector<std::string>* rest = nullptr) const;
  /// The columns of the package's own format are understood as they always were.
  std::optional<Meaning> ownFormat(const std::string& name) const;
  /// By its words. @param said in the mapping, where words count as they stand.
  std::optional<Meaning> byWords(const std::string& stem, const std::optional<Unit>& unit,
                                 const ColumnSample& sample, bool said, const NameContext& context) const;
  /// Anything else that was logged, where its name has a unit that no reading of this machine has.
  /// @param split gets the unit that was seen in the name.
  std::optional<Meaning> covariate(const std::string& name, NameAndUnit& split,
                                   const std::optional<Unit>& unit, const ColumnSample& sample) const;

 private:
  bool splitWord(const std::string& word, std::set<WordClass>& classes, int& joint) const;
  Meaning ofJoint(CsvRole role, int joint, const NameContext& context) const;
  Meaning temperature(const std::vector<std::string>& words) const;
  const Machine& machine_;
};

}  // namespace mm
