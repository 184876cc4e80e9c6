#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"
#include "machine/machine.h"
#include "simulation/uncatalogued.h"

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
  int right = 0;        // hidden effects that were named, or named as confusable with one that was
  int exact = 0;        // of these, named themselves
  int falseClaims = 0;  // named effects that are no hidden effect and not confusable with one
  int rightByCorrelation = 0;
  bool firstRight = false;
  double heldOutEnd = 0.0;  // held-out RMS with everything named in the model, over the noise
  double seconds = 0.0;     // of the diagnosis
  bool notShown = false;    // nothing was tried: no draw was of effects that such a session shows

  /// What was said of an effect outside the catalogue.
  struct Unknown {
    UncataloguedTruth truth;
    std::string formula, direction;  // the first; empty: none
    bool justTheVariables = false;   // it is made of those on which the effect depends, and no others
    bool rightDirection = false;
    double heldOut = 0.0;    // held-out RMS with it, over the noise
    bool explained = false;  // the noise is reached within 20 %
    /// No unknown effect is claimed, and what was named of the catalogue reaches the noise within 5 %: this
    /// session cannot tell the hidden effect from those.
    bool byCatalogue = false;
  } unknown;
};

struct TrialOptions {
  std::string planYaml;           // text of the plan
  std::string planSource;         // its path
  int effects = 1;                // how many to hide
  double size = 1.0;              // RMS of what is left of each after refit, over the noise
  std::vector<std::string> only;  // types to draw from; empty: all kinds
  bool uncatalogued = false;      // hide effects outside the catalogue
  std::vector<EffectSpec> base;   // the model that knows nothing of what is hidden
};

/// Runs one trial. The size of each hidden effect is set by a noise-free simulation of it alone. Pairs that
/// the data cannot separate (projected correlation above 0.8) are drawn again, and so is an effect that the
/// session hardly shows: that would have to be thirty times as large as the simulation draws it. The noise is
/// that of the simulated contacts, whatever the artifact states.
Trial runTrial(const Machine& machine, const TrialOptions& options, std::uint64_t seed);

}  // namespace mm
