#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "interpreters/interpreter.h"
#include "interpreters/table_text.h"

namespace mm {

/// Lists of one axis of TwinCAT CNC and of the ISG kernel, compensation values and axis parameters: a key and
/// a value a line, remarks behind #.
class CompensationList {
 public:
  /// Adds a file. @throw InputError for a line without a value, and for a key kw.… that does not exist.
  void read(const std::filesystem::path& file);

  bool has(const std::string& key) const { return values_.count(key) > 0; }  ///< whether it is given
  bool hasAny(const std::string& start) const;                               ///< a key that begins so
  FilePlace place(const std::string& key) const;  ///< of a key; the file where it is not given
  /// Its number, or `missing`: the documented default of most is 0.
  double number(const std::string& key, double missing = 0.0) const;
  int integer(const std::string& key, int lower, int upper, int missing) const;  ///< the same, whole
  bool flag(const std::string& key, bool missing) const;                         ///< the same, 0 or 1

 private:
  struct Value {
    std::string text;
    FilePlace place;
  };
  std::filesystem::path file_;
  std::map<std::string, Value> values_;
};

/// Adds to a motor what one compensation of the slave axis says; SI.
class ListCompensation {
 public:
  virtual ~ListCompensation() = default;
  virtual double added(const CommandedState& command) const = 0;  ///< to the axis of the list
  virtual void addTo(JointPoints& points) const = 0;              ///< the points of its tables
};

/// What the list of axis `slave` compensates. @param axes logical number of an axis -> joint.
std::vector<std::unique_ptr<ListCompensation>> listCompensations(const CompensationList& list,
                                                                 const std::string& slave,
                                                                 const std::map<int, std::string>& axes);

}  // namespace mm
