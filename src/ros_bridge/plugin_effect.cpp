#include "ros_bridge/plugin_effect.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <set>

#include "base/error.h"
#include "ros_bridge/plugin_terms.h"

namespace mm {
namespace {

constexpr int kTrials = 4;           // states at which an effect is tried
constexpr double kRounding = 1e-9;   // of two sums of the same terms, far below any effect that is not linear
constexpr double kStep = 2e-3;       // of the parameter: eighth order leaves 1e-16 of it, rounding 1e-13
constexpr double kLeastStep = 1e-6;  // of its scale, where it stands at a limit
constexpr double kNearZero = 1e-3;   // of its scale: below it the step does not follow the parameter
constexpr double kOfTheWay = 0.24;   // to a limit: four steps to either side stay within it

/// Passes on each line once.
class Once {
 public:
  explicit Once(PluginTrouble say) : say_(std::move(say)) {}
  void operator()(const std::string& line) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (said_.insert(line).second && say_) say_(line);
  }

 private:
  std::mutex mutex_;
  std::set<std::string> said_;
  PluginTrouble say_;
};

/// Shared by all effects of one type.
struct Origin {
  std::shared_ptr<const plugin::EffectType> type;  // outlives its effects: their code is in its library
  std::string name;
  std::shared_ptr<Once> trouble;
};

/// An effect of a plugin, in the terms of the library. Derivatives by differences of eighth order.
class PluginEffect final : public Effect {
 public:
  /// @param spec canonical.
  PluginEffect(EffectSpec spec, Origin origin, std::unique_ptr<plugin::Effect> effect, const Domain& domain)
      : layout_(static_cast<int>(domain.joints.size())),
        origin_(std::move(origin)),
        effect_(std::move(effect)) {
    spec_ = std::move(spec);
    if (!effect_) throw InputError("create() returned nothing");
    for (const plugin::Key& key : origin_.type->keys())
      if (key.shape) nature_.shapeKeys.push_back(key.name);
    nature_.stage = Stage::kVolume;
    nature_.variesAlong = jointsOf("variesAlong()", effect_->variesAlong());
    nature_.mustMove = jointsOf("mustMove()", effect_->mustMove());
    nature_.positionsNeeded = effect_->positionsNeeded();
    cause_ = effect_->cause();
    remedy_ = effect_->remedy();
    shownBy_ = effect_->shownBy();
    for (const plugin::Parameter& p : effect_->parameters()) {
      if (p.name.empty() || !(p.scale > 0.0) || !(p.bound > 0.0) || !std::isfinite(p.toUnit) ||
          p.toUnit == 0.0)
        throw InputError("parameter '" + p.name +
                         "' needs a name, a scale and a bound above 0, and a toUnit");
      if (!p.search.empty()) {
        nature_.nonlinear.push_back(static_cast<int>(parameters_.size()));
        combine(p.search);
      }
      parameters_.push_back(
          {p.name, p.unit, p.toUnit, p.scale, p.bound, p.start, p.minimum, p.maximum, p.priorStd});
    }
    if (parameters_.empty()) throw InputError("parameters() is empty");
    nature_.linear = nature_.nonlinear.empty();
    if (nature_.nonlinear.size() == parameters_.size())
      throw InputError("an effect needs a parameter in which it is linear: its size");
    checkLinear(domain);
  }

  std::vector<ShapeFreedom> freedom(const Domain& domain) const override;
  std::string cause() const override { return cause_; }
  std::string remedy() const override { return remedy_; }
  std::string shownBy() const override { return shownBy_; }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    Call call(*this, state);
    if (!linear()) {
      const std::vector<double>& value = call(p);
      for (int slot = 0; slot < layout_.size(); ++slot)
        if (value[slot] != 0.0) sink.value(slot, value[slot]);
      if (!sink.wantsDerivatives()) return;
    }
    std::vector<double> slope(static_cast<std::size_t>(layout_.size()));
    for (int i = 0; i < parameterCount(); ++i) {
      call.slopes(p, i, slope);
      for (int slot = 0; slot < layout_.size(); ++slot) {
        if (slope[slot] == 0.0) continue;
        if (linear())
          sink.add(slot, i, p[i], slope[slot]);
        else
          sink.derivative(slot, i, slope[slot]);
      }
    }
  }

