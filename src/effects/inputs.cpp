#include "effects/inputs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "base/unit_random.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr int kStates =
    64;  // a step in an input that moves one state in ten is met but for one in a thousand
constexpr double kChanged = 1e-9;  // of a contribution: above the rounding of the chain, below any effect

/// The answers of one evaluation: every slot's value and its derivative by every parameter, so that a small
/// term is seen beside a large one.
class Answers final : public ErrorSink {
 public:
  Answers(int slots, int parameters)
      : columns_(1 + static_cast<std::size_t>(parameters)),
        numbers_(static_cast<std::size_t>(slots) * columns_, 0.0) {}
  void clear() { std::fill(numbers_.begin(), numbers_.end(), 0.0); }
  void add(int slot, int parameter, double value, double basis) override {
    at(slot, 0) += value * basis;
    at(slot, 1 + parameter) += basis;
  }
  void value(int slot, double v) override { at(slot, 0) += v; }
  void derivative(int slot, int parameter, double d) override { at(slot, 1 + parameter) += d; }
  bool wantsDerivatives() const override { return true; }

  bool differsFrom(const Answers& other) const {
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
      const double a = numbers_[i], b = other.numbers_[i];
      if (std::isnan(a) != std::isnan(b)) return true;
      if (std::abs(a - b) > kChanged * std::max(std::abs(a), std::abs(b))) return true;
    }
    return false;
  }

 private:
  double& at(int slot, int column) {
    return numbers_[static_cast<std::size_t>(slot) * columns_ + static_cast<std::size_t>(column)];
  }
  std::size_t columns_;
  std::vector<double> numbers_;
};

/// Temperatures that are the same at all times, so that a lag does not pass for a dependence on time.
class SteadyHistory final : public TemperatureHistory {
 public:
  explicit SteadyHistory(const std::vector<double>& temperature) : temperature_(temperature) {}
  double lagged(int sensor, double tau, double, double* byTau) const override {
    constexpr double kBehind = 0.1, kHalf = 100.0;  // any: a response that depends on the time constant
    const double share = std::abs(tau) / (std::abs(tau) + kHalf);
    const double above = temperature_[static_cast<std::size_t>(sensor)] - kReferenceTemperature;
    if (byTau != nullptr) *byTau = -kBehind * above * (1.0 - share) * (1.0 - share) / kHalf;
    return kReferenceTemperature + above * (1.0 - kBehind * share);
  }

 private:
  const std::vector<double>& temperature_;
};

class Trial {
 public:
  Trial(const Effect& effect, const Domain& domain)
      : effect_(effect),
        domain_(domain),
        layout_(static_cast<int>(domain.joints.size())),
        random_(20),
        before_(layout_.size(), effect.parameterCount()),
        after_(before_),
        history_(changed_.temperature) {}

  Inputs run() {
    const std::size_t joints = domain_.joints.size();
    std::vector<char> position(joints, 0), velocity(joints, 0), travel(joints, 0), reversal(joints, 0),
        temperature(domain_.sensors.size(), 0), covariate(domain_.covariates.size(), 0);
    char time = 0, approach = 0, reading = 0, feature = 0;
    for (int k = 0; k < kStates; ++k) {
      const State whole = drawState();
      const std::vector<double> p = drawParameters();
      changed_ = whole;
      answer(p, before_);
      const auto tryIt = [&](char& found, const auto& vary) {
        if (found != 0) return;
        changed_ = whole;
        vary(changed_);
        answer(p, after_);
        found = after_.differsFrom(before_) ? 1 : 0;
      };
      for (std::size_t j = 0; j < joints; ++j) {
        tryIt(position[j], [&](State& s) {
          s.position[j] = drawPosition(j);
          place(s);
        });
        tryIt(velocity[j], [&](State& s) { s.velocity[j] = drawVelocity(j); });
        tryIt(travel[j], [&](State& s) { s.travel[j] = -s.travel[j]; });
        tryIt(reversal[j], [&](State& s) { s.sinceReversal[j] = drawWay(j); });
      }
      for (std::size_t i = 0; i < temperature.size(); ++i)
        tryIt(temperature[i], [&](State& s) { s.temperature[i] = drawTemperature(i); });
      for (std::size_t i = 0; i < covariate.size(); ++i)
        tryIt(covariate[i], [&](State& s) { s.covariate[i] = drawCovariate(i); });
      tryIt(time, [&](State& s) { s.time = drawTime(); });
      tryIt(approach, [&](State& s) { contact(s); });
      if (domain_.laser) tryIt(reading, [&](State& s) { s.laserReading = drawReading(); });
      tryIt(feature, [&](State& s) { touch(s, otherFeature(s.feature)); });
    }
    Inputs inputs;
    inputs.positions = indices(position);
    inputs.velocities = indices(velocity);
    inputs.travels = indices(travel);
    inputs.reversals = indices(reversal);
    inputs.temperatures = indices(temperature);
    inputs.covariates = indices(covariate);
    inputs.time = time != 0;
    inputs.approach = approach != 0;
    inputs.reading = reading != 0;
    inputs.feature = feature != 0;
    return inputs;
  }

