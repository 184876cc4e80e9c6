#include "effects/inputs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace mm {
namespace {

constexpr double kChanged = 1e-9;  // of a contribution: above the rounding of the chain, below any effect

/// The answers of one evaluation: every slot's value and its derivative by every parameter, so that a small
/// term is seen beside a large one.
class Answers final : public ErrorSink {
 public:
  Answers(int slots, int parameters)
      : columns_(1 + static_cast<std::size_t>(parameters)),
        numbers_(static_cast<std::size_t>(slots) * columns_, 0.0) {}
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

/// Asks an effect at a complete state, with one input after the other changed or not known.
class Questions {
 public:
  Questions(const Effect& effect, const Domain& domain)
      : effect_(effect), domain_(domain), layout_(static_cast<int>(domain.joints.size())) {
    for (const Parameter& q : effect.parameters()) parameters_.push_back(q.start == 0.0 ? q.scale : q.start);
  }

  Inputs ask() {
    Inputs inputs;
    // Of two features one may be the effect's own. What acts on a touch only acts on any of them.
    const int count = static_cast<int>(domain_.features.size());
    const int first = count > 1 ? 0 : -1;
    std::vector<State> complete = {stateAt(first)};
    for (int f = first + 1; f < count && !inputs.feature; ++f) {
      inputs.feature = answer(stateAt(f)).differsFrom(answer(complete[0]));
      if (inputs.feature || f == 0) complete.push_back(stateAt(f));
    }
    for (const State& state : complete) ask(state, inputs);
    for (auto* found : {&inputs.positions, &inputs.velocities, &inputs.travels, &inputs.reversals,
                        &inputs.temperatures, &inputs.covariates}) {
      std::sort(found->begin(), found->end());
      found->erase(std::unique(found->begin(), found->end()), found->end());
    }
    return inputs;
  }

 private:
  void ask(const State& complete, Inputs& inputs) const {
    const Answers before = answer(complete);
    const auto matters = [&](const auto& change) {
      State changed = complete;
      change(changed);
      return answer(changed).differsFrom(before);
    };
    const auto either = [&](std::vector<double> State::*values, std::size_t i, double other, double unknown) {
      return matters([&](State& s) { (s.*values)[i] = other; }) ||
             matters([&](State& s) { (s.*values)[i] = unknown; });
    };
    constexpr double kOtherShare = 0.83;
    for (std::size_t j = 0; j < domain_.joints.size(); ++j) {
      const int joint = static_cast<int>(j);
      const bool lever = matters([&](State& s) {
        s.position[j] = positionAt(j, kOtherShare);
        place(s);
      });
      if (lever || matters([&](State& s) { s.position[j] = kNotKnown; })) inputs.positions.push_back(joint);
      if (either(&State::velocity, j, 0.7 * complete.velocity[j], kNotKnown))
        inputs.velocities.push_back(joint);
      if (either(&State::travel, j, -1.0, 0.0)) inputs.travels.push_back(joint);
      if (either(&State::sinceReversal, j, 0.5 * complete.sinceReversal[j], kNotKnown))
        inputs.reversals.push_back(joint);
    }
    for (std::size_t i = 0; i < domain_.sensors.size(); ++i)
      if (either(&State::temperature, i, complete.temperature[i] + 3.0, kNotKnown))
        inputs.temperatures.push_back(static_cast<int>(i));
    for (std::size_t i = 0; i < domain_.covariates.size(); ++i)
      if (either(&State::covariate, i, complete.covariate[i] + 0.1, kNotKnown))
        inputs.covariates.push_back(static_cast<int>(i));
    inputs.time = inputs.time || matters([](State& s) { s.time *= 1.7; }) ||
                  matters([](State& s) { s.time = kNotKnown; });
    inputs.approach = inputs.approach || matters([&](State& s) { contact(s, 1.1); }) ||
                      matters([](State& s) { s.approach.setZero(), s.surfaceNormal.setZero(); });
    inputs.reading =
        inputs.reading || (domain_.laser && (matters([](State& s) { s.laserReading += 1e-3; }) ||
                                             matters([](State& s) { s.laserReading = kNotKnown; })));
    inputs.history = inputs.history || answer(complete, false).differsFrom(before);
  }

  Answers answer(State state, bool history = true) const {
    const SettledTemperatures steady(state.temperature);  // a lag is no dependence on time
    state.history = history ? &steady : nullptr;
    Answers answers(layout_.size(), effect_.parameterCount());
    effect_.evaluate(state, parameters_.data(), answers);
    return answers;
  }

  /// A part of the observed range of a joint; of one that stood still, of a plausible one about its place.
  double positionAt(std::size_t j, double share) const {
    const bool rotary = domain_.joints[j].kind == JointKind::kRotary;
    double lower = j < domain_.lower.size() ? domain_.lower[j] : 0.0;
    double upper = j < domain_.upper.size() ? domain_.upper[j] : 0.0;
    const double half = rotary ? 0.5 : 0.01;
    if (!(upper - lower > kStoodStill)) lower -= half, upper += half;
    return lower + share * (upper - lower);
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

  /// A direction of contact. The beam of a laser sees a surface that is inclined.
  void contact(State& s, double angle) const {
    const Eigen::Vector3d direction(0.8 * std::cos(angle), 0.8 * std::sin(angle), -0.6);
    s.approach = domain_.laser ? s.orientation.col(2) : direction;
    s.surfaceNormal = domain_.laser ? (0.2 * direction - s.orientation.col(2)).normalized() : -s.approach;
  }

  /// A state of which every input is known, and none is special.
  State stateAt(int feature) const {
    constexpr double kShare = 0.31, kNext = 0.07;
    State s;
    s.time = kShare * std::max(domain_.duration, 1.0);
    for (std::size_t j = 0; j < domain_.joints.size(); ++j) {
      s.position.push_back(positionAt(j, kShare + kNext * static_cast<double>(j)));
      s.velocity.push_back(1e-3 * static_cast<double>(j + 1));
      s.travel.push_back(1.0);
      s.sinceReversal.push_back(0.1 * std::abs(positionAt(j, 1.0) - positionAt(j, 0.0)));
    }
    for (std::size_t i = 0; i < domain_.sensors.size(); ++i)
      s.temperature.push_back(22.0 + static_cast<double>(i));
    for (std::size_t i = 0; i < domain_.covariates.size(); ++i)
      s.covariate.push_back(0.3 + 0.1 * static_cast<double>(i));
    s.laserReading = domain_.laser ? 1e-3 : kNotKnown;
    place(s);
    contact(s, 0.4);
    s.feature = feature;
    if (feature < 0) return s;
    const auto f = static_cast<std::size_t>(feature);
    s.featurePosition = Eigen::Vector3d(0.01, -0.02, 0.03) * static_cast<double>(feature + 1);
    s.featureRadius = f < domain_.featureRadius.size() ? domain_.featureRadius[f] : 5e-3;
    return s;
  }

  static constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
  const Effect& effect_;
  const Domain& domain_;
  const ErrorLayout layout_;
  std::vector<double> parameters_;
};

}  // namespace

Inputs inputsOf(const Effect& effect, const Domain& domain) { return Questions(effect.law(), domain).ask(); }

}  // namespace mm