 private:
  /// Evaluations at one state.
  class Call {
   public:
    Call(const PluginEffect& effect, const State& state)
        : effect_(effect),
          state_(stateOf(state)),
          value_(static_cast<std::size_t>(effect.layout_.size())),
          atJoint_(static_cast<std::size_t>(6 * effect.layout_.joints())),
          p_(effect.parameters_.size()) {}

    /// One value a slot; NaN in all that matter where the plugin threw.
    const std::vector<double>& operator()(const double* p) {
      const ErrorLayout& layout = effect_.layout_;
      std::fill(value_.begin(), value_.end(), 0.0);
      std::fill(atJoint_.begin(), atJoint_.end(), 0.0);
      plugin::Error e;
      e.reading = value_.data() + (layout.joints() > 0 ? layout.axis(0) : 0);
      e.atJoint = atJoint_.data();
      try {
        effect_.effect_->evaluate(state_, p, e);
      } catch (const std::exception& error) {
        effect_.failed(error.what(), e);
      } catch (...) {
        effect_.failed("something that is not a std::exception", e);
      }
      for (int j = 0; j < layout.joints(); ++j)
        for (int k = 0; k < 3; ++k) {
          value_[layout.jointTranslation(j, k)] = atJoint_[6 * j + k];
          value_[layout.jointRotation(j, k)] = atJoint_[6 * j + 3 + k];
        }
      for (int k = 0; k < 3; ++k) {
        value_[layout.volume(k)] = e.volume[k];
        value_[layout.orientation(k)] = e.orientation[k];
        value_[layout.probe(k)] = e.probe[k];
        value_[layout.feature(k)] = e.feature[k];
      }
      value_[layout.reading()] = e.laserReading;
      value_[layout.distance()] = e.distance;
      return value_;
    }

    /// Derivative of every slot by parameter i at p. Linear ones: the step does not matter.
    void slopes(const double* p, int i, std::vector<double>& slope) {
      const Parameter& parameter = effect_.parameters_[i];
      std::copy(p, p + p_.size(), p_.begin());
      if (!effect_.isSearched(i)) {  // the error at one of this parameter, and none of the other linear ones
        for (std::size_t k = 0; k < p_.size(); ++k)
          if (!effect_.isSearched(static_cast<int>(k))) p_[k] = 0.0;
        p_[i] = parameter.scale;
        const std::vector<double>& value = (*this)(p_.data());
        for (std::size_t s = 0; s < slope.size(); ++s) slope[s] = value[s] / parameter.scale;
        return;
      }
      constexpr double kWeights[4] = {4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0};
      std::fill(slope.begin(), slope.end(), 0.0);
      double h = kStep * std::max(std::abs(p[i]), kNearZero * parameter.scale);
      h = std::min({h, kOfTheWay * std::abs(p[i] - parameter.minimum),
                    kOfTheWay * std::abs(parameter.maximum - p[i])});
      if (!(h > 0.0)) h = kLeastStep * parameter.scale;
      for (int step = 1; step <= 4; ++step)
        for (const double side : {1.0, -1.0}) {
          p_[i] = p[i] + side * step * h;
          const std::vector<double>& value = (*this)(p_.data());
          for (std::size_t s = 0; s < slope.size(); ++s) slope[s] += side * kWeights[step - 1] * value[s] / h;
        }
    }

   private:
    const PluginEffect& effect_;
    const plugin::State state_;
    std::vector<double> value_, atJoint_, p_;
  };

  /// Whether the error is not linear in that parameter.
  bool isSearched(int i) const {
    return std::find(nature_.nonlinear.begin(), nature_.nonlinear.end(), i) != nature_.nonlinear.end();
  }

  void failed(const std::string& what, plugin::Error& e) const {
    (*origin_.trouble)(origin_.name + ": " + spec_.yaml() + " threw during evaluation: " + what +
                       "; its inputs count as not known there");
    constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
    for (int k = 0; k < 3; ++k) e.volume[k] = kUnknown;
    for (int j = 0; j < layout_.joints(); ++j) e.reading[j] = kUnknown;
  }

  std::vector<int> jointsOf(const std::string& what, std::vector<int> joints) const {
    for (const int joint : joints)
      if (joint < 0 || joint >= layout_.joints())
        throw InputError(what + " names joint " + std::to_string(joint) + "; there are 0 to " +
                         std::to_string(layout_.joints() - 1));
    return joints;
  }