 private:
  static std::vector<int> indices(const std::vector<char>& found) {
    std::vector<int> list;
    for (std::size_t i = 0; i < found.size(); ++i)
      if (found[i] != 0) list.push_back(static_cast<int>(i));
    return list;
  }

  double unit() { return unitRandom(random_); }
  double within(double lower, double upper) { return lower + (upper - lower) * unit(); }
  /// Within a range of the domain; what was not observed or never changed gets a plausible width.
  double drawn(const std::vector<double>& lower, const std::vector<double>& upper, std::size_t i, double low,
               double high) {
    if (i >= lower.size() || i >= upper.size() || !std::isfinite(lower[i]) || !std::isfinite(upper[i]))
      return within(low, high);
    const double slack = upper[i] - lower[i] > kStoodStill ? 0.0 : 0.5 * (high - low);
    return within(lower[i] - slack, upper[i] + slack);
  }
  double drawPosition(std::size_t j) {
    const bool rotary = domain_.joints[j].kind == JointKind::kRotary;
    return drawn(domain_.lower, domain_.upper, j, rotary ? -0.5 : -0.01, rotary ? 0.5 : 0.01);
  }
  double drawWay(std::size_t j) { return std::abs(drawPosition(j) - drawPosition(j)); }
  double drawVelocity(std::size_t j) {
    const double most = domain_.maxSpeed > 0.0 ? domain_.maxSpeed : 0.01;
    return drawn(domain_.velocityLower, domain_.velocityUpper, j, -most, most);
  }
  double drawTemperature(std::size_t i) {
    return drawn(domain_.sensorLower, domain_.sensorUpper, i, 15.0, 40.0);
  }
  double drawCovariate(std::size_t i) {
    return drawn(domain_.covariateLower, domain_.covariateUpper, i, -1.0, 1.0);
  }
  double drawTime() { return within(0.0, std::max(domain_.duration, 1.0)); }
  double drawReading() {
    const bool known = std::isfinite(domain_.readingLower) && domain_.readingUpper > domain_.readingLower;
    constexpr double kHalfRange = 5e-3;  // m: of a short triangulation probe
    return known ? within(domain_.readingLower, domain_.readingUpper) : within(-kHalfRange, kHalfRange);
  }
  Eigen::Vector3d drawDirection() {
    for (;;) {
      const Eigen::Vector3d v(within(-1, 1), within(-1, 1), within(-1, 1));
      if (v.norm() > 0.1 && v.norm() < 1.0) return v.normalized();
    }
  }

  /// The lever and the orientation, by the joints alone: fixed turns between them are not known to a Domain,
  /// and which joint moves the tip does not depend on them.
  void place(State& s) const {
    constexpr double kRounding = 1e12;  // to 1e-12 m, so that the rounding of the chain is no change
    Eigen::Isometry3d chain = Eigen::Isometry3d::Identity();
    for (std::size_t j = 0; j < domain_.joints.size(); ++j) {
      const Joint& joint = domain_.joints[j];
      Eigen::Vector3d axis = joint.axis;
      if (axis.squaredNorm() < 0.5) axis = Eigen::Vector3d::Unit(static_cast<int>(j % 3));
      chain.translate(joint.origin);
      if (joint.kind == JointKind::kLinear)
        chain.translate(axis * s.position[j]);
      else
        chain.rotate(Eigen::AngleAxisd(s.position[j], axis));
    }
    const auto rounded = [](double v) { return std::round(v * kRounding) / kRounding; };
    s.tip = (chain * domain_.probeZero).unaryExpr(rounded);
    s.orientation = (chain.linear() * domain_.probeRotation).unaryExpr(rounded);
    if (domain_.laser) s.approach = s.orientation.col(2);
  }

