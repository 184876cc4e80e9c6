#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "benchmark_oracle.h"
#include "benchmark_score.h"
#include "diagnosis/diagnose.h"
#include "formula_judge.h"
#include "machine/machine.h"
#include "session/progress.h"

namespace mm {

/// One trial of the benchmark: a simulated session with effects hidden at random, and what the diagnosis
/// said.
struct Trial {
  std::uint64_t seed = 0;
  std::vector<EffectSpec> hidden;          // as the catalogue of effects would call them
  std::vector<std::string> hiddenText;     // as the simulation calls them, with sizes
  std::vector<std::string> found;          // effects named, in order
  std::vector<std::string> byCorrelation;  // what ranking by correlation with the residual names, same number
  Verdict verdict = Verdict::kExplained;
  Score score;
  int rightByCorrelation = 0;
  /// Causes of the catalogue that were said to be likely: their probability, and whether they were hidden.
  std::vector<std::pair<double, bool>> said;
  double heldOutEnd = 0.0;   // held-out RMS with everything named in the model, over the noise
  double seconds = 0.0;      // of the diagnosis
  bool notShown = false;     // nothing was tried: no draw was of effects that such a session shows
  UnknownJudgement unknown;  // of an effect outside the catalogue
  /// No unknown effect is claimed, and what was named of the catalogue reaches the noise within 5 %: this
  /// session cannot tell the hidden effect from those.
  bool byCatalogue = false;
  std::optional<double> oracleGain;  // nats, of the one hidden cause
};

struct TrialOptions {
  std::string planYaml;           // text of the plan
  std::string planSource;         // its path
  int effects = 1;                // how many to hide
  double size = 1.0;              // RMS of what is left of each after refit, over the noise
  std::vector<std::string> only;  // types to draw from; empty: all kinds
  bool uncatalogued = false;      // what is hidden, those of `only`, is outside the catalogue
  std::vector<EffectSpec> base;   // the model that knows nothing of what is hidden
  std::string rough;              // how the sessions are rougher than the plan says: as for mm simulate
};

/// Runs one trial. The size of each hidden effect is set by a noise-free simulation of it alone. Only the
/// very same cause twice is drawn again, and an effect that the session hardly shows: that would have to be
/// thirty times as large as the simulation draws it. The noise is that of the simulated contacts, whatever
/// the artifact states and however rough they are.
/// @param oracle of such sessions, or none.
Trial runTrial(const Machine& machine, const TrialOptions& options, std::uint64_t seed,
               const Oracle* oracle = nullptr);

/// Learns noise and roughness from sessions in which nothing is hidden. @param seed first of the trials'.
/// @throw InputError where the plan's moves do not all measure.
Oracle oracleOf(const Machine& machine, const TrialOptions& options, int sessions, std::uint64_t seed,
                const ProgressCallback& progress = {});

}  // namespace mm
