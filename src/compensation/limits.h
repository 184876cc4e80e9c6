#pragma once
#include <string>
#include <vector>

#include "model/model.h"

namespace mm {

/// Where a calibration holds: the readings, temperatures and covariates that its session observed, and the
/// inputs without which its model has no answer.
class CalibratedLimits {
 public:
  /// @param margin how far beyond the observed range is still accepted on each side, as a fraction of the
  /// range.
  CalibratedLimits(const Model& model, double margin);

  /// A joint's reading that is outside: which, its value and the bound; empty when all are inside.
  std::string jointOutside(const State& state) const;
  /// A temperature or covariate that the model uses and that is outside.
  std::string inputOutside(const State& state) const;
  /// A temperature that the model does not use, but at which it was never seen.
  std::string unusual(const State& state) const;
  /// An input that the model needs and that is not known.
  std::string missing(const State& state) const;
  /// True when the correction depends on the direction in which that joint travels.
  bool usesTravel(std::size_t joint) const { return usesTravel_[joint]; }
  /// True when that input is a temperature or a covariate.
  bool lost(const State& state) const;

 private:
  struct Input {
    std::string name;                 // for people: "temperature bed"
    double lower = 0.0, upper = 0.0;  // margin included
    double toUnit = 1.0;              // of people
    const char* unit = "";            // with a blank before it
    bool used = false;
    bool has(double value) const { return !(value < lower || value > upper); }  ///< an unknown one, too
    std::string outside(double value, const char* remark = "") const;           ///< in words
  };
  /// Asks each temperature and covariate, with its value in that state, until one answers.
  template <typename Answer>
  Answer firstOf(const State& state, Answer (*ask)(const Input& input, double value)) const;
  std::string withoutTravel(const State& state) const;
  void findUsed(const Model& model);

  std::vector<Input> readings_, sensors_, covariates_;
  std::vector<bool> usesTravel_, usesVelocity_;  // a joint
  bool usesHistory_ = false, usesApproach_ = false, usesTime_ = false;
};

}  // namespace mm
