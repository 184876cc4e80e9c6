#include "effects/catalogue.h"

#include <algorithm>
#include <optional>

#include "base/error.h"
#include "base/format.h"
#include "base/nearest_name.h"
#include "effects/inputs.h"
#include "effects/registry.h"

namespace mm {
namespace {

using Kind = KeyUse::Kind;

/// A machine with every kind of input.
Domain exampleDomain() {
  Domain d = domainOverTravel(Machine::load("five_axis"));
  d.sensors = {"bed", "frame"};
  d.sensorLower = {19.0, 20.0};
  d.sensorUpper = {26.0, 24.0};
  d.covariates = {"humidity"};
  d.covariateLower = {40.0};
  d.covariateUpper = {55.0};
  d.features = {"b0", "b1"};
  d.featureRadius = {4e-3, 4e-3};
  d.duration = 3600.0;
  d.maxSpeed = 0.02;
  d.velocityLower.assign(d.joints.size(), -0.02);
  d.velocityUpper.assign(d.joints.size(), 0.02);
  d.laser = true;
  d.readingLower = -1e-3;
  d.readingUpper = 1e-3;
  return d;
}

/// Values worth trying for a key; the joints of the kind that is looked for come first.
std::vector<EffectSpec::Value> samplesOf(const KeyUse& use, const Domain& domain, JointKind preferred) {
  std::vector<EffectSpec::Value> samples;
  const auto one = [&](const std::string& text) { samples.push_back({{text}, false}); };
  const auto joints = [&](bool linear, bool rotary) {
    for (const bool first : {true, false})
      for (const Joint& j : domain.joints)
        if ((j.kind == preferred) == first && (j.kind == JointKind::kLinear ? linear : rotary)) one(j.name);
  };
  switch (use.kind) {
    case Kind::kJoint:
    case Kind::kDirection:
    case Kind::kDirectionApproach:
      joints(true, true);
      break;
    case Kind::kLinearJoint:
      joints(true, false);
      break;
    case Kind::kRotaryJoint:
      joints(false, true);
      break;
    case Kind::kWorkpieceAxis:
      for (const char* axis : {"x", "y", "z"}) one(axis);
      break;
    case Kind::kSensor:
      one(domain.sensors.front());
      break;
    case Kind::kSensorPair:
    case Kind::kSensorList:
    case Kind::kNames:
      samples.push_back({domain.sensors, true});
      break;
    case Kind::kCovariate:
      one(domain.covariates.front());
      break;
    case Kind::kFeature:
    case Kind::kBall:
      one(domain.features.front());
      break;
    case Kind::kNumber:
    case Kind::kInteger:
      if (use.words.empty()) one(format("%.9g", std::clamp(2.0, use.lower, use.upper)));
      break;
    case Kind::kNumbers:
      one("1");
      break;
    case Kind::kText:
      joints(true, true);
      one("k1*" + domain.joints.front().name);
      break;
    case Kind::kFlag:
    case Kind::kWord:
      break;
  }
  for (const std::string& word : use.words) one(word);
  return samples;
}

EffectSpec with(EffectSpec spec, const std::string& key, const EffectSpec::Value& value) {
  spec.keys.emplace_back(key, value);
  return spec;
}

/// Makes one effect of a type, finding out by trial which keys it cannot do without.
class Example {
 public:
  Example(const EffectType& type, const Domain& domain, JointKind preferred)
      : type_(type), domain_(domain), preferred_(preferred) {
    find(EffectSpec(type.type));
    if (effect) askForTheRest();
  }

  EffectPtr effect;           // empty: no effect of this type acts at such a joint
  EffectSpec spec;            // as it was made
  std::vector<KeyUse> uses;   // of every key that could be made to tell
  bool atPreferred() const {  // a joint of the kind that was looked for is among the keys
    for (const auto& [key, value] : spec.keys)
      for (const Joint& j : domain_.joints)
        if (j.kind == preferred_ && value.items.front() == j.name) return true;
    return false;
  }
  const KeyUse* use(const std::string& key) const {
    const auto found = std::find_if(uses.begin(), uses.end(), [&](const KeyUse& u) { return u.key == key; });
    return found == uses.end() ? nullptr : &*found;
  }

