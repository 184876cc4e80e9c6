#include "session/trial_block.h"

#include <regex>

#include "base/format.h"

namespace mm {

std::string nameOf(const TrialBlock& b) {
  return "trial " + b.trial + format(" block %d of %d state %c", b.number, b.of, b.state) +
         (b.placement.empty() ? "" : ": " + b.placement);
}

std::optional<TrialBlock> trialBlock(const std::string& placement) {
  static const std::regex pattern(
      "(?:.*: )?trial ([0-9a-f]{8}) block ([0-9]{1,3}) of ([0-9]{1,3}) state ([AB])(?:: (.*))?");
  std::smatch part;
  if (!std::regex_match(placement, part, pattern)) return std::nullopt;
  return TrialBlock{part[1], std::stoi(part[2]), std::stoi(part[3]), part[4].str().front(), part[5]};
}

}  // namespace mm
