#include <algorithm>

#include "posterior/sample.h"

namespace mm {
namespace {

constexpr double kSmall = 0.4, kLarge = 2.0;  // ratios of a plain state
constexpr double kTermNats = 1.0;             // that a further term must bring to a fit

}  // namespace

std::vector<NoiseState> plainStates(const PosteriorProblem& problem, const Eigen::VectorXd& variance) {
  NoiseState none;
  none.variance = variance;
  for (const RandomBlock& b : problem.scatter) none.scatter.push_back(b.fixed ? b.ratio : 0.0);
  std::vector<NoiseState> states = {none};
  const int directions = static_cast<int>(problem.rows.factors.cols());
  const NoiseFit taus(problem.rows, {});
  for (const double tau : taus.timeConstants())
    for (const double ratio : {kSmall, kLarge}) {
      NoiseState s = none;
      for (int d = 0; d < directions; ++d) s.drift.push_back({d, ratio, tau, false});
      states.push_back(std::move(s));
    }
  NoiseState all = none;
  for (std::size_t b = 0; b < problem.scatter.size(); ++b) {
    if (problem.scatter[b].fixed) continue;
    for (const double ratio : {kSmall, kLarge}) {
      states.push_back(none);
      states.back().scatter[b] = ratio;
    }
    all.scatter[b] = 1.0;
  }
  if (!problem.scatter.empty() && !all.resembles(none)) states.push_back(std::move(all));
  return states;
}

NoiseState fittedBeside(const PosteriorProblem& problem, const ActingSet& set, const NoiseState& start,
                        NoiseTerms terms) {
  std::vector<RandomBlock> blocks = problem.scatter;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    blocks[b].ratio = start.scatter[b];
    if (!blocks[b].fixed) blocks[b].price = kTermNats;
  }
  for (const Acting& a : set) {
    const CauseShape& s = problem.shapes[static_cast<std::size_t>(a.shape)];
    blocks.push_back({problem.columns.middleCols(s.first, s.count), sizeGrid()[a.size], 0.0, true});
  }
  NoiseFitOptions options;
  options.driftPrice = kTermNats;
  options.smoothPrice = 2.0 * kTermNats;
  NoiseModel from;
  from.drift = start.drift;
  from.variance = start.variance;
  const NoiseFit of(problem.rows, std::move(blocks));
  const NoiseFitResult fit = terms == NoiseTerms::kFitted ? of.run(from, options) : of.at(from, options);
  NoiseState out = start;
  out.drift.clear();
  for (const DriftTerm& t : fit.noise.drift)
    if (t.ratio > 0.0) out.drift.push_back(t);
  for (std::size_t b = 0; b < problem.scatter.size(); ++b) out.scatter[b] = fit.ratios[b];
  return out;
}

NoiseState ofOtherKernel(NoiseState state) {
  for (DriftTerm& t : state.drift) {
    t.smooth = !t.smooth;
    t.tau *= t.smooth ? kSmoothTime : 1.0 / kSmoothTime;
  }
  return state;
}

}  // namespace mm
