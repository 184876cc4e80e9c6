#include <algorithm>
#include <cmath>
#include <limits>

#include "base/dense.h"
#include "base/error.h"
#include "thermal/ridge.h"
#include "thermal/thermal_network.h"

namespace mm {
namespace {

constexpr int kGrowthSamples = 300;  // growth sees so many samples of a longer series, evenly chosen
constexpr double kGrowthRidge = 1e-4;
constexpr int kSamplesAnUnknown = 10;    // centres and widths are refined only with so many samples for each
constexpr double kClearlyBetter = 0.85;  // held-out error of several rules over that of one

/// Rules at the samples nearest to even steps along the first principal direction of the inputs.
DfnnRules spreadRules(const Eigen::MatrixXd& x, int count) {
  const Eigen::MatrixXd centred = x.rowwise() - x.colwise().mean();
  const SymmetricEigen solver(centred.transpose() * centred);
  const Eigen::VectorXd along = centred * solver.vectors.rightCols(1);
  constexpr double kNoSpan = 1e-9;  // K: of inputs that do not vary
  const double low = along.minCoeff(), span = std::max(along.maxCoeff() - low, kNoSpan);
  DfnnRules rules;
  for (int j = 0; j < count; ++j) {
    Eigen::Index nearest = 0;
    (along.array() - (low + span * (j + 0.5) / count)).abs().minCoeff(&nearest);
    rules.add(x.row(nearest), 2.0 * span / count);
  }
  return rules;
}

DfnnRules grown(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, const DfnnSettings& settings) {
  const std::vector<int> chosen = evenlyChosen(x.rows(), kGrowthSamples);
  return growRules(rowsOf(x, chosen), rowsOf(y, chosen), settings, kGrowthRidge);
}

/// The penalties that are tried.
struct Ridges {
  std::vector<double> common = {1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0};
  std::vector<double> departures = {1e-10, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1};
};

/// One way to place the rules: grown, or spread evenly along the main drift of the inputs, which is the
/// better start where a few rules share a long, smooth bend.
struct Placement {
  DfnnSettings growth;  // its largestRules is the number of rules where they are spread
  bool spread = false;

  DfnnRules rules(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y) const {
    DfnnRules rules = spread ? spreadRules(x, growth.largestRules) : grown(x, y, growth);
    rules.limitTo(x);
    return rules;
  }
};

/// A placement with its penalties and its held-out error.
struct Chosen {
  Placement placement;
  double ridge = 0.0, departureRidge = 0.0;
  double heldOut = std::numeric_limits<double>::infinity();
  bool refined = false;
};

/// The placements that are tried: the linear one first. Thresholds fall to their ends within the first half
/// of the samples: at the published pace a short series would be over before any error counts.
std::vector<Placement> placements(DfnnSettings base, int samples) {
  const double half = std::max(1.0, 0.5 * samples);
  base.distanceDecay =
      std::min(base.distanceDecay, std::pow(base.distanceMin / base.distanceMax, 1.0 / half));
  constexpr double kLeastError = 1e-6;  // of a standardised output: below it nothing is left to learn
  base.errorDecay =
      std::min(base.errorDecay, std::pow(std::max(base.errorMin, kLeastError) / base.errorMax, 1.0 / half));
  const int most = std::min(base.largestRules > 0 ? base.largestRules : 9, std::max(1, samples / 2));
  std::vector<Placement> result;
  const auto add = [&](int rules, double overlap, bool spread) {
    result.push_back({base, spread});
    result.back().growth.largestRules = rules;
    result.back().growth.overlap = overlap;
  };
  add(1, base.overlap, true);
  for (int rules : {2, 3, 4, 6})
    if (rules <= most) add(rules, base.overlap, true);
  for (int rules : {2, 3, 4, 6, 9})
    for (double factor : {1.0, 1.6})
      if (rules <= most) add(rules, factor * base.overlap, false);
  return result;
}

/// Sums of squares of the held-out errors for every pair of penalties. @param rulesOf(x, y) of the samples
/// that are not held out.
template <typename RulesOf>
Eigen::MatrixXd heldOutSquares(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y,
                               const std::vector<Fold>& folds, const Ridges& ridges, RulesOf rulesOf) {
  Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(static_cast<long>(ridges.common.size()),
                                                  static_cast<long>(ridges.departures.size()));
  for (const Fold& fold : folds) {
    const Eigen::MatrixXd trainX = rowsOf(x, fold.train), trainY = rowsOf(y, fold.train);
    const DfnnRules rules = rulesOf(trainX, trainY);
    const RidgeConsequents equations(RidgeConsequents::design(trainX, rules), trainY, x.cols());
    const Eigen::MatrixXd z = RidgeConsequents::design(rowsOf(x, fold.test), rules),
                          testY = rowsOf(y, fold.test);
    for (Eigen::Index b = 0; b < squares.cols(); ++b) {
      const std::vector<Eigen::MatrixXd> solutions =
          equations.solve(ridges.common, ridges.departures[static_cast<std::size_t>(b)]);
      for (std::size_t a = 0; a < solutions.size(); ++a)
        squares(static_cast<long>(a), b) += (z * solutions[a] - testY).squaredNorm();
    }
  }
  return squares;
}

/// See newDfnn().
class Dfnn : public ThermalNetwork {
 public:
  explicit Dfnn(const NetworkSettings& settings) : ThermalNetwork(settings) { settings.dfnn.validate(); }

