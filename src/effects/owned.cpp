#include "effects/owned.h"

#include "base/error.h"
#include "base/nearest_name.h"

namespace mm {
namespace {

const char* const kFromSession = "from_session";
const char* const kStylus = "stylus";

class OwnedEffect final : public Effect {
 public:
  OwnedEffect(EffectPtr law, Owner owner, const Domain& domain)
      : law_(std::move(law)),
        owner_(std::move(owner)),
        always_(domain.recordings == 1),
        stylus_(owner_.stylus.empty() ? -1 : domain.findStylus(owner_.stylus)) {
    spec_ = withOwner(law_->spec(), owner_);
    parameters_ = law_->parameters();
    nature_ = law_->nature();
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    // what is measured after all of the sessions is like the last of them
    if (!always_ && state.recording < owner_.fromSession - 1) return;
    if (stylus_ >= 0 && state.stylus != stylus_) return;
    law_->evaluate(state, p, sink);
  }
  const Effect& law() const override { return *law_; }
  std::string cause() const override {
    if (owner_.fromSession == 1) return law_->cause();
    return "Something changed before session " + std::to_string(owner_.fromSession) + ": " + law_->cause();
  }

  // What the law is, it is wherever it acts.
  double coefficient(int parameter, double value) const override {
    return law_->coefficient(parameter, value);
  }
  std::vector<ShapeFreedom> freedom(const Domain& domain) const override {
    std::vector<ShapeFreedom> all = law_->freedom(domain);
    for (ShapeFreedom& f : all) f.spec = withOwner(f.spec, owner_);
    return all;
  }
  EffectSpec shapedAs(const std::vector<double>& nonlinear) const override {
    return withOwner(law_->shapedAs(nonlinear), owner_);
  }
  std::vector<NonlinearFreedom> freedomBeside(const std::vector<double>& nonlinear) const override {
    return law_->freedomBeside(nonlinear);
  }
  bool mayBeClaimed(const std::vector<double>& nonlinear) const override {
    return law_->mayBeClaimed(nonlinear);
  }
  std::string looksTheSame(const std::vector<double>& nonlinear) const override {
    return law_->looksTheSame(nonlinear);
  }
  std::string outside(const State& state, double margin) const override {
    return law_->outside(state, margin);
  }
  std::string remedy() const override { return law_->remedy(); }
  std::string shownBy() const override { return law_->shownBy(); }

 private:
  const EffectPtr law_;
  const Owner owner_;
  const bool always_;  // this domain is of one session, which is none of those that are counted
  const int stylus_;
};

}  // namespace

Owner takeOwner(EffectSpec& spec) {
  Owner owner;
  const EffectSpec given = spec;
  spec.keys.clear();
  for (const auto& [key, value] : given.keys) {
    if (key != kFromSession && key != kStylus) {
      spec.keys.emplace_back(key, value);
      continue;
    }
    const std::string text = value.items.empty() ? "" : value.items.front();
    if (key == kStylus) {
      owner.stylus = text;
      continue;
    }
    const bool digits =
        !text.empty() && text.size() < 5 && text.find_first_not_of("0123456789") == std::string::npos;
    owner.fromSession = digits ? std::stoi(text) : 0;
    if (owner.fromSession < 1)
      throw InputError("effect " + given.yaml() + ": '" + kFromSession + "' is " + text +
                       ", but must be the number of a session, counted from 1");
  }
  return owner;
}

EffectSpec withOwner(EffectSpec spec, const Owner& owner) {
  if (owner.fromSession > 1) spec.set(kFromSession, owner.fromSession);
  if (!owner.stylus.empty()) spec.set(kStylus, owner.stylus);
  return spec;
}

EffectPtr ownedEffect(EffectPtr law, const Owner& owner, const Domain& domain) {
  const std::string what = "effect " + withOwner(law->spec(), owner).yaml() + ": ";
  if (law->nature().learned)
    throw InputError(what + "a network is learned of all sessions; leave '" + kFromSession + "' out");
  if (domain.recordings > 1 && owner.fromSession > domain.recordings)
    throw InputError(what + "'" + kFromSession + "' is " + std::to_string(owner.fromSession) +
                     ", but there are " + std::to_string(domain.recordings) + " sessions");
  if (!owner.stylus.empty() && domain.findStylus(owner.stylus) < 0)
    throw InputError(what + "'" + kStylus + "' is '" + owner.stylus + "', which the artifact does not name" +
                     didYouMean(owner.stylus, domain.styli) + "; known: " + listOf(domain.styli));
  return std::make_shared<OwnedEffect>(std::move(law), owner, domain);
}

}  // namespace mm
