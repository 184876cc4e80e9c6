#pragma once
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "effects/catalogue_effect.h"

namespace mm {

/// A law of the catalogue as data: its unknown constants, what they add where, and what a diagnosis must know
/// of it (see Nature and Effect). Its words stand in words.yaml.
struct Law {
  Nature nature;
  std::vector<Parameter> parameters;
  std::function<void(const State&, const double* p, ErrorSink&)> add;  // see Effect::evaluate
  std::function<double(int parameter, double value)> coefficient;  // see Nature::separable; empty: the value
  /// Start values of the last parameter, which then is not linear (a time constant); empty: all are linear.
  std::vector<double> starts;
  double shortest = 0.0, longest = kUnbounded;    // of that parameter, to be told from a smooth profile
  std::vector<std::pair<double, double>> beside;  // shapes beside: factor of that parameter, share
  std::vector<ShapeFreedom> freedom;
  std::string variant;                       // of its words
  std::map<std::string, std::string> words;  // that words.yaml may name beside the keys

  static constexpr double kUnbounded = std::numeric_limits<double>::infinity();
};

/// The values that one key has in the members of a family; an empty one leaves the key out.
struct Values {
  using List = std::vector<EffectSpec::Value>;
  std::string key;
  std::function<List(const Domain&)> of;  ///< that it has in this domain
};

/// One row of the catalogue.
struct LawRow {
  std::string type;
  std::vector<std::string> keys;  // in the order of the canonical form
  /// The members of the family that a diagnosis tries: all combinations, the first key outermost …
  std::vector<Values> values;
  std::function<bool(const EffectSpec&, const Domain&)> where;  // … for which this holds; empty: all
  std::function<Law(SpecReader&)> law;
  std::vector<EffectSpec> examples = {};  ///< of a composite, for the catalogue; empty: a diagnosis tries it
  bool valueOfEachPosition = false;       ///< see EffectType
};

/// The row of what no diagnosis tries. @param examples at least one.
LawRow compositeRow(std::vector<std::string> keys, std::function<Law(SpecReader&)> law,
                    std::vector<EffectSpec> examples);

/// The type of effect that a row describes.
EffectType lawType(LawRow row);

// Values of keys.
/// @param of names, by the domain.
Values named(const std::string& key, std::function<std::vector<std::string>(const Domain&)> of);
Values fixed(const std::string& key, std::vector<std::string> values);  ///< whatever the domain
/// Whole numbers. @param absent the one that is meant where the key is left out.
Values numbers(const std::string& key, int lowest, int highest, int absent = 0);
Values joints(const std::string& key);                  ///< all of them
Values joints(const std::string& key, JointKind kind);  ///< of one kind
Values directions();                                    ///< of the key `direction`
Values sensors();                                       ///< of the key `sensor`
Values covariates();                                    ///< of the key `covariate`

/// A law of one parameter that adds to one slot.
/// @param basis of the state, by which the parameter is multiplied.
template <typename Basis>
Law oneTerm(Stage stage, int slot, Parameter parameter, Basis basis) {
  Law law;
  law.nature.stage = stage;
  law.parameters = {std::move(parameter)};
  law.add = [slot, basis](const State& s, const double* p, ErrorSink& sink) {
    sink.add(slot, 0, p[0], basis(s));
  };
  return law;
}

/// The rows of the catalogue, by what they are about.
std::vector<LawRow> lawsOfAxes();
std::vector<LawRow> lawsOfTemperature();
std::vector<LawRow> lawsOfTime();
std::vector<LawRow> lawsOfContact();
std::vector<LawRow> lawsOfRotaryAxes();
std::vector<LawRow> lawsOfTables();
std::vector<LawRow> lawsOfPapers();

}  // namespace mm