 private:
  /// @return whether the effect was made.
  bool find(const EffectSpec& tried) {
    constexpr int kMostTrials = 2000;
    if (++trials_ > kMostTrials) return false;
    std::optional<KeyUse> lacking;
    {
      const KeyRecorder recorder;
      try {
        effect = type_.create(tried, domain_);
        spec = tried;
        uses = recorder.uses();
        return true;
      } catch (const Error&) {
      }
      for (const KeyUse& use : recorder.uses())
        if (!lacking && !use.absent && tried.find(use.key) == nullptr) lacking = use;
    }
    if (!lacking) return false;
    for (const EffectSpec::Value& sample : samplesOf(*lacking, domain_, preferred_))
      if (find(with(tried, lacking->key, sample))) return true;
    return false;
  }

  /// A value that fits nothing makes every key say what it takes; one that excludes another, without that.
  void askForTheRest() {
    for (const std::string& key : type_.keys) {
      EffectSpec asked = spec;
      asked.keys.erase(std::remove_if(asked.keys.begin(), asked.keys.end(),
                                      [&](const auto& pair) { return pair.first == key; }),
                       asked.keys.end());
      ask(with(asked, key, {{"?"}, false}));
      for (const auto& [other, value] : spec.keys) {
        if (use(key) != nullptr) break;
        EffectSpec without = asked;
        without.keys.erase(std::remove_if(without.keys.begin(), without.keys.end(),
                                          [&, name = other](const auto& pair) { return pair.first == name; }),
                           without.keys.end());
        ask(with(without, key, {{"?"}, false}));
      }
    }
  }

  void ask(const EffectSpec& asked) {
    const KeyRecorder recorder;
    try {
      type_.create(asked, domain_);
    } catch (const Error&) {
    }
    for (const KeyUse& found : recorder.uses()) {
      const auto known =
          std::find_if(uses.begin(), uses.end(), [&](const KeyUse& u) { return u.key == found.key; });
      if (known == uses.end())
        uses.push_back(found);
      else if (known->kind == Kind::kWord && found.kind != Kind::kWord)
        *known = found;
    }
  }

