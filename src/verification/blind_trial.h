#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "session/plan.h"
#include "session/session.h"

namespace mm {

/// What is kept from who measures and from who judges, until the figures are there.
struct TrialKey {
  std::string trial;       // as TrialBlock::trial: a checksum of the plan with its order
  std::string order;       // "ABBA…": the state of each block
  char on = 'A';           // the state in which the controller corrects
  std::uint64_t seed = 0;  // of both draws
};

/// How large a trial is, and the seed of its draws.
struct TrialSettings {
  int blocks = 10;
  std::uint64_t seed = 1;
};
// An even number of blocks: below six a trial can show nothing; above, the randomisation test would take
// minutes. Ten are the fewest whose smallest p is below 1 %.
inline constexpr int kFewestBlocks = 6, kMostBlocks = 24;

/// A plan in blocks, and its key.
struct BlindTrial {
  std::string plan;  // YAML
  TrialKey key;
};

/// The moves of a plan in blocks, half of them in each of two states A and B of the controller, in an order
/// that is drawn; and drawn, too, in which of them the correction acts. Each block is a placement whose name
/// tells it (session/trial_block.h); the artifact stays where it is.
/// @param moves indices of plan.moves that measure, ascending. @param name of the new plan. @throw
/// InputError: an odd number of blocks, or out of range.
BlindTrial blindTrial(const Plan& plan, const Machine& machine, const std::vector<std::size_t>& moves,
                      const std::string& name, const TrialSettings& settings);

/// A key as a file. @throw InputError naming file, line and key.
std::string keyYaml(const TrialKey& key);
TrialKey parseKey(const std::string& yaml, const std::string& source);
TrialKey loadKey(const std::filesystem::path& file);

/// @param placements of a session or a plan. @param source whose they are, and of the key. @throw InputError:
/// they belong to no trial or to that of another key, or a block is in another state than the key says.
void checkKey(const TrialKey& key, const std::vector<std::string>& placements, const std::string& source,
              const std::string& keySource);

}  // namespace mm
