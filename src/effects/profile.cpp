#include "effects/profile.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "base/error.h"
#include "base/nearest_name.h"
#include "effects/catalogue_effect.h"
#include "effects/formula_variables.h"
#include "effects/quantity.h"
#include "effects/smooth_basis.h"
#include "effects/touch.h"

namespace mm {
namespace {

constexpr int kFunctionsOfOne = 12,
              kMostOfOne = 32;  // bumps as narrow as a tenth of the range; a third of that
constexpr int kFunctionsOfTwo = 4, kMostOfTwo = 8;  // each: with the products 24 coefficients; 80
constexpr int kMostFunctions = 80;
constexpr double kRough = 0.5;  // smoothness of what changes within a few positions
constexpr double kSize = 20.0;  // um or arcsec: weak, larger than most that a machine errs
constexpr double kLeastSize = 1e-6, kMostSize = 1e6;  // um or arcsec

const std::vector<std::string>& profileKeys() {
  static const std::vector<std::string> keys{"direction",  "variable", "variables",  "functions",
                                             "smoothness", "size_um",  "size_arcsec"};
  return keys;
}

/// The law of a profile: sum of coefficients times functions of one variable, or of two: those of each, and
/// the products.
class ProfileLaw {
 public:
  struct Variable {
    int index = 0;  // of FormulaVariables
    std::string name, unit;
    double lower = 0.0, upper = 0.0;  // observed, unit of people
  };

  explicit ProfileLaw(SpecReader& read)
      : direction_(read.direction("direction", true)),
        variables_(read.domain()),
        chosen_(chosen(read)),
        basis_(chosen_.size() == 1 ? read.integer("functions", 1, kMostOfOne, kFunctionsOfOne)
                                   : read.integer("functions", 1, kMostOfTwo, kFunctionsOfTwo),
               read.number("smoothness", 0.5, 4.0, 2.0)) {
    const bool linear = direction_.quantity == JointKind::kLinear;
    const std::string key = linear ? "size_um" : "size_arcsec", other = linear ? "size_arcsec" : "size_um";
    if (read.has(other))
      read.fail("the size along " + direction_.name + " is given as " + key + ", not " + other);
    const double size = read.number(key, kLeastSize, kMostSize, kSize) * (linear ? kMicrometre : kArcsecond);
    for (const Variable& v : chosen_) indices_.push_back(v.index);
    const int n = basis_.size();
    for (std::size_t v = 0; v < chosen_.size(); ++v)
      for (int i = 0; i < n; ++i) add(letter(v) + std::to_string(i + 1), basis_.priorStd(i));
    if (chosen_.size() == 2)
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
          add(letter(0) + std::to_string(i + 1) + letter(1) + std::to_string(j + 1),
              basis_.priorStd(i) * basis_.priorStd(j));
    double square = 0.0;
    for (const Parameter& p : parameters_) square += p.priorStd * p.priorStd;
    for (Parameter& p : parameters_) {
      p.priorStd *= size / std::sqrt(square);
      p.scale = p.priorStd;
      p.bound = std::max(p.bound, 10.0 * p.priorStd);
    }
  }

  const Direction& direction() const { return direction_; }
  const std::vector<Variable>& variables() const { return chosen_; }
  const std::vector<Parameter>& parameters() const { return parameters_; }
  int count() const { return static_cast<int>(parameters_.size()); }
  FormulaVariables::Kind kind(const Variable& v) const { return variables_.kind(v.index); }
  int joint(const Variable& v) const { return variables_.joint(v.index); }
  /// Writes one value a variable, in the units of people.
  void inputs(const State& state, double* at) const { variables_.values(state, indices_, at); }

  /// Writes count() values. @param at the variables in the units of people.
  void functions(const double* at, double* out) const {
    const int n = basis_.size();
    for (std::size_t v = 0; v < chosen_.size(); ++v) {
      const double middle = 0.5 * (chosen_[v].lower + chosen_[v].upper);
      const double half = 0.5 * (chosen_[v].upper - chosen_[v].lower);
      basis_.values((at[v] - middle) / half, out + static_cast<int>(v) * n);
    }
    if (chosen_.size() == 1) return;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) out[(2 + i) * n + j] = out[i] * out[n + j];
  }

 private:
  static std::string letter(std::size_t variable) { return variable == 0 ? "a" : "b"; }

  std::vector<Variable> chosen(SpecReader& read) const {
    std::vector<std::string> names;
    if (read.has("variable") && read.has("variables"))
      read.fail("give either variable or variables: [a, b], not both");
    if (read.has("variables")) {
      names = read.names("variables");
      if (names.size() != 2 || names[0] == names[1])
        read.fail(
            "key 'variables' must be a list of two different ones, as [a, b]; for one write variable: a");
    } else {
      names = {read.text("variable")};
    }
    std::vector<Variable> found;
    for (const std::string& name : names) {
      const auto& known = variables_.names();
      const auto at = std::find(known.begin(), known.end(), name);
      if (at == known.end())
        read.fail("'" + name + "' is not a recorded variable; available: " + listOf(known) +
                  didYouMean(name, known));
      Variable v;
      v.index = static_cast<int>(at - known.begin());
      v.name = name;
      v.unit = variables_.unit(v.index);
      if (!variables_.observed(v.index, v.lower, v.upper))
        read.fail("'" + name +
                  "' was not recorded, or never changed; choose a variable that varies in the session");
      found.push_back(v);
    }
    return found;
  }

  /// @param weight its prior standard deviation beside the others'.
  void add(const std::string& name, double weight) {
    parameters_.push_back(errorParameter(name, direction_.quantity));
    parameters_.back().priorStd = weight;
  }

