#include "session/trial_block.h"

#include "base/format.h"
#include "base/pattern.h"

namespace mm {

std::string nameOf(const TrialBlock& b) {
  return "trial " + b.trial + format(" block %d of %d state %c", b.number, b.of, b.state) +
         (b.placement.empty() ? "" : ": " + b.placement);
}

std::optional<TrialBlock> trialBlock(const std::string& placement) {
  static const Pattern pattern(
      "(?:.*: )?trial ([0-9a-f]{8}) block ([0-9]{1,3}) of ([0-9]{1,3}) state ([AB])(?:: (.*))?");
  const std::vector<std::string> part = pattern.parts(placement);
  if (part.empty()) return std::nullopt;
  return TrialBlock{part[1], std::stoi(part[2]), std::stoi(part[3]), part[4].front(), part[5]};
}

}  // namespace mm
