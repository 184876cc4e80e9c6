#include "verification/blind_trial.h"

#include <algorithm>
#include <map>

#include "base/checksum.h"
#include "base/error.h"
#include "base/format.h"
#include "base/random.h"
#include "base/read_file.h"
#include "base/yaml_mapping.h"
#include "session/plan_selection.h"
#include "session/trial_block.h"
#include "verification/trial_orders.h"

namespace mm {
namespace {

std::string drawnOrder(int blocks, std::uint64_t seed) {
  Random random(seed, "order of a blind trial");
  for (;;) {
    std::string order(blocks, 'A');
    std::fill(order.begin() + blocks / 2, order.end(), 'B');
    for (int i = blocks - 1; i > 0; --i)  // Fisher and Yates
      std::swap(order[i], order[random.below(i + 1)]);
    if (std::abs(correlationWithTime(order)) <= kMostWithTime) return order;
  }
}

/// The moves once a block, each in the placement of its block.
Plan inBlocks(const Plan& plan, const std::vector<std::size_t>& moves, const TrialKey& key,
              std::vector<std::size_t>& measured) {
  Plan trial = plan;
  trial.placements.clear();
  trial.moves.clear();
  const int blocks = key.order.size();
  for (int b = 0; b < blocks; ++b) {
    std::map<int, int> placements;  // of the plan: of this block
    const auto add = [&](PlanMove move) {
      const auto [at, fresh] = placements.try_emplace(move.placement, trial.placements.size());
      if (fresh) {
        PlanPlacement own;
        if (!plan.placements.empty()) own = plan.placements[move.placement];
        own.name = nameOf({key.trial, b + 1, blocks, key.order[b], own.name});
        trial.placements.push_back(std::move(own));
      }
      move.placement = at->second;
      trial.moves.push_back(std::move(move));
    };
    for (const std::size_t i : moves) {
      if (i > 0 && plan.moves[i - 1].kind == MoveKind::kGo) add(plan.moves[i - 1]);
      measured.push_back(trial.moves.size());
      add(plan.moves[i]);
    }
  }
  return trial;
}

}  // namespace

double correlationWithTime(const std::string& order) {
  const double n = order.size(), middle = 0.5 * (n - 1.0);
  double ofA = 0.0, together = 0.0;
  for (std::size_t i = 0; i < order.size(); ++i)
    if (order[i] == 'A') ofA += 1.0, together += i - middle;
  const double square = ofA * (n - ofA) / n * n * (n * n - 1.0) / 12.0;
  return square > 0.0 ? together / std::sqrt(square) : 0.0;
}

double smallestP(const std::string& order) {
  double count = 0.0;
  forEachOrder(order, [&](const std::string&) { ++count; });
  const bool balanced = 2 * std::count(order.begin(), order.end(), 'A') == static_cast<int>(order.size());
  return std::min(1.0, (balanced ? 2.0 : 1.0) / count);
}

BlindTrial blindTrial(const Plan& plan, const Machine& machine, const std::vector<std::size_t>& moves,
                      const std::string& name, const TrialSettings& settings) {
  if (settings.blocks % 2 != 0 || settings.blocks < kFewestBlocks || settings.blocks > kMostBlocks)
    throw InputError(format("a blind trial has an even number of blocks from %d to %d, not %d", kFewestBlocks,
                            kMostBlocks, settings.blocks));
  BlindTrial trial;
  trial.key.order = drawnOrder(settings.blocks, settings.seed);
  trial.key.on = Random(settings.seed, "state of a blind trial").uniform() < 0.5 ? 'A' : 'B';
  trial.key.seed = settings.seed;
  constexpr std::size_t kDigits = 8;
  trial.key.trial =
      checksumOf(planSelection(plan, machine, moves, name) + trial.key.order + std::to_string(settings.seed))
          .substr(0, kDigits);
  std::vector<std::size_t> measured;
  const Plan blocks = inBlocks(plan, moves, trial.key, measured);
  trial.plan = planSelection(blocks, machine, measured, name);
  return trial;
}

std::string keyYaml(const TrialKey& key) {
  return "# Key of a blind trial. Keep it closed until mm verify --blind has judged.\ntrial: \"" + key.trial +
         "\"\norder: " + key.order + "\ncorrection_on: " + std::string(1, key.on) +
         "\nseed: " + std::to_string(key.seed) + "\n";
}

TrialKey parseKey(const std::string& yaml, const std::string& source) {
  const YamlMapping root(YamlMapping::load(yaml, source), source, "the key of a blind trial",
                         {"trial", "order", "correction_on", "seed"});
  TrialKey key;
  key.trial = root.text("trial");
  key.order = root.text("order");
  const std::string on = root.text("correction_on");
  if (on != "A" && on != "B") root.fail("correction_on", "is '" + on + "', but must be A or B");
  if (key.order.find_first_not_of("AB") != std::string::npos)
    root.fail("order", "is '" + key.order + "', but must be of the letters A and B");
  key.on = on.front();
  try {
    key.seed = std::stoull(root.text("seed"));
  } catch (const std::exception&) {
    root.fail("seed", "must be a whole number");
  }
  return key;
}

TrialKey loadKey(const std::filesystem::path& file) {
  return parseKey(readWholeFile(file, "name the key that mm plan verify --blind wrote"), file.string());
}

void checkKey(const TrialKey& key, const std::vector<std::string>& placements, const std::string& source,
              const std::string& keySource) {
  bool any = false;
  for (const std::string& name : placements) {
    const std::optional<TrialBlock> block = trialBlock(name);
    if (!block) continue;
    any = true;
    if (block->trial != key.trial)
      throw InputError(keySource + ": is the key of trial " + key.trial + ", but " + source +
                       " is of trial " + block->trial + "; name the key that was written with its plan");
    const std::size_t at = block->number - 1;
    if (block->of != static_cast<int>(key.order.size()) || at >= key.order.size() ||
        key.order[at] != block->state)
      throw InputError(source + ": '" + name + "' is in another state than " + keySource +
                       " says; one of both was changed: name the key that was written with the plan");
  }
  if (!any)
    throw InputError(source +
                     ": has no block of a blind trial; measure a plan that mm plan verify --blind "
                     "wrote");
}

}  // namespace mm