  NetworkKind kind() const override { return NetworkKind::kDfnn; }
  int rules() const override { return rules_.count(); }
  void evaluate(const double* x, double* y) const override;

 protected:
  void learn() override;
  void store(NetworkNumbers& numbers) override;

 private:
  void standardise();
  Eigen::MatrixXd scaledInputs() const { return (x_.rowwise() - meanX_) * scaleX_.asDiagonal(); }
  Eigen::MatrixXd scaledOutputs() const { return (y_.rowwise() - meanY_) / scaleY_; }
  void choose();
  void solve();

  Eigen::RowVectorXd meanX_, scaleX_, meanY_;  // scaled x = (x - mean) * scale
  double scaleY_ = 1.0;                        // scaled y = (y - mean) / scale
  DfnnRules rules_;
  double ridge_ = 0.0, departureRidge_ = 0.0;  // relative; 0 in a published network
  double heldOut_ = 0.0;                       // unit of y; 0 in a published network
  RowMatrix common_;   // (inputs + 1) x outputs, scaled: the line; zero in a published network
  RowMatrix weights_;  // rules (inputs + 1) x outputs, scaled: the rules' consequents, or their departures
};

void Dfnn::standardise() {
  const Eigen::Index r = x_.cols();
  const double n = static_cast<double>(x_.rows());
  meanX_ = Eigen::RowVectorXd::Zero(r);
  scaleX_ = Eigen::RowVectorXd::Ones(r);
  meanY_ = Eigen::RowVectorXd::Zero(y_.cols());
  scaleY_ = 1.0;
  if (!settings_.dfnn.standardise) return;
  meanX_ = x_.colwise().mean();
  meanY_ = y_.colwise().mean();
  // Inputs that drift together then span about 8 units, as in the example to which the thresholds belong.
  const Eigen::RowVectorXd deviation = ((x_.rowwise() - meanX_).colwise().squaredNorm() / n).cwiseSqrt();
  for (Eigen::Index i = 0; i < r; ++i)
    scaleX_(i) = deviation(i) > 0.0 ? 2.3 / (deviation(i) * std::sqrt(static_cast<double>(r))) : 0.0;
  const double spread = (y_.rowwise() - meanY_).norm() / std::sqrt(static_cast<double>(y_.size()));
  if (spread > 0.0) scaleY_ = spread;
}

void Dfnn::learn() {
  if (settings_.dfnn.largestRules > samples())
    throw InputError("dfnn: " + std::to_string(settings_.dfnn.largestRules) + " rules for " +
                     std::to_string(samples()) + " samples; measure more or allow fewer rules");
  standardise();
  if (settings_.dfnn.published)
    rules_ = growRules(scaledInputs(), scaledOutputs(), settings_.dfnn, 0.0);
  else
    choose();
  solve();
}

void Dfnn::choose() {
  const Eigen::MatrixXd x = scaledInputs(), y = scaledOutputs();
  const std::vector<Fold> folds = blockedFolds(samples(), blocks());
  const double unit =
      scaleY_ / std::sqrt(static_cast<double>(y.size()));  // root of a sum of squares to an RMS
  const Ridges ridges;
  double linear = std::numeric_limits<double>::infinity(), several = linear;
  Chosen one, best;
  for (const Placement& placement : placements(settings_.dfnn, samples())) {
    Ridges tried = ridges;
    if (placement.growth.largestRules == 1) tried.departures.resize(1);  // nothing departs
    const auto rulesOf = [&](const auto& someX, const auto& someY) { return placement.rules(someX, someY); };
    Eigen::Index a = 0, b = 0;
    const double rms = unit * std::sqrt(heldOutSquares(x, y, folds, tried, rulesOf).minCoeff(&a, &b));
    const Chosen chosen{placement, ridges.common[static_cast<std::size_t>(a)],
                        ridges.departures[static_cast<std::size_t>(b)], rms};
    if (placement.growth.largestRules == 1) {
      linear = rms;
      one = chosen;
    } else if (rms < several) {
      several = rms;
      best = chosen;
    }
  }
  if (best.placement.growth.largestRules * (x.cols() + 1) * kSamplesAnUnknown <= samples() &&
      several < std::numeric_limits<double>::infinity()) {
    const auto rulesOf = [&](const auto& someX, const auto& someY) {
      return refineRules(someX, someY, best.placement.rules(someX, someY), best.ridge, best.departureRidge);
    };
    const Ridges chosen{{best.ridge}, {best.departureRidge}};
    const double refined = unit * std::sqrt(heldOutSquares(x, y, folds, chosen, rulesOf)(0, 0));
    if (refined < best.heldOut) {
      best.heldOut = refined;
      best.refined = true;
    }
  }
  const Chosen& chosen = best.heldOut < kClearlyBetter * linear ? best : one;
  ridge_ = chosen.ridge;
  departureRidge_ = chosen.departureRidge;
  heldOut_ = chosen.heldOut;
  rules_ = chosen.placement.rules(x, y);
  if (chosen.refined) rules_ = refineRules(x, y, rules_, ridge_, departureRidge_);
}

void Dfnn::solve() {
  const Eigen::MatrixXd x = scaledInputs(), y = scaledOutputs();
  const Eigen::Index r = x.cols();
  common_ = RowMatrix::Zero(r + 1, y.cols());
  weights_ = RowMatrix::Zero(rules_.count() * (r + 1), y.cols());
  if (settings_.dfnn.published) {
    weights_ = shortestLeastSquares(rules_.design(x), y);
    return;
  }
  const Eigen::MatrixXd all =
      RidgeConsequents(RidgeConsequents::design(x, rules_), y, r).solve(ridge_, departureRidge_);
  common_ = all.topRows(r + 1);
  if (rules_.count() > 1) weights_ = all.bottomRows(weights_.rows());
}

void Dfnn::evaluate(const double* x, double* y) const {
  double psi[kMostRules];
  const int r = inputs(), p = outputs(), rules = rules_.count();
  const bool limited = rules_.low.size() > 0;
  const auto scaled = [&](int i) { return (x[i] - meanX_(i)) * scaleX_(i); };
  const auto inside = [&](int i) {
    return limited ? std::min(std::max(scaled(i), rules_.low(i)), rules_.high(i)) : scaled(i);
  };
  const double sum = rules_.memberships(inside, psi);
  for (int o = 0; o < p; ++o) y[o] = meanY_(o);
  const auto add = [&](const double* w, double h) {
    for (int o = 0; o < p; ++o) y[o] += h * w[o];
  };
  for (int c = 0; c <= r; ++c) add(common_.data() + c * p, scaleY_ * (c == 0 ? 1.0 : scaled(c - 1)));
  for (int j = 0; j < rules; ++j)
    for (int c = 0; c <= r; ++c)
      add(weights_.data() + (j * (r + 1) + c) * p, scaleY_ * psi[j] / sum * (c == 0 ? 1.0 : inside(c - 1)));
}

void Dfnn::store(NetworkNumbers& numbers) {
  DfnnSettings& s = settings_.dfnn;
  numbers(s.published);
  numbers(s.standardise);
  for (double* value : {&s.distanceMax, &s.distanceMin, &s.distanceDecay, &s.errorMax, &s.errorMin,
                        &s.errorDecay, &s.firstWidth, &s.overlap, &s.widening, &s.pruning})
    numbers(*value);
  numbers(s.largestRules);
  for (double* value : {&scaleY_, &ridge_, &departureRidge_, &heldOut_}) numbers(*value);
  numbers(meanX_, 1, inputs());
  numbers(scaleX_, 1, inputs());
  numbers(meanY_, 1, outputs());
  numbers(rules_.centres, -1, inputs());
  numbers(rules_.widths, rules_.centres.rows(), 1);
  numbers(rules_.low, -1, s.published ? -1 : inputs());
  numbers(rules_.high, rules_.low.rows(), rules_.low.cols());
  numbers(common_, inputs() + 1, outputs());
  numbers(weights_, rules_.centres.rows() * (inputs() + 1), outputs());
  if (!numbers.reads()) return;
  s.validate();
  if (rules_.count() < 1 || rules_.count() > kMostRules)
    throw InputError("dfnn: the stored network has no valid rules");
}

}  // namespace

std::unique_ptr<ThermalNetwork> newDfnn(const NetworkSettings& settings) {
  return std::make_unique<Dfnn>(settings);
}

}  // namespace mm
