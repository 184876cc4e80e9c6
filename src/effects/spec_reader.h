#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "effects/direction.h"
#include "effects/domain.h"
#include "effects/effect_spec.h"

namespace mm {

/// Typed access to the keys of a spec. Every function throws InputError with one line that names the effect,
/// the culprit, what is allowed and the nearest known name.
class SpecReader {
 public:
  /// Refuses keys that are not among the allowed ones, and doubled keys.
  SpecReader(const EffectSpec& spec, const Domain& domain, std::vector<std::string> allowed);

  int joint(const std::string& key);                  ///< index in the domain, of any kind
  int joint(const std::string& key, JointKind kind);  ///< of this kind only
  /// A joint, or x, y, z of the workpiece where no joint has that name. @param approachAllowed also
  /// `approach`.
  Direction direction(const std::string& key, bool approachAllowed = false);
  /// 0, 1, 2 for x, y, z. @param of for the message.
  int axisOf(const std::string& key, const std::string& of = "axis of the workpiece");
  bool isWord(const std::string& key, const std::string& word);  ///< the key holds this word
  int sensor(const std::string& key);
  std::pair<int, int> sensorPair(const std::string& key);  ///< two different ones, as a list
  bool isList(const std::string& key) const;
  std::vector<int> sensorList(const std::string& key);  ///< one or more different ones
  int covariate(const std::string& key);
  int feature(const std::string& key);
  int ball(const std::string& key);
  double number(const std::string& key, double lower, double upper, std::optional<double> absent = {});
  int integer(const std::string& key, int lower, int upper, std::optional<int> absent = {});
  bool flag(const std::string& key, bool absent);
  /// One of the words; the first is taken when the key is absent.
  std::string choice(const std::string& key, const std::vector<std::string>& words);
  std::string text(const std::string& key);
  std::vector<std::string> names(const std::string& key);  ///< as a list
  std::vector<double> numbers(
      const std::string& key);  ///< empty when absent; a single number is a list of one

  bool has(const std::string& key) const { return spec_.find(key) != nullptr; }  ///< whether the key is given
  const Domain& domain() const { return domain_; }  ///< in which names are looked up
  /// Of the domain. @param index of joint() or a direction.
  const Joint& jointAt(int index) const { return domain_.joints[static_cast<std::size_t>(index)]; }
  /// Whether the effect is one of a rotary axis: its key `axis` names a rotary joint.
  bool ofRotaryAxis() const;
  ErrorLayout layout() const {
    return ErrorLayout(static_cast<int>(domain_.joints.size()));
  }  ///< of its slots
  /// What was read, in the order of the allowed keys, numbers in their shortest form and defaults left out:
  /// two specs that mean the same have the same canonical form.
  EffectSpec canonical() const;
  [[noreturn]] void fail(const std::string& what) const;

 private:
  const std::string& scalar(const std::string& key) const;
  double parse(const std::string& key, const std::string& text) const;
  int find(const std::string& key, const std::string& what, const std::vector<std::string>& known);

  const EffectSpec& spec_;
  const Domain& domain_;
  std::vector<std::string> allowed_;
  EffectSpec read_;
};

}  // namespace mm
