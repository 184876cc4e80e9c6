#pragma once
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "session/contacts_csv.h"

namespace mm {

/// What was written in one row, beside the observation itself.
struct RowKinds {
  bool feature = false, reference = false, deviation = false, length = false, logged = false, setup = false;
  bool contact() const { return feature && !length; }                          ///< the feature was touched
  int measured() const { return contact() + length + reference + deviation; }  ///< how many kinds
  bool logsOnly() const { return measured() == 0 && logged; }                  ///< only temperatures
};

/// Why a row holds no observation; empty: it does.
std::string rowFault(const Observation& o, const RowKinds& kinds, const Machine& machine);

/// Sets the kind of an observation, and takes from it what belongs to deviations only.
void setKind(Observation& o, const RowKinds& kinds);

/// Finds the features of an artifact by the names that a file gives them.
class FeatureNames {
 public:
  /// In somebody else's file in any case, and perhaps under other names. @param artifact, form outlive it.
  FeatureNames(const Artifact& artifact, const TableForm& form);
  int find(std::string_view name) const;  ///< index in the artifact, or -1
  std::string fault(
      std::string_view name) const;  ///< why a name that is not found is refused, with the remedy

 private:
  std::string renamed(std::string_view name) const;

  const TableForm& form_;
  const Artifact& artifact_;
  std::unordered_map<std::string, int> index_;
};

/// What was logged beside the rows, until the earliest time of the file is known.
class LoggedSeries {
 public:
  void add(std::size_t series, std::int64_t stamp, double value);  ///< stamp: ns, the file's own clock
  /// Puts the values into their series in the order of their times, s after `zero` (ns).
  void fill(std::vector<Series>& series, std::int64_t zero);

 private:
  struct Logged {
    std::int64_t stamp;  // ns, the file's own clock
    double value;
  };
  std::vector<std::vector<Logged>> logged_;
};

}  // namespace mm
