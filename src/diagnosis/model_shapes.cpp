#include "diagnosis/model_shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "diagnosis/answers.h"
#include "diagnosis/posterior_search.h"
#include "diagnosis/shape_maker.h"
#include "effects/inputs.h"
#include "effects/linearity.h"
#include "effects/registry.h"
#include "posterior/slots.h"

namespace mm {
namespace {

constexpr double kNothing = 0.05;     // of the noise, root mean square: less is not worth its columns
constexpr double kWorthSaying = 0.5;  // of the noise: less is not seen beside it
constexpr std::size_t kMostTold = 3;  // alternatives

/// A play that changes is followed by these; the model's own constant part stays.
EffectSpec formulaOver(const std::string& joint) {
  return EffectSpec("formula")
      .set("direction", joint)
      .set("formula", "k1*" + joint + "*" + joint + "_travel + k2*" + joint + "^2*" + joint + "_travel");
}

/// The shapes of one effect of the model.
class ShapesOf {
 public:
  ShapesOf(const ResidualSpace& space, int number)
      : space_(space),
        model_(space.problem().model()),
        effect_(*model_.effects()[static_cast<std::size_t>(number)]),
        number_(number) {
    for (int k = 0; k < effect_.parameterCount(); ++k)
      p_.push_back(space.fitted().x[model_.offset(number) + k]);
    for (const int k : linearParameters(effect_))
      size_ = std::max(size_, std::abs(p_[static_cast<std::size_t>(k)]) /
                                  effect_.parameters()[static_cast<std::size_t>(k)].scale);
  }

  std::vector<ModelShape> all() {
    if (!(size_ > 0.0)) return {};
    for (const ShapeFreedom& f : effect_.freedom(model_.domain())) {
      if (inModel(model_, f.spec)) continue;
      const EffectPtr other = createEffect(f.spec, model_.domain());
      // in the units of this effect's parameters, so that a share is a share
      add(linearColumns(*other, space_.columns(*other, startsAt(*other, {}))), f.share, "", f.spec);
    }
    const std::vector<int> nonlinear = effect_.nature().nonlinear;
    std::vector<double> now;
    for (const int k : nonlinear) now.push_back(p_[static_cast<std::size_t>(k)]);
    for (const Effect::NonlinearFreedom& f : effect_.freedomBeside(now)) {
      std::vector<double> at = p_;
      for (std::size_t k = 0; k < nonlinear.size(); ++k)
        at[static_cast<std::size_t>(nonlinear[k])] = f.nonlinear[k];
      add(linearColumns(effect_, space_.columns(effect_, at)), f.share, "", effect_.shapedAs(f.nonlinear));
    }
    for (const int joint : effect_.nature().variesAlong) changesAlong(joint);
    if (effect_.nature().variesInTime) changesInTime();
    return std::move(shapes_);
  }

 private:
  /// Along the joint it grows, is larger in the middle, or where the machine works most.
  void changesAlong(int joint) {
    const RowMatrix one = linearColumns(effect_, space_.columns(effect_, p_));
    const RowMatrix curve = curveAlong(space_.problem(), space_.used(), joint, one);
    const std::string& name = model_.domain().joints[static_cast<std::size_t>(joint)].name;
    const std::vector<int> travels = inputsOf(effect_, model_.domain()).travels;
    const bool play = std::find(travels.begin(), travels.end(), joint) != travels.end();
    add(curve, kVariation, name, play ? formulaOver(name) : EffectSpec());
  }

  void changesInTime() {
    RowMatrix varied = linearColumns(effect_, space_.columns(effect_, p_));
    varyInTime(space_.problem(), space_.used(), varied);
    const std::vector<int> travels = inputsOf(effect_, model_.domain()).travels;
    EffectSpec follows;
    if (!travels.empty()) {
      const std::string& name = model_.domain().joints[static_cast<std::size_t>(travels.front())].name;
      follows = EffectSpec("formula").set("direction", name).set("formula", "k1*t*" + name + "_travel");
    }
    add(varied, kVariation, kTime, follows);
  }

  void add(const Eigen::MatrixXd& columns, double share, const std::string& along, EffectSpec follows) {
    Eigen::MatrixXd seen = columns;
    space_.project(seen);
    if (!(share * size_ * seen.norm() > kNothing * std::sqrt(static_cast<double>(space_.rows())))) return;
    if (!follows.type.empty() && inModel(model_, follows)) follows = EffectSpec();
    shapes_.push_back({number_, along, std::move(follows), {RowMatrix(columns), share * size_, 0.0, true}});
  }

