#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "effects/effect_words.h"
#include "effects/registry.h"
#include "effects/spec_reader.h"

namespace mm {

/// What contributes when an input is not known.
inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Where an error along a direction acts in the chain.
inline Stage stageOf(const Direction& direction) {
  return direction.kind == Direction::Kind::kJoint       ? Stage::kAxis
         : direction.kind == Direction::Kind::kWorkpiece ? Stage::kVolume
                                                         : Stage::kProbe;
}

/// What the effects of the catalogue have in common besides their physics.
class CatalogueEffect : public Effect {
 public:
  void adopt(EffectSpec canonical) { spec_ = std::move(canonical); }  ///< what spec() gives
  std::string cause() const override { return wordsOf(spec(), "cause", variant_, words_); }
  std::string remedy() const override { return wordsOf(spec(), "remedy", variant_, words_); }
  std::string shownBy() const override { return wordsOf(spec(), "shown_by", variant_, words_); }

 protected:
  CatalogueEffect(const SpecReader& read, Stage stage)
      : layout_(read.layout()), variant_(read.ofRotaryAxis() ? "of a rotary axis" : "") {
    nature_.stage = stage;
  }
  CatalogueEffect(const SpecReader& read, const Direction& direction)
      : CatalogueEffect(read, stageOf(direction)) {}

  const ErrorLayout layout_;
  std::string variant_;                       // of its words; empty: those of its type
  std::map<std::string, std::string> words_;  // that words.yaml may name beside its keys
};

using Candidates = std::function<std::vector<EffectSpec>(const Domain&)>;

/// The registry entry of an effect class that is constructed from a SpecReader.
template <class E>
EffectType effectType(const std::string& type, std::vector<std::string> keys, Candidates candidates,
                      bool composite = false, std::vector<EffectSpec> examples = {}) {
  EffectType entry;
  entry.examples = std::move(examples);
  entry.type = type;
  entry.keys = keys;
  entry.create = [keys = std::move(keys)](const EffectSpec& spec, const Domain& domain) -> EffectPtr {
    SpecReader read(spec, domain, keys);
    auto effect = std::make_shared<E>(read);
    effect->adopt(read.canonical());
    return effect;
  };
  entry.candidates =
      candidates ? std::move(candidates) : [](const Domain&) { return std::vector<EffectSpec>(); };
  entry.composite = composite;
  return entry;
}

/// Names of the joints of one kind.
std::vector<std::string> jointNames(const Domain& domain, JointKind kind);
/// Names of all joints.
std::vector<std::string> jointNames(const Domain& domain);
/// Pairs of different joints between which geometry couples the readings: the linear ones; the rotary ones on
/// a machine that has no linear joint.
std::vector<std::pair<std::string, std::string>> coupledJoints(const Domain& domain);
/// Every `direction` of its own: the joints and, where less than three of them are linear, the axes of the
/// workpiece.
std::vector<std::string> directionNames(const Domain& domain);

/// The effects that differ from `spec` in the whole number of one key: the other shapes of one cause.
/// @param absent the value that the canonical form leaves out; 0: none.
std::vector<ShapeFreedom> otherValues(const EffectSpec& spec, const std::string& key, int value, int lowest,
                                      int highest, int absent = 0);

/// Features that are, or may be, balls.
std::vector<std::string> ballNames(const Domain& domain);

/// Position of a joint scaled to -1 … 1 over its observed range; 0 where it was never moved.
class ScaledPosition {
 public:
  ScaledPosition(const Domain& domain, int joint);
  double operator()(const State& state) const { return (state.position[joint_] - centre_) * inverse_; }

 private:
  int joint_;
  double centre_ = 0.0, inverse_ = 0.0;
};

/// Observed travel of a joint, m or rad; 0 where it was never moved.
double observedRange(const Domain& domain, int joint);

}  // namespace mm