  /// The starts of one more searched parameter with each of those before it.
  void combine(const std::vector<double>& search) {
    if (nature_.searchStarts.empty()) nature_.searchStarts.push_back({});
    std::vector<std::vector<double>> all;
    for (const std::vector<double>& before : nature_.searchStarts)
      for (const double value : search) {
        all.push_back(before);
        all.back().push_back(value);
      }
    nature_.searchStarts = std::move(all);
  }

  /// Refuses an effect that is not linear where it says so: it would be fitted wrongly without a word.
  void checkLinear(const Domain& domain) const {
    Random random(5, "plugin");
    for (int trial = 0; trial < kTrials; ++trial) {
      const State state = stateWithin(domain, random);
      Call call(*this, state);
      std::vector<double> a, sum(static_cast<std::size_t>(layout_.size()), 0.0), slope(sum.size());
      for (const Parameter& q : parameters_) a.push_back(q.scale * random.uniform(0.5, 1.5));
      std::size_t k = 0;
      for (const int i : nature_.nonlinear) a[i] = nature_.searchStarts.front()[k++];
      for (int i = 0; i < parameterCount(); ++i) {
        if (isSearched(i)) continue;
        call.slopes(a.data(), i, slope);
        for (std::size_t s = 0; s < sum.size(); ++s) sum[s] += a[i] * slope[s];
      }
      const std::vector<double>& value = call(a.data());
      for (std::size_t s = 0; s < sum.size(); ++s) {
        if (!std::isfinite(value[s]) ||
            std::abs(value[s] - sum[s]) <= kRounding * (std::abs(value[s]) + std::abs(sum[s])))
          continue;
        throw InputError(
            "its error is not linear in the parameters without `search`; give `search` to the nonlinear "
            "ones");
      }
    }
  }

  const ErrorLayout layout_;
  const Origin origin_;
  const std::unique_ptr<plugin::Effect> effect_;
  std::string cause_, remedy_, shownBy_;
};

EffectPtr create(const Origin& origin, const EffectSpec& spec, const Domain& domain) {
  try {
    EffectSpec canonical(spec.type);
    const plugin::Keys keys = keysOf(spec, origin.type->keys(), canonical);
    return std::make_shared<PluginEffect>(canonical, origin, origin.type->create(keys, sessionOf(domain)),
                                          domain);
  } catch (const std::exception& e) {
    throw InputError("effect " + spec.yaml() + " (" + origin.name + "): " + e.what());
  }
}

/// A shape that cannot be made is left out; the cause has its main one.
std::vector<ShapeFreedom> PluginEffect::freedom(const Domain& domain) const {
  std::vector<ShapeFreedom> shapes;
  try {
    for (const plugin::ShapeFreedom& shape : effect_->freedom()) {
      const EffectPtr other = create(origin_, specOf(spec_.type, shape.keys), domain);
      if (!other->linear() || !(shape.share > 0.0) || other->spec() == spec_)
        throw InputError("a shape must be another one, linear in its parameters, with a share above 0: " +
                         other->spec().yaml());
      shapes.push_back({other->spec(), shape.share});
    }
  } catch (const std::exception& e) {
    (*origin_.trouble)(origin_.name + ": freedom() failed, a diagnosis does without: " + e.what());
  }
  return shapes;
}

}  // namespace

EffectType pluginEffectType(std::shared_ptr<const plugin::EffectType> type, const std::string& origin,
                            PluginTrouble trouble) {
  const Origin shared{type, origin, std::make_shared<Once>(std::move(trouble))};
  EffectType entry;
  entry.type = type->name();
  for (const plugin::Key& key : type->keys()) entry.keys.push_back(key.name);
  entry.create = [shared](const EffectSpec& spec, const Domain& domain) {
    return create(shared, spec, domain);
  };
  // A plugin that cannot say what to try is left out of a diagnosis; the others go on.
  entry.candidates = [shared, name = entry.type](const Domain& domain) {
    std::vector<EffectSpec> specs;
    try {
      for (const plugin::Keys& keys : shared.type->candidates(sessionOf(domain)))
        specs.push_back(create(shared, specOf(name, keys), domain)->spec());
    } catch (const std::exception& e) {
      (*shared.trouble)(shared.name +
                        ": candidates() failed, a diagnosis does not try them all: " + e.what());
    }
    return specs;
  };
  return entry;
}

}  // namespace mm