  Direction direction_;
  FormulaVariables variables_;
  std::vector<Variable> chosen_;
  std::vector<int> indices_;
  SmoothBasis basis_;
  std::vector<Parameter> parameters_;
};

/// A smooth curve with a band. Beyond the observed range it stays as at the end, and says that it is outside.
class Profile : public CatalogueEffect {
 public:
  explicit Profile(SpecReader& read) : Profile(read, ProfileLaw(read)) {}

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    double along[3] = {1.0, 0.0, 0.0};
    int slots = 1;
    const Direction& direction = law_.direction();
    if (direction.kind == Direction::Kind::kApproach) {
      slots = 3;
      const Touch touch = touchOf(state);
      if (touch == Touch::kNone) return;
      for (int k = 0; k < 3; ++k) along[k] = touch == Touch::kKnown ? state.approach[k] : kUnknown;
    }
    double at[2], functions[kMostFunctions];
    law_.inputs(state, at);
    law_.functions(at, functions);
    for (int s = 0; s < slots; ++s) {
      const int slot = slots == 1 ? direction.slot(layout_) : layout_.volume(s);
      for (int i = 0; i < law_.count(); ++i) sink.add(slot, i, p[i], functions[i] * along[s]);
    }
  }

  std::string outside(const State& state, double margin) const override {
    using Kind = FormulaVariables::Kind;
    double at[2];
    law_.inputs(state, at);
    for (std::size_t i = 0; i < law_.variables().size(); ++i) {
      const auto& v = law_.variables()[i];
      if (law_.kind(v) != Kind::kVelocity && law_.kind(v) != Kind::kReading)
        continue;  // judged for all effects alike
      const double wider = margin * (v.upper - v.lower);
      if (!(at[i] < v.lower - wider || at[i] > v.upper + wider)) continue;
      char text[160];
      std::snprintf(text, sizeof text,
                    " = %.7g %s is outside %.7g to %.7g %s, the calibrated range with its margin", at[i],
                    v.unit.c_str(), v.lower - wider, v.upper + wider, v.unit.c_str());
      return v.name + text;
    }
    return {};
  }

 private:
  Profile(SpecReader& read, ProfileLaw law) : CatalogueEffect(read, law.direction()), law_(std::move(law)) {
    parameters_ = law_.parameters();
    std::string& names = words_["names"];
    nature_.shapeKeys = {"functions", "smoothness", "size_um", "size_arcsec"};
    for (const auto& v : law_.variables()) {
      names += (names.empty() ? "" : " and ") + v.name;
      if (law_.kind(v) == FormulaVariables::Kind::kPosition) nature_.mustMove.push_back(law_.joint(v));
    }
  }

  ProfileLaw law_;
};

}  // namespace

EffectType profileType() {
  return effectType<Profile>("profile", profileKeys(), nullptr, false,
                             {profileSpec("x", {"x"}), profileSpec("b", {"x"}), profileSpec("x", {"x", "y"}),
                              profileSpec("b", {"x", "y"})});
}

EffectSpec profileSpec(const std::string& direction, const std::vector<std::string>& variables) {
  EffectSpec spec("profile");
  spec.set("direction", direction);
  if (variables.size() == 1)
    spec.set("variable", variables.front());
  else
    spec.setList("variables", variables);
  return spec;
}

EffectSpec roughProfileSpec(const std::string& direction, const std::string& variable) {
  return profileSpec(direction, {variable}).set("functions", kMostOfOne).set("smoothness", kRough);
}

EffectSpec sizedProfile(EffectSpec profile, double size, const Domain& domain) {
  if (!(size > 0.0)) return profile;
  const int joint = domain.findJoint(profile.text("direction"));
  const bool angular =
      joint >= 0 && domain.joints[static_cast<std::size_t>(joint)].kind == JointKind::kRotary;
  // Of a curve that is hardly there an estimate may be anything above zero.
  const double told = std::clamp(size / (angular ? kArcsecond : kMicrometre), kLeastSize, kMostSize);
  char text[32];  // two digits: it is the width of a prior
  std::snprintf(text, sizeof text, "%.1e", told);
  return profile.set(angular ? "size_arcsec" : "size_um", std::strtod(text, nullptr));
}

ProfileCurve profileCurve(const EffectSpec& spec, const Domain& domain, const Eigen::VectorXd& coefficients,
                          const Eigen::MatrixXd& covariance, int points) {
  SpecReader read(spec, domain, profileKeys());
  const ProfileLaw law(read);
  if (coefficients.size() != law.count() || covariance.rows() != law.count() ||
      covariance.cols() != law.count())
    throw InputError("the curve of " + spec.yaml() + " needs " + std::to_string(law.count()) +
                     " coefficients and their covariance, not " + std::to_string(coefficients.size()));
  ProfileCurve curve;
  for (const auto& v : law.variables()) curve.variables.push_back({v.name, v.unit, v.lower, v.upper});
  const Unit& unit = errorUnit(law.direction().quantity);
  curve.unit = unit.name;
  const bool two = curve.variables.size() == 2;
  const auto place = [&](std::size_t v, int k) {
    const auto& range = curve.variables[v];
    return range.lower + (range.upper - range.lower) * (points > 1 ? k / (points - 1.0) : 0.5);
  };
  Eigen::VectorXd functions(law.count());
  for (int i = 0; i < points; ++i)
    for (int j = 0; j < (two ? points : 1); ++j) {
      ProfileCurve::Point point;
      point.at = {place(0, i), two ? place(1, j) : 0.0};
      law.functions(point.at.data(), functions.data());
      point.value = functions.dot(coefficients) * unit.toUnit;
      point.std = std::sqrt(std::max(0.0, functions.dot(covariance * functions))) * unit.toUnit;
      curve.points.push_back(point);
    }
  return curve;
}

}  // namespace mm
