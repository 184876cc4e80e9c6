#include "effects/catalogue.h"

#include <algorithm>

#include "base/error.h"
#include "base/format.h"
#include "base/nearest_name.h"
#include "effects/inputs.h"
#include "effects/iso230_symbol.h"
#include "effects/registry.h"

namespace mm {
namespace {

using Kind = KeyUse::Kind;

/// A machine with every kind of input.
Domain exampleDomain() {
  Domain d = domainOverTravel(Machine::load(kExampleMachine));
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

/// One effect of a type, made on the example machine.
struct Example {
  EffectPtr effect;
  std::vector<KeyUse> uses;             // of the keys that it read
  bool linear = false, rotary = false;  // joints of that kind are among its keys
};

Example made(const EffectType& type, const EffectSpec& spec, const Domain& domain) {
  Example example;
  const KeyRecorder recorder;
  example.effect = type.create(spec, domain);
  example.uses = recorder.uses();
  for (const auto& [key, value] : spec.keys)
    for (const Joint& j : domain.joints)
      if (value.items.front() == j.name)
        (j.kind == JointKind::kLinear ? example.linear : example.rotary) = true;
  return example;
}

/// What a type declares as examples, else members of its family: one at a linear axis and one at a rotary one
/// of each form of its keys.
std::vector<Example> examplesOf(const EffectType& type, const Domain& domain) {
  std::vector<Example> examples;
  if (!type.examples.empty()) {
    for (const EffectSpec& spec : type.examples) examples.push_back(made(type, spec, domain));
    return examples;
  }
  std::vector<EffectSpec> members = type.members ? type.members(domain) : type.candidates(domain);
  if (members.empty()) members.emplace_back(type.type);
  for (const EffectSpec& spec : members) {
    try {
      Example example = made(type, spec, domain);
      const bool told = std::any_of(examples.begin(), examples.end(), [&](const Example& e) {
        return e.rotary == example.rotary && (e.linear || !example.linear);
      });
      if (!told) examples.push_back(std::move(example));
    } catch (const Error&) {  // two keys that exclude each other; a plugin's, which says itself what they are
    }
  }
  std::stable_sort(examples.begin(), examples.end(),
                   [](const Example& a, const Example& b) { return !a.rotary && b.rotary; });
  return examples;
}

const KeyUse* useIn(const Example& example, const std::string& key) {
  for (const KeyUse& use : example.uses)
    if (use.key == key) return &use;
  return nullptr;
}

std::vector<CatalogueKey> keysOf(const EffectType& type, const std::vector<Example>& examples) {
  std::vector<CatalogueKey> keys;
  for (const std::string& name : type.keys) {
    CatalogueKey key;
    key.use.key = name;
    key.known = false;
    bool linear = false, rotary = false, always = true;  // where it is read
    for (const Example& e : examples) {
      const KeyUse* use = useIn(e, name);
      if (use == nullptr) {
        always = always && e.rotary != examples.front().rotary;
        continue;
      }
      if (!key.known || (key.use.kind == Kind::kWord && use->kind != Kind::kWord)) {
        const std::vector<std::string> words = key.use.words;  // `unknown`, or a number
        key.use = *use;
        if (key.use.words.empty()) key.use.words = words;
      }
      key.known = true;
      (e.rotary ? rotary : linear) = true;
    }
    const bool both =
        std::any_of(examples.begin(), examples.end(), [](const Example& e) { return e.rotary; }) &&
        std::any_of(examples.begin(), examples.end(), [](const Example& e) { return !e.rotary; });
    if (both && linear != rotary) key.onlyAt = linear ? "linear" : "rotary";
    key.required = key.known && !key.use.absent && (always || !key.onlyAt.empty());
    keys.push_back(key);
  }
  return keys;
}

std::vector<CatalogueParameter> parametersOf(const std::vector<Example>& examples) {
  const Example* rotary = nullptr;
  for (const Example& e : examples)
    if (e.rotary && &e != &examples.front() && rotary == nullptr) rotary = &e;
  std::vector<CatalogueParameter> list;
  for (const Parameter& p : examples.front().effect->parameters()) list.push_back({p.name, p.unit, {}});
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

CatalogueEntry entryOf(const EffectType& type, const Domain& domain, const ErrorSymbols& symbols) {
  CatalogueEntry entry;
  entry.type = type.type;
  entry.composite = type.composite;
  const std::vector<Example> examples = examplesOf(type, domain);
  entry.keys = keysOf(type, examples);
  if (examples.empty()) return entry;
  const Effect& first = *examples.front().effect;
  entry.example = first.spec().yaml();
  entry.iso230 = symbols.of(first.spec());
  entry.parameters = parametersOf(examples);
  try {
    entry.needs = needsOf(inputsOf(first, domain));
  } catch (const Error&) {  // an effect of a plugin that cannot be evaluated is listed all the same
  }
  if (first.nature().learned) entry.needs.emplace_back("temperature");
  entry.shownBy = first.shownBy();
  entry.cause = first.cause();
  entry.remedy = first.remedy();
  return entry;
}

}  // namespace

std::vector<CatalogueEntry> effectCatalogue() {
  const Domain domain = exampleDomain();
  const ErrorSymbols symbols(Machine::load(kExampleMachine));
  std::vector<CatalogueEntry> entries;
  for (const EffectType& type : effectRegistry()) entries.push_back(entryOf(type, domain, symbols));
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
