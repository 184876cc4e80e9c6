#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "base/error.h"

namespace mm {

/// Several faults of one input, so that they can be corrected at once. `what()` has them one after the other.
class InputFaults : public InputError {
 public:
  explicit InputFaults(std::vector<std::string> faults);
  const std::vector<std::string>& faults() const { return faults_; }  ///< one line each

 private:
  std::vector<std::string> faults_;
};

/// Collects the faults of one input, each once, up to a limit; the rest is counted.
class FaultList {
 public:
  static constexpr std::size_t kShown = 20;
  void add(const std::string& fault);                           ///< one line
  bool empty() const { return faults_.empty(); }                ///< no fault so far
  std::size_t count() const { return faults_.size() + more_; }  ///< with those not listed
  /// @throw InputFaults when there are any (a plain InputError when there is one).
  void throwIfAny() const;

 private:
  std::vector<std::string> faults_;
  std::size_t more_ = 0;
};

}  // namespace mm
