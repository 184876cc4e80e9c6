#include "estimation/network_samples.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/dense.h"
#include "base/error.h"
#include "base/grid_values.h"

namespace mm {
namespace {

constexpr std::size_t kMostSets = 300;
constexpr double kSensitive = 0.3;    // a row tells of the axis from this share of the largest sensitivity on
constexpr double kAtOnce = 0.25;      // of the usual pause between two sets: what is less is no pause
constexpr double kSeenByNone = 1e-9;  // of squares of gradients: an output that nothing tells of stays zero
constexpr double kNear = 0.75;        // share of an output from which on a reading counts as measured there

/// One scalar that tells of the axis: residual + gradient * error = 0.
struct Evidence {
  int observation = 0;
  double reading = 0.0, residual = 0.0, gradient = 0.0;
};

using Set = std::vector<Evidence>;

std::vector<Evidence> evidenceOf(const Linearisation& at, const Eigen::VectorXd& residuals,
                                 const Eigen::VectorXd& weight, int axis) {
  const Problem& problem = at.problem();
  const int slot = problem.model().machine().layout().axis(axis);
  const auto gradient = at.slotGradients().col(slot);
  double largest = 0.0;
  for (int i = 0; i < problem.rowCount(); ++i)
    if (weight[i] > 0.0) largest = std::max(largest, std::abs(gradient[i]));
  std::vector<Evidence> all;
  for (int i = 0; i < problem.rowCount() && largest > 0.0; ++i) {
    if (weight[i] <= 0.0 || std::abs(gradient[i]) < kSensitive * largest) continue;
    const int o = problem.rows()[i].observation;
    all.push_back({o, problem.session().observations[o].position[axis], residuals[i], gradient[i]});
  }
  return all;
}

/// Shares of the outputs at a reading: linear between two, all of the first or last beyond.
void sharesAt(const std::vector<double>& positions, double q, Eigen::VectorXd& shares) {
  shares.setZero(static_cast<Eigen::Index>(positions.size()));
  const auto [before, share] = placeAmong(positions, q);
  shares[static_cast<Eigen::Index>(before)] = 1.0 - share;
  if (share > 0.0) shares[static_cast<Eigen::Index>(before) + 1] = share;
}

/// Stretches of time in which every output was measured, each as often as the others: five runs at each
/// position before the next are one set, a run forwards and one backwards are two. What is left at the end is
/// in none.
std::vector<Set> setsOf(const std::vector<Evidence>& evidence, const std::vector<double>& positions) {
  std::vector<Set> sets;
  if (positions.size() == 1) {
    for (const Evidence& e : evidence) {
      if (sets.empty() || sets.back().front().observation != e.observation) sets.emplace_back();
      sets.back().push_back(e);
    }
    return sets;
  }
  Eigen::VectorXd shares;
  Set open;
  std::vector<int> measured(positions.size(), 0);
  for (const Evidence& e : evidence) {
    open.push_back(e);
    Eigen::Index at = 0;
    sharesAt(positions, e.reading, shares);
    if (shares.maxCoeff(&at) < kNear) continue;
    const int here = ++measured[static_cast<std::size_t>(at)];
    int least = std::numeric_limits<int>::max();
    for (std::size_t i = 0; i < measured.size(); ++i)
      if (static_cast<Eigen::Index>(i) != at) least = std::min(least, measured[i]);
    if (least == 0 || here < least) continue;
    sets.push_back(std::move(open));
    open.clear();
    std::fill(measured.begin(), measured.end(), 0);
  }
  return sets;
}

/// Neighbours together, so that there are at most kMostSets.
std::vector<Set> merged(std::vector<Set> sets) {
  const std::size_t each = (sets.size() + kMostSets - 1) / kMostSets;
  if (each <= 1) return sets;
  std::vector<Set> few((sets.size() + each - 1) / each);
  for (std::size_t i = 0; i < sets.size(); ++i)
    few[i / each].insert(few[i / each].end(), sets[i].begin(), sets[i].end());
  return few;
}

/// Sets that follow each other at once, as a run forwards and one backwards, are one state of the machine:
/// apart, each would give the other away when it is held out.
std::vector<Set> atOneTime(const std::vector<Set>& sets, const Problem& problem) {
  const auto time = [&](const Evidence& e) {
    return problem.session().observations[static_cast<std::size_t>(e.observation)].time;
  };
  std::vector<double> pauses;
  for (std::size_t i = 1; i < sets.size(); ++i)
    pauses.push_back(time(sets[i].front()) - time(sets[i - 1].back()));
  if (pauses.empty()) return sets;
  std::vector<double> ordered = pauses;
  std::sort(ordered.begin(), ordered.end());
  const double usual = ordered[3 * ordered.size() / 4];
  std::vector<Set> together = {sets.front()};
  for (std::size_t i = 1; i < sets.size(); ++i) {
    if (pauses[i - 1] < kAtOnce * usual)
      together.back().insert(together.back().end(), sets[i].begin(), sets[i].end());
    else
      together.push_back(sets[i]);
  }
  return static_cast<int>(together.size()) >= kFewestSets ? together : sets;
}

/// Positions that are measured again and again, then the ends of the range, then one for all.
std::vector<std::vector<double>> choicesOf(const Domain& domain, int axis) {
  std::vector<std::vector<double>> choices;
  if (!domain.positions[axis].empty()) choices.push_back(domain.positions[axis]);
  if (domain.upper[axis] > domain.lower[axis]) choices.push_back({domain.lower[axis], domain.upper[axis]});
  choices.push_back({0.5 * (domain.lower[axis] + domain.upper[axis])});
  return choices;
}

}  // namespace

double NetworkSamples::at(double q, const Eigen::RowVectorXd& outputs) const {
  Eigen::VectorXd shares;
  sharesAt(positions, q, shares);
  return outputs.dot(shares);
}

Eigen::VectorXd NetworkSamples::mainError() const {
  const Eigen::MatrixXd centred = error.rowwise() - error.colwise().mean();
  const SymmetricEigen solver(centred.transpose() * centred);
  const Eigen::VectorXd direction = solver.vectors.rightCols(1);
  Eigen::Index largest = 0;
  direction.cwiseAbs().maxCoeff(&largest);
  return centred * direction * direction[largest];
}

NetworkSamples gatherNetworkSamples(const Linearisation& at, const Eigen::VectorXd& residuals,
                                    const Eigen::VectorXd& weight, int axis,
                                    const std::vector<double>& wanted) {
  const Problem& problem = at.problem();
  const Domain& domain = problem.model().domain();
  const std::string name = domain.joints[static_cast<std::size_t>(axis)].name;
  const std::vector<Evidence> evidence = evidenceOf(at, residuals, weight, axis);
  if (evidence.empty())
    throw InputError(problem.session().source + ": thermal_network: the session has no measurement of axis " +
                     name + "; measure it, or omit the effect");
  NetworkSamples samples;
  std::vector<Set> sets;
  const int fewest = wanted.empty() ? kFewestSets : 1;
  const std::vector<std::vector<double>> choices =
      wanted.empty() ? choicesOf(domain, axis) : std::vector<std::vector<double>>{wanted};
  for (const std::vector<double>& positions : choices) {
    samples.positions = positions;
    sets = merged(atOneTime(setsOf(evidence, positions), problem));
    if (static_cast<int>(sets.size()) >= fewest) break;
  }
  const auto count = static_cast<Eigen::Index>(sets.size());
  if (count < fewest && !wanted.empty())
    throw InputError(problem.session().source + ": thermal_network: no set of measurements of axis " + name +
                     " holds all " + std::to_string(wanted.size()) +
                     " positions at which the network was trained; measure them again");
  if (count < fewest)
    throw InputError(problem.session().source + ": thermal_network: " + std::to_string(count) +
                     (count == 1 ? " set" : " sets") + " of measurements of axis " + name + "; at least " +
                     std::to_string(kFewestSets) + " at different temperatures are needed for training");
  const auto outputs = static_cast<Eigen::Index>(samples.positions.size());
  const auto sensors = static_cast<Eigen::Index>(domain.sensors.size());
  samples.temperatures.setZero(count, sensors);
  samples.error.resize(count, outputs);
  samples.setOf.assign(problem.session().observations.size(), -1);
  Eigen::VectorXd shares;
  for (Eigen::Index k = 0; k < count; ++k) {
    const Set& set = sets[static_cast<std::size_t>(k)];
    Eigen::MatrixXd normal = Eigen::MatrixXd::Identity(outputs, outputs) * kSeenByNone;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(outputs);
    for (const Evidence& e : set) {
      sharesAt(samples.positions, e.reading, shares);
      normal += e.gradient * e.gradient * shares * shares.transpose();
      right -= e.gradient * e.residual * shares;
      const State& state = problem.state(e.observation);
      for (Eigen::Index s = 0; s < sensors; ++s)
        samples.temperatures(k, s) += state.temperature[static_cast<std::size_t>(s)];
      samples.setOf[static_cast<std::size_t>(e.observation)] = static_cast<int>(k);
    }
    samples.temperatures.row(k) /= static_cast<double>(set.size());
    samples.error.row(k) = solveSymmetric(normal, right).transpose();
  }
  return samples;
}

}  // namespace mm