  const EffectType& type_;
  const Domain& domain_;
  const JointKind preferred_;
  int trials_ = 0;
};

std::vector<CatalogueKey> keysOf(const EffectType& type, const Example& linear, const Example* rotary) {
  std::vector<CatalogueKey> keys;
  for (const std::string& name : type.keys) {
    CatalogueKey key;
    const KeyUse* at[2] = {linear.use(name), rotary != nullptr ? rotary->use(name) : nullptr};
    key.use.key = name;
    key.known = at[0] != nullptr || at[1] != nullptr;
    if (key.known) key.use = at[0] != nullptr ? *at[0] : *at[1];
    if (rotary != nullptr && key.known && (at[0] == nullptr) != (at[1] == nullptr))
      key.onlyAt = at[0] != nullptr ? "linear" : "rotary";
    const Example& where = at[0] != nullptr || rotary == nullptr ? linear : *rotary;
    key.required = where.spec.find(name) != nullptr;
    keys.push_back(key);
  }
  return keys;
}

std::vector<CatalogueParameter> parametersOf(const Example& linear, const Example* rotary) {
  std::vector<CatalogueParameter> list;
  for (const Parameter& p : linear.effect->parameters()) list.push_back({p.name, p.unit, {}});
  if (rotary == nullptr) return list;
  for (const Parameter& p : rotary->effect->parameters()) {
    const auto same =
        std::find_if(list.begin(), list.end(), [&](const CatalogueParameter& c) { return c.name == p.name; });
    if (same != list.end())
      same->rotaryUnit = p.unit;
    else
      list.push_back({p.name, {}, p.unit});
  }
  return list;
}

std::vector<std::string> needsOf(const Inputs& in) {
  std::vector<std::string> needs;
  if (!in.positions.empty()) needs.emplace_back("position");
  if (!in.travels.empty()) needs.emplace_back("direction of travel");
  if (!in.reversals.empty()) needs.emplace_back("way since the reversal");
  if (!in.velocities.empty()) needs.emplace_back("velocity");
  if (!in.temperatures.empty()) needs.emplace_back("temperature");
  if (!in.covariates.empty()) needs.emplace_back("covariate");
  if (in.time) needs.emplace_back("time");
  if (in.approach) needs.emplace_back("approach");
  if (in.reading) needs.emplace_back("laser reading");
  if (in.feature) needs.emplace_back("feature");
  return needs;
}

CatalogueEntry entryOf(const EffectType& type, const Domain& domain) {
  CatalogueEntry entry;
  entry.type = type.type;
  entry.composite = type.composite;
  const Example linear(type, domain, JointKind::kLinear);
  if (!linear.effect) {
    for (const std::string& key : type.keys) {
      CatalogueKey unknown;
      unknown.use.key = key;
      unknown.known = false;
      entry.keys.push_back(unknown);
    }
    return entry;
  }
  const Example atRotary(type, domain, JointKind::kRotary);
  const bool both = linear.atPreferred() && atRotary.effect && atRotary.atPreferred();
  const Example* rotary = both ? &atRotary : nullptr;
  entry.example = linear.spec.yaml();
  entry.keys = keysOf(type, linear, rotary);
  entry.parameters = parametersOf(linear, rotary);
  try {
    entry.needs = needsOf(inputsOf(*linear.effect, domain));
  } catch (const Error&) {  // an effect of a plugin that cannot be evaluated is listed all the same
  }
  if (linear.effect->learned()) entry.needs.emplace_back("temperature");
  entry.shownBy = linear.effect->shownBy();
  entry.cause = linear.effect->cause();
  entry.remedy = linear.effect->remedy();
  return entry;
}

}  // namespace

std::vector<CatalogueEntry> effectCatalogue() {
  const Domain domain = exampleDomain();
  std::vector<CatalogueEntry> entries;
  for (const EffectType& type : effectRegistry()) entries.push_back(entryOf(type, domain));
  return entries;
}

std::string takesInWords(const KeyUse& use) {
  std::string words;
  const auto of = [&](const char* what) { words = what; };
  switch (use.kind) {
    case Kind::kJoint:
      of("a joint");
      break;
    case Kind::kLinearJoint:
      of("a linear joint");
      break;
    case Kind::kRotaryJoint:
      of("a rotary joint");
      break;
    case Kind::kDirection:
      of("a joint, or x, y or z of the workpiece");
      break;
    case Kind::kDirectionApproach:
      of("a joint, x, y or z of the workpiece, or approach");
      break;
    case Kind::kWorkpieceAxis:
      of("x, y or z");
      break;
    case Kind::kSensor:
      of("a temperature sensor");
      break;
    case Kind::kSensorPair:
      of("two temperature sensors, [a, b]");
      break;
    case Kind::kSensorList:
      of("temperature sensors, [a, b]");
      break;
    case Kind::kCovariate:
      of("a covariate");
      break;
    case Kind::kFeature:
      of("a ball or point of the artifact");
      break;
    case Kind::kBall:
      of("a ball of the artifact");
      break;
    case Kind::kNumber:
      words = format("a number, %.9g to %.9g", use.lower, use.upper);
      break;
    case Kind::kInteger:
      words = format("a whole number, %.9g to %.9g", use.lower, use.upper);
      break;
    case Kind::kFlag:
      return "true or false";
    case Kind::kWord:
      words = listOf(use.words);
      break;
    case Kind::kText:
      of("a text");
      break;
    case Kind::kNames:
      of("a list of names, [a, b]");
      break;
    case Kind::kNumbers:
      of("a list of numbers, [a, b]");
      break;
  }
  if (use.kind != Kind::kWord)
    for (const std::string& word : use.words) words += ", or " + word;
  if (use.list && use.kind != Kind::kNames) words += ", or a list, [a, b]";
  return words;
}

}  // namespace mm