  /// Another direction of the contact. The beam of a laser sees a surface that is inclined by up to 60 deg.
  void contact(State& s) {
    if (!domain_.laser) {
      s.approach = drawDirection();
      s.surfaceNormal = -s.approach;
      return;
    }
    do s.surfaceNormal = drawDirection();
    while (-s.surfaceNormal.dot(s.orientation.col(2)) < 0.5);
    s.approach = (s.orientation.col(2) + 0.1 * drawDirection()).normalized();
  }

  int otherFeature(int feature) {
    const int count = static_cast<int>(domain_.features.size());
    if (count < 2) return feature >= 0 || count == 0 ? -1 : 0;
    return (feature + 1 + static_cast<int>(unit() * (count - 1))) % count;
  }
  void touch(State& s, int feature) {
    s.feature = feature;
    if (feature < 0) return;
    const auto f = static_cast<std::size_t>(feature);
    s.featurePosition = Eigen::Vector3d(within(-0.05, 0.05), within(-0.05, 0.05), within(-0.05, 0.05));
    s.featureRadius = f < domain_.featureRadius.size() ? domain_.featureRadius[f] : within(0.002, 0.01);
  }

  State drawState() {
    State s;
    s.time = drawTime();
    for (std::size_t j = 0; j < domain_.joints.size(); ++j) {
      s.position.push_back(drawPosition(j));
      s.velocity.push_back(drawVelocity(j));
      s.travel.push_back(s.velocity.back() < 0.0 ? -1.0 : 1.0);
      s.sinceReversal.push_back(drawWay(j));
    }
    for (std::size_t i = 0; i < domain_.sensors.size(); ++i) s.temperature.push_back(drawTemperature(i));
    for (std::size_t i = 0; i < domain_.covariates.size(); ++i) s.covariate.push_back(drawCovariate(i));
    s.laserReading = domain_.laser ? drawReading() : std::numeric_limits<double>::quiet_NaN();
    place(s);
    contact(s);
    const auto count = static_cast<double>(domain_.features.size());
    touch(s, count > 0.0 ? static_cast<int>(unit() * count) : -1);
    return s;
  }

  /// Parameters at which the effect is not zero. Those that start elsewhere than at zero are tried over
  /// decades too: a time constant in a formula may start far from the session's length.
  std::vector<double> drawParameters() {
    std::vector<double> p;
    const bool decades = unit() < 0.5;
    for (const Parameter& q : effect_.parameters()) {
      const double size = decades ? std::pow(10.0, within(-4.0, 4.0)) : within(0.8, 1.25);
      const double value = q.start == 0.0 ? q.scale * within(0.5, 1.5) : q.start * size;
      p.push_back(std::clamp(value, q.minimum, q.maximum));
    }
    const std::vector<int> nonlinear = effect_.nature().nonlinear;
    const std::vector<std::vector<double>> starts = effect_.nature().searchStarts;
    if (!decades && !starts.empty()) {
      const auto& start = starts[static_cast<std::size_t>(unit() * static_cast<double>(starts.size()))];
      for (std::size_t k = 0; k < nonlinear.size() && k < start.size(); ++k) p[nonlinear[k]] = start[k];
    }
    return p;
  }

  /// What the effect answers at changed_.
  void answer(const std::vector<double>& p, Answers& answers) {
    changed_.history = &history_;
    answers.clear();
    effect_.evaluate(changed_, p.data(), answers);
  }

  const Effect& effect_;
  const Domain& domain_;
  const ErrorLayout layout_;
  std::mt19937_64 random_;
  Answers before_, after_;
  State changed_;
  const SteadyHistory history_;  // of changed_
};

}  // namespace

Inputs inputsOf(const Effect& effect, const Domain& domain) { return Trial(effect.law(), domain).run(); }

}  // namespace mm
