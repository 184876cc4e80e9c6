#include "effects/spec_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/error.h"
#include "base/nearest_name.h"
#include "effects/catalogue_effect.h"
#include "effects/key_recorder.h"

namespace mm {
namespace {

std::string shortest(double value) {
  EffectSpec spec;
  return spec.set("", value).text("");
}

const std::vector<std::string>& workpieceAxes() {
  static const std::vector<std::string> names{"x", "y", "z"};
  return names;
}

using Kind = KeyUse::Kind;

void note(const std::string& key, Kind kind) { KeyRecorder::note({key, kind, 0.0, 0.0, {}, {}, false}); }

}  // namespace

SpecReader::SpecReader(const EffectSpec& spec, const Domain& domain, std::vector<std::string> allowed)
    : spec_(spec), domain_(domain), allowed_(std::move(allowed)), read_(spec.type) {
  for (auto entry = spec.keys.begin(); entry != spec.keys.end(); ++entry) {
    const std::string& key = entry->first;
    if (std::find(allowed_.begin(), allowed_.end(), key) == allowed_.end())
      fail("unknown key '" + key + "'" + didYouMean(key, allowed_) + "; allowed: " + listOf(allowed_));
    if (std::any_of(spec.keys.begin(), entry, [&](const auto& other) { return other.first == key; }))
      fail("key '" + key + "' is given twice; keep one");
  }
}

bool SpecReader::ofRotaryAxis() const {
  const int joint = domain_.findJoint(spec_.text("axis"));
  return joint >= 0 && jointAt(joint).kind == JointKind::kRotary;
}

EffectSpec SpecReader::canonical() const {
  EffectSpec ordered(read_.type);
  for (const std::string& key : allowed_)
    if (const EffectSpec::Value* value = read_.find(key)) ordered.keys.emplace_back(key, *value);
  return ordered;
}

void SpecReader::fail(const std::string& what) const {
  throw InputError("effect " + spec_.yaml() + ": " + what);
}

const std::string& SpecReader::scalar(const std::string& key) const {
  const EffectSpec::Value* value = spec_.find(key);
  if (value == nullptr) fail("key '" + key + "' is missing; add it");
  if (value->list || value->items.size() != 1 || value->items.front().empty())
    fail("key '" + key + "' must be a single value, not a list or nothing");
  return value->items.front();
}

double SpecReader::parse(const std::string& key, const std::string& text) const {
  double value = 0.0;
  const char* first = text.data() + (text.size() > 1 && text[0] == '+' ? 1 : 0);
  const auto [end, error] = std::from_chars(first, text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    fail("key '" + key + "' must be a finite number, not '" + text + "'");
  return value;
}

int SpecReader::find(const std::string& key, const std::string& what, const std::vector<std::string>& known) {
  const std::string& name = scalar(key);
  const auto found = std::find(known.begin(), known.end(), name);
  if (found == known.end())
    fail(key + " '" + name + "' is no " + what + "; there are: " + listOf(known) + didYouMean(name, known));
  read_.set(key, name);
  return static_cast<int>(found - known.begin());
}

int SpecReader::joint(const std::string& key) {
  note(key, Kind::kJoint);
  return find(key, "joint of the machine", jointNames(domain_));
}

int SpecReader::joint(const std::string& key, JointKind kind) {
  note(key, kind == JointKind::kLinear ? Kind::kLinearJoint : Kind::kRotaryJoint);
  const std::string& name = scalar(key);
  const int index = domain_.findJoint(name);
  const std::string word = kind == JointKind::kLinear ? "linear" : "rotary";
  if (index >= 0 && domain_.joints[index].kind != kind)
    fail(key + " '" + name + "' is not a " + word +
         " joint; there are: " + listOf(jointNames(domain_, kind)));
  return joint(key);
}

Direction SpecReader::direction(const std::string& key, bool approachAllowed) {
  note(key, approachAllowed ? Kind::kDirectionApproach : Kind::kDirection);
  const std::string& name = scalar(key);
  const int index = domain_.findJoint(name);
  if (index >= 0) {
    read_.set(key, name);
    return {Direction::Kind::kJoint, index, name, domain_.joints[index].kind};
  }
  if (approachAllowed && name == "approach") {
    read_.set(key, name);
    return {Direction::Kind::kApproach, 0, name, JointKind::kLinear};
  }
  const auto& axes = workpieceAxes();
  const auto found = std::find(axes.begin(), axes.end(), name);
  if (found == axes.end()) {
    std::vector<std::string> known = jointNames(domain_);
    for (const std::string& axis : axes)
      if (domain_.findJoint(axis) < 0) known.push_back(axis);
    if (approachAllowed) known.emplace_back("approach");
    fail(key + " '" + name + "' is neither a joint nor an axis of the workpiece; available: " +
         listOf(known) + didYouMean(name, known));
  }
  read_.set(key, name);
  return {Direction::Kind::kWorkpiece, static_cast<int>(found - axes.begin()), name, JointKind::kLinear};
}

int SpecReader::axisOf(const std::string& key, const std::string& of) {
  note(key, Kind::kWorkpieceAxis);
  return find(key, of, workpieceAxes());
}

bool SpecReader::isWord(const std::string& key, const std::string& word) {
  KeyRecorder::note({key, Kind::kWord, 0.0, 0.0, {word}, {}, false});
  if (scalar(key) != word) return false;
  read_.set(key, word);
  return true;
}

int SpecReader::sensor(const std::string& key) {
  note(key, Kind::kSensor);
  return find(key, "temperature sensor of the session", domain_.sensors);
}

std::pair<int, int> SpecReader::sensorPair(const std::string& key) {
  note(key, Kind::kSensorPair);
  const EffectSpec::Value* value = spec_.find(key);
  if (value == nullptr) fail("key '" + key + "' is missing; add it");
  if (value->items.size() != 2 || value->items[0] == value->items[1])
    fail("key '" + key + "' must be a list of two different sensors, as [a, b]");
  int index[2];
  for (int i = 0; i < 2; ++i) {
    index[i] = domain_.findSensor(value->items[i]);
    if (index[i] < 0)
      fail(key + ": '" + value->items[i] + "' is not a temperature sensor of the session; available: " +
           listOf(domain_.sensors) + didYouMean(value->items[i], domain_.sensors));
  }
  read_.setList(key, value->items);
  return {index[0], index[1]};
}

bool SpecReader::isList(const std::string& key) const {
  KeyRecorder::noteList(key);
  const EffectSpec::Value* value = spec_.find(key);
  return value != nullptr && value->list;
}

std::vector<int> SpecReader::sensorList(const std::string& key) {
  note(key, Kind::kSensorList);
  const EffectSpec::Value* value = spec_.find(key);
  if (value == nullptr || !value->list || value->items.empty())
    fail("key '" + key + "' must be a list of sensors, as [a, b]");
  std::vector<int> sensors;
  for (const std::string& name : value->items) {
    const int index = domain_.findSensor(name);
    if (index < 0)
      fail(key + ": '" + name + "' is not a temperature sensor of the session; available: " +
           listOf(domain_.sensors) + didYouMean(name, domain_.sensors));
    if (std::find(sensors.begin(), sensors.end(), index) != sensors.end())
      fail(key + ": '" + name + "' is listed twice; keep one");
    sensors.push_back(index);
  }
  read_.setList(key, value->items);
  return sensors;
}

int SpecReader::covariate(const std::string& key) {
  note(key, Kind::kCovariate);
  return find(key, "covariate of the session", domain_.covariates);
}

int SpecReader::feature(const std::string& key) {
  note(key, Kind::kFeature);
  return find(key, "feature of the artifact", domain_.features);
}

int SpecReader::ball(const std::string& key) {
  note(key, Kind::kBall);
  const int index = feature(key);
  if (index < static_cast<int>(domain_.featureRadius.size()) && domain_.featureRadius[index] <= 0.0)
    fail(key + " '" + domain_.features[index] + "' is a point, not a ball");
  return index;
}

double SpecReader::number(const std::string& key, double lower, double upper, std::optional<double> absent) {
  KeyRecorder::note({key,
                     Kind::kNumber,
                     lower,
                     upper,
                     {},
                     absent ? std::optional<std::string>(shortest(*absent)) : std::nullopt,
                     false});
  if (absent && !has(key)) return *absent;
  const double value = parse(key, scalar(key));
  if (value < lower || value > upper)
    fail("key '" + key + "' must be within " + shortest(lower) + " and " + shortest(upper) + ", not " +
         shortest(value));
  if (!absent || value != *absent) read_.set(key, value);
  return value;
}

int SpecReader::integer(const std::string& key, int lower, int upper, std::optional<int> absent) {
  KeyRecorder::note({key,
                     Kind::kInteger,
                     static_cast<double>(lower),
                     static_cast<double>(upper),
                     {},
                     absent ? std::optional<std::string>(std::to_string(*absent)) : std::nullopt,
                     false});
  const double value = number(key, lower, upper, absent ? std::optional<double>(*absent) : std::nullopt);
  if (value != std::floor(value)) fail("key '" + key + "' must be a whole number, not " + shortest(value));
  return static_cast<int>(value);
}

bool SpecReader::flag(const std::string& key, bool absent) {
  KeyRecorder::note({key, Kind::kFlag, 0.0, 0.0, {"true", "false"}, absent ? "true" : "false", false});
  if (!has(key)) return absent;
  const std::string& word = scalar(key);
  if (word != "true" && word != "false") fail("key '" + key + "' must be true or false, not '" + word + "'");
  if ((word == "true") != absent) read_.set(key, word);
  return word == "true";
}

std::string SpecReader::choice(const std::string& key, const std::vector<std::string>& words) {
  KeyRecorder::note({key, Kind::kWord, 0.0, 0.0, words, words.front(), false});
  if (!has(key)) return words.front();
  const std::string& word = scalar(key);
  if (std::find(words.begin(), words.end(), word) == words.end())
    fail("key '" + key + "' must be one of: " + listOf(words) + "; not '" + word + "'");
  if (word != words.front()) read_.set(key, word);
  return word;
}

std::string SpecReader::text(const std::string& key) {
  note(key, Kind::kText);
  read_.set(key, scalar(key));
  return scalar(key);
}

std::vector<std::string> SpecReader::names(const std::string& key) {
  note(key, Kind::kNames);
  if (!isList(key)) fail("key '" + key + "' must be a list, as [a, b]");
  read_.setList(key, spec_.find(key)->items);
  return spec_.find(key)->items;
}

std::vector<double> SpecReader::numbers(const std::string& key) {
  KeyRecorder::note({key, Kind::kNumbers, 0.0, 0.0, {}, "", false});
  const EffectSpec::Value* value = spec_.find(key);
  if (value == nullptr) return {};
  std::vector<double> out;
  std::vector<std::string> items;
  for (const std::string& item : value->items) {
    out.push_back(parse(key, item));
    items.push_back(shortest(out.back()));
  }
  read_.setList(key, items);
  return out;
}

}  // namespace mm
