#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "benchmark_trial.h"

namespace mm {

/// Wilson's 95 % interval of a share, in percent: `96.0 % (86.5-98.9 %) 48/50`.
std::string wilson(int right, int count);

/// What a benchmark counts, over all its sessions.
class BenchmarkCounts {
 public:
  /// @param effects hidden in each session. @param uncatalogued they are outside the catalogue.
  BenchmarkCounts(int effects, bool uncatalogued) : effects_(effects), uncatalogued_(uncatalogued) {}

  void add(const Trial& trial);  ///< one session more
  /// Whether a session went as it should: worth no line.
  bool good(const Trial& trial) const;
  std::string text() const;
  /// Figures by their name, RMS over the noise; the sessions one by one.
  nlohmann::ordered_json json() const;

 private:
  struct Hits {
    int all = 0, named = 0, confusable = 0, besideDrift = 0;
  };
  struct Unknown {
    int all = 0, verdict = 0, variables = 0, direction = 0, heldOut = 0, everything = 0, byCatalogue = 0,
        formula = 0, formulaRight = 0;
  };
  std::string unknownText() const;

  int effects_;
  bool uncatalogued_;
  int sessions_ = 0, notShown_ = 0;
  int first_ = 0, firstBesideDrift_ = 0, exact_ = 0, byHand_ = 0, atNoise_ = 0;
  int claimed_ = 0, withWrong_ = 0, wrong_ = 0, profiles_ = 0, formulas_ = 0;
  int perhaps_ = 0, oracleSure_ = 0, oracleOnly_ = 0;
  bool oracle_ = false;
  double seconds_ = 0.0;
  Hits hits_;
  std::map<std::string, Hits> byType_;
  std::map<std::string, int> verdicts_;
  Unknown unknown_;
  std::map<std::string, Unknown> unknownByType_;
  nlohmann::ordered_json trials_ = nlohmann::ordered_json::array();
};

}  // namespace mm
