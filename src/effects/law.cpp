#include "effects/law.h"

#include <memory>

namespace mm {
namespace {

/// An effect whose law is data.
class LawEffect final : public CatalogueEffect {
 public:
  LawEffect(const SpecReader& read, Law law) : CatalogueEffect(read, law.nature.stage), law_(std::move(law)) {
    nature_ = law_.nature;
    parameters_ = law_.parameters;
    if (!law_.variant.empty()) variant_ = law_.variant;
    words_ = law_.words;
    if (law_.starts.empty()) return;
    nature_.linear = false;
    nature_.nonlinear = {parameterCount() - 1};
    for (const double start : law_.starts) nature_.searchStarts.push_back({start});
  }
  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    law_.add(state, p, sink);
  }
  double coefficient(int parameter, double value) const override {
    return law_.coefficient ? law_.coefficient(parameter, value) : value;
  }
  bool mayBeClaimed(const std::vector<double>& nonlinear) const override {
    return nonlinear.empty() || (nonlinear.front() >= law_.shortest && nonlinear.front() <= law_.longest);
  }
  std::vector<NonlinearFreedom> freedomBeside(const std::vector<double>& nonlinear) const override {
    std::vector<NonlinearFreedom> all;
    for (const auto& [factor, share] : law_.beside)
      if (!nonlinear.empty()) all.push_back({{factor * nonlinear.front()}, share});
    return all;
  }
  std::vector<ShapeFreedom> freedom(const Domain&) const override { return law_.freedom; }

 private:
  const Law law_;
};

}  // namespace

EffectType lawType(LawRow row) {
  EffectType type;
  type.type = row.type;
  type.keys = row.keys;
  type.create = [keys = row.keys, law = row.law](const EffectSpec& spec, const Domain& domain) -> EffectPtr {
    SpecReader read(spec, domain, keys);
    auto effect = std::make_shared<LawEffect>(read, law(read));
    effect->adopt(read.canonical());
    return effect;
  };
  type.examples = row.examples;
  type.composite = !row.examples.empty();
  type.valueOfEachPosition = row.valueOfEachPosition;
  type.candidates = [](const Domain&) { return std::vector<EffectSpec>(); };
  if (type.composite) return type;
  type.members = [name = row.type, values = row.values](const Domain& domain) {
    std::vector<EffectSpec> members = {EffectSpec(name)};
    for (const Values& key : values) {
      std::vector<EffectSpec> more;
      const Values::List of = key.of(domain);
      for (const EffectSpec& member : members)
        for (const EffectSpec::Value& value : of) {
          more.push_back(member);
          if (!value.items.front().empty()) more.back().keys.emplace_back(key.key, value);
        }
      members = std::move(more);
    }
    return members;
  };
  type.candidates = [members = type.members, where = row.where](const Domain& domain) {
    std::vector<EffectSpec> sensible;
    for (EffectSpec& member : members(domain))
      if (!where || where(member, domain)) sensible.push_back(std::move(member));
    return sensible;
  };
  return type;
}

LawRow compositeRow(std::vector<std::string> keys, std::function<Law(SpecReader&)> law,
                    std::vector<EffectSpec> examples) {
  const std::string type = examples.front().type;
  return {type, std::move(keys), {}, {}, std::move(law), std::move(examples)};
}

Values named(const std::string& key, std::function<std::vector<std::string>(const Domain&)> of) {
  return {key, [of = std::move(of)](const Domain& domain) {
            Values::List list;
            for (const std::string& name : of(domain)) list.push_back({{name}, false});
            return list;
          }};
}
Values fixed(const std::string& key, std::vector<std::string> values) {
  return named(key, [values = std::move(values)](const Domain&) { return values; });
}
Values numbers(const std::string& key, int lowest, int highest, int absent) {
  std::vector<std::string> values;
  for (int n = lowest; n <= highest; ++n) values.push_back(n == absent ? "" : std::to_string(n));
  return fixed(key, std::move(values));
}
Values joints(const std::string& key) {
  return named(key, [](const Domain& domain) { return jointNames(domain); });
}
Values joints(const std::string& key, JointKind kind) {
  return named(key, [kind](const Domain& domain) { return jointNames(domain, kind); });
}
Values directions() { return named("direction", directionNames); }
Values sensors() {
  return named("sensor", [](const Domain& domain) { return domain.sensors; });
}
Values covariates() {
  return named("covariate", [](const Domain& domain) { return domain.covariates; });
}

}  // namespace mm
