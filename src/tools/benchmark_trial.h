#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"
#include "machine/machine.h"

namespace mm {

/// One trial of the benchmark: a simulated session with effects hidden at random, and what the diagnosis said.
struct Trial {
  std::uint64_t seed = 0;
  std::vector<EffectSpec> hidden;          // as the catalogue of effects would call them
  std::vector<std::string> hiddenText;     // as the simulation calls them, with sizes
  std::vector<std::string> found;          // effects named, in order
  std::vector<std::string> byCorrelation;  // what ranking by correlation with the residual names, same number
  Verdict verdict = Verdict::kExplained;
  int right = 0;          // hidden effects that were named, or named as confusable with one that was
  int exact = 0;          // of these, named themselves
  int falseClaims = 0;    // named effects that are no hidden effect and not confusable with one
  int rightByCorrelation = 0;
  bool firstRight = false;
  double heldOutEnd = 0.0;  // held-out RMS with everything named in the model, over the noise
  double seconds = 0.0;
};

struct TrialOptions {
  std::string planYaml;       // text of the plan
  std::string planSource;     // its path
  int effects = 1;            // how many to hide
  double size = 1.0;          // RMS of what is left of each after refit, over the noise
  std::vector<std::string> only;  // types to draw from; empty: all kinds
};

/// Runs one trial. The size of each hidden effect is set by a noise-free simulation of it alone. Pairs that the data
/// cannot separate (projected correlation above 0.8) are drawn again.
Trial runTrial(const Machine& machine, const TrialOptions& options, std::uint64_t seed);

}  // namespace mm