  const ResidualSpace& space_;
  const Model& model_;
  const Effect& effect_;
  int number_;
  std::vector<double> p_;
  double size_ = 0.0;  // of the fitted values, in units of the parameters' scale
  std::vector<ModelShape> shapes_;
};

/// Of a unit root mean square after what the model's unknowns absorb, as the columns of causes are.
RowMatrix ofUnitSize(const ResidualSpace& space, const RowMatrix& columns) {
  const double left = space.leftOf(columns).maxCoeff();
  return columns * (left > 0.0 ? std::sqrt(static_cast<double>(std::max(1, space.rows()))) / left : 0.0);
}

/// Asks what the shapes of one effect explain, beside the members and the shapes of the other effects.
class Beside {
 public:
  Beside(const Search& search, const Explanation& bare)
      : q_(search.questions()),
        members_(bare.members),
        evidence_(search.evidenceAt(bare)),
        given_(evidence_->given(members_)) {}

  double gainOf(const RowMatrix& columns) const { return evidence_->gainOf(given_, columns).value; }

  /// Root mean square of what they take, of the noise of 1.
  double rmsOf(const RowMatrix& columns) const {
    std::vector<Member> members = members_;
    members.emplace_back();
    members.back().columns = std::make_shared<RowMatrix>(columns);
    members.back().size = evidence_->gainOf(given_, columns).size;
    return projectedRms(*q_.space, columns, evidence_->fit(members).values.back());
  }

  /// Causes that do as well, likeliest first. @param worth nats of what they stand beside.
  std::vector<Alternative> alternatives(const std::vector<CandidateResult>& causes, const EffectSpec& follows,
                                        double worth) const {
    const Domain& domain = q_.space->problem().model().domain();
    const GroupColumns make(*q_.space);
    std::vector<Alternative> all;
    double sum = 1.0;  // of the weights, that of the shape among them
    for (const CandidateResult& cause : causes) {
      if (cause.effect == follows || inModel(q_.space->problem().model(), cause.effect)) continue;
      const RowMatrix columns = make(createEffect(cause.effect, domain), {});
      if (columns.cols() == 0) continue;
      const double more = gainOf(columns) - worth;
      if (more < -kIndistinct) continue;
      all.push_back({cause.effect, std::exp(std::min(kMostNats, more))});
      sum += all.back().probability;
    }
    for (Alternative& a : all) a.probability /= sum;
    std::stable_sort(all.begin(), all.end(),
                     [](const auto& a, const auto& b) { return a.probability > b.probability; });
    if (all.size() > kMostTold) all.resize(kMostTold);
    return all;
  }

 private:
  const Questions& q_;
  std::vector<Member> members_;
  std::shared_ptr<const Evidence> evidence_;
  Evidence::Given given_;
};

}  // namespace

std::vector<ModelShape> shapesOfTheModel(const ResidualSpace& space) {
  std::vector<ModelShape> shapes;
  for (int e = 0; e < static_cast<int>(space.problem().model().effects().size()); ++e)
    for (ModelShape& s : ShapesOf(space, e).all()) shapes.push_back(std::move(s));
  return shapes;
}

std::vector<Variation> variationsOf(const Search& search, const Explanation& found,
                                    const std::vector<CandidateResult>& causes, double noise, double least) {
  const ResidualSpace& space = *search.questions().space;
  const std::vector<ModelShape> shapes = shapesOfTheModel(space);  // the first of what scatters
  std::vector<Variation> out;
  for (std::size_t first = 0, end = 0; first < shapes.size(); first = end) {
    Explanation bare = found;
    for (end = first; end < shapes.size() && shapes[end].effect == shapes[first].effect; ++end)
      bare.scatter[end] = 0.0;
    const Beside asked(search, bare);
    std::size_t best = first;
    double worth = -kMostNats;
    for (std::size_t s = first; s < end; ++s)
      if (const double gain = asked.gainOf(ofUnitSize(space, shapes[s].block.columns)); gain > worth)
        worth = gain, best = s;
    const RowMatrix columns = ofUnitSize(space, shapes[best].block.columns);
    const double rms = unitOf(space) * asked.rmsOf(columns);
    if (!(1.0 / (1.0 + std::exp(-worth)) >= kNamed) || !(rms > kWorthSaying * least)) continue;
    const EffectSpec& effect =
        space.problem().model().effects()[static_cast<std::size_t>(shapes[best].effect)]->spec();
    out.push_back({effect, shapes[best].along, rms, noise / std::sqrt(static_cast<double>(space.rows())),
                   shapes[best].follows, asked.alternatives(causes, shapes[best].follows, worth)});
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Variation& a, const Variation& b) { return a.rms > b.rms; });
  return out;
}

}  // namespace mm
