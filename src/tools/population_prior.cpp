#include "tools/population_prior.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/format.h"
#include "fleet/robust_numbers.h"
#include "model/model_spec.h"
#include "tools/one_line.h"

namespace mm {
namespace {

constexpr double kConflict = 1e-3;  // chance below which a machine is no sister

/// Sum of squares over rows that neither fit set aside.
double commonChi2(const CalibrationResult& of, const CalibrationResult& a, const CalibrationResult& b) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < of.residuals.size(); ++i)
    if (a.weight[i] > 0.0 && b.weight[i] > 0.0) sum += std::pow(of.residuals[i] / a.sigma[i], 2);
  return sum;
}

}  // namespace

PriorOfSisters::PriorOfSisters(const std::string& folder, const std::string& except) : folder_(folder) {
  if (!folder.empty()) all_ = populationPriors(folder, except);
}

std::vector<ParameterPrior> PriorOfSisters::forModel(const Session& session, const ModelSpec& spec) {
  std::vector<ParameterPrior> priors;
  if (!asked()) return priors;
  const Model model = modelFor(session, spec.effects);
  for (int i = 0; i < model.parameterCount(); ++i) {
    const Effect& effect = *model.effects()[static_cast<std::size_t>(model.effectOf(i))];
    const Parameter& p = model.parameter(i);
    for (const PopulationPrior& prior : all_)
      if (prior.name == p.name && prior.unit == p.unit &&
          sameEffect(parseEffectSpec(prior.effect, folder_), effect.spec(), model.domain()))
        used_.push_back({prior, {i, prior.mean / p.toUnit, prior.std / p.toUnit}});
  }
  if (used_.empty())
    throw InputError("--prior " + folder_ +
                     ": the sisters have no parameter of this model; calibrate them with the "
                     "same effects, or leave --prior out");
  for (const Used& u : used_) priors.push_back(u.si);
  return priors;
}

void PriorOfSisters::judge(const CalibrationResult& with, const CalibrationResult* without) {
  double ofPriors = 0.0;
  for (const Used& u : used_) ofPriors += std::pow((with.x[u.si.parameter] - u.si.mean) / u.si.std, 2);
  const double count = static_cast<double>(used_.size());
  double chi2 = ofPriors;
  if (without != nullptr)
    chi2 += std::max(0.0, commonChi2(with, with, *without) - commonChi2(*without, with, *without));
  chance_ = conflictOf(chi2, count);
  const CalibrationResult& data = without != nullptr ? *without : with;
  double least = 2.0;
  for (const Used& u : used_) {
    const int i = u.si.parameter;
    const bool held = data.identifiability.fixed[static_cast<std::size_t>(i)] != 0;
    if (held) continue;
    // with the prior in it, a value is at most as far from the mean as without
    const double std = without != nullptr ? std::hypot(data.std(i), u.si.std) : u.si.std;
    const double p = twoSidedT((data.x[i] - u.si.mean) / std, static_cast<double>(u.sisters.machines) - 1.0);
    if (p >= least) continue;
    least = p;
    const double toUnit = u.sisters.mean != 0.0 ? u.sisters.mean / u.si.mean : u.sisters.std / u.si.std;
    worst_ = u.sisters.name + " of " + u.sisters.effect +
             format(" is %.3g ± %.2g %s here, %.3g ± %.2g %s in %zu sisters", data.x[i] * toUnit,
                    data.std(i) * toUnit, u.sisters.unit.c_str(), u.sisters.mean, u.sisters.std,
                    u.sisters.unit.c_str(), u.sisters.machines);
  }
  chance_ = std::min(chance_, std::min(1.0, count * least));
  contradicted_ = chance_ < kConflict;
}

Recalibration PriorOfSisters::choose(Recalibration with, std::optional<Recalibration> without) {
  alone_ = without.has_value();
  judge(with.result, alone_ ? &without->result : nullptr);
  std::size_t fewest = used_.front().sisters.machines;
  for (const Used& u : used_) fewest = std::min(fewest, u.sisters.machines);
  if (contradicted_) {
    std::cerr
        << "mm: warning: "
        << oneLine(
               format("this machine is no sister of those in %s (chance %.2g): ", folder_.c_str(), chance_) +
               worst_ +
               (alone_ ? "; the prior is not used"
                       : "; the session alone determines nothing, so the values are the sisters' more than "
                         "its own: measure more"))
        << std::endl;
    if (alone_) return std::move(*without);
  } else {
    std::cerr
        << "mm: note: "
        << oneLine(format(
               "%zu parameters have a prior from at least %zu sister machines in %s; the session agrees "
               "with it (chance %.2g)",
               used_.size(), fewest, folder_.c_str(), chance_))
        << std::endl;
  }
  with.calibration.method += format(", prior of %zu machines", fewest);
  return with;
}

nlohmann::ordered_json PriorOfSisters::json() const {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Used& u : used_)
    list.push_back({{"parameter", u.sisters.name + " of " + u.sisters.effect},
                    {"mean", u.sisters.mean},
                    {"std", u.sisters.std},
                    {"unit", u.sisters.unit},
                    {"machines", u.sisters.machines}});
  return {{"folder", folder_},
          {"used", !(contradicted_ && alone_)},
          {"contradicted", contradicted_},
          {"chance", chance_},
          {"parameters", list}};
}

}  // namespace mm
