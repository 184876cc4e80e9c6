#include "session/input_faults.h"

#include <algorithm>

#include "base/text.h"

namespace mm {
InputFaults::InputFaults(std::vector<std::string> faults)
    : InputError(joined(faults, "\n")), faults_(std::move(faults)) {}

void FaultList::add(const std::string& fault) {
  if (std::find(faults_.begin(), faults_.end(), fault) != faults_.end()) return;
  if (faults_.size() < kShown)
    faults_.push_back(fault);
  else
    ++more_;
}

void FaultList::throwIfAny() const {
  if (faults_.empty()) return;
  if (faults_.size() == 1) throw InputError(faults_.front());
  std::vector<std::string> all = faults_;
  if (more_ > 0)
    all.push_back("and " + std::to_string(more_) + " more faults in that file; correct these first");
  throw InputFaults(std::move(all));
}

}  // namespace mm
