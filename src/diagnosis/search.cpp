#include "diagnosis/search.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/cancel_scope.h"
#include "diagnosis/shape_maker.h"

namespace mm {
namespace {

constexpr double kFiner = 1e-3;  // nats that a step of a nonlinear parameter must bring

}  // namespace

std::shared_ptr<const Evidence> Search::evidenceAt(const Explanation& at,
                                                   const std::vector<char>* heldOut) const {
  const auto sameDrift = [](const std::vector<DriftTerm>& a, const std::vector<DriftTerm>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const DriftTerm& s, const DriftTerm& t) {
      return s.direction == t.direction && s.ratio == t.ratio && s.tau == t.tau && s.smooth == t.smooth;
    });
  };
  if (heldOut == nullptr)
    for (const Known& k : known_)
      if (k.scatter == at.scatter && sameDrift(k.noise.drift, at.noise.drift) &&
          k.noise.variance == at.noise.variance)
        return k.evidence;
  auto evidence =
      std::make_shared<const Evidence>(q_.rows, q_.groups, at.noise, q_.scatter, at.scatter, heldOut);
  if (heldOut != nullptr) return evidence;
  constexpr std::size_t kKept = 3;
  if (known_.size() == kKept) known_.erase(known_.begin());
  known_.push_back({at.noise, at.scatter, evidence});
  return evidence;
}

std::vector<RandomBlock> Search::blocksOf(const std::vector<Member>& members,
                                          const std::vector<double>& scatter,
                                          std::vector<int>& ofBlock) const {
  std::vector<RandomBlock> blocks;
  for (std::size_t b = 0; b < q_.scatter.size(); ++b)
    if (scatter[b] > 0.0) {
      blocks.push_back(q_.scatter[b]);
      if (!blocks.back().fixed) blocks.back().ratio = scatter[b];
      ofBlock.push_back(static_cast<int>(b));
    }
  for (const Member& m : members) blocks.push_back({*m.columns, m.size, 0.0, false});
  return blocks;
}

double Search::whiteStdOf(const Explanation& found) const {
  std::vector<int> ofBlock;
  const NoiseFit fit(q_.rows, blocksOf(found.members, found.scatter, ofBlock));
  NoiseFitResult at;
  at.noise = found.noise;
  for (const int b : ofBlock) at.ratios.push_back(found.scatter[static_cast<std::size_t>(b)]);
  for (const Member& m : found.members) at.ratios.push_back(m.size);
  at.white = found.white;
  at.whiteStd = found.whiteStd;
  at.freedoms = std::max<double>(1.0, q_.rows.length() - static_cast<double>(q_.rows.base.cols()));
  return fit.whiteStdOf(at, {});
}

Explanation Search::refitted(const std::vector<Member>& members, const Explanation& start) const {
  CancelScope::check();
  Explanation out;
  out.members = members;
  std::vector<int> ofBlock;
  std::vector<RandomBlock> blocks = blocksOf(members, start.scatter, ofBlock);
  const std::size_t scatter = ofBlock.size();
  NoiseFitOptions options;
  options.addDrift = false;
  const NoiseFitResult fit = NoiseFit(q_.rows, std::move(blocks)).run(start.noise, options);
  out.noise = fit.noise;
  out.scatter.assign(q_.scatter.size(), 0.0);
  for (std::size_t k = 0; k < scatter; ++k) out.scatter[ofBlock[k]] = fit.ratios[k];
  for (std::size_t k = 0; k < members.size(); ++k)
    out.members[k].size = std::max(kSmallestSize, fit.ratios[scatter + k]);
  out.logEvidence = fit.logEvidence;
  out.white = fit.white;
  out.whiteStd = fit.whiteStd;
  return out;
}

Member Search::memberOf(const Gain& gain) const {
  const Shape& shape = q_.groups.groups[gain.group].shapes[gain.shape];
  Member m;
  m.group = gain.group;
  m.shape = gain.shape;
  m.nonlinear = shape.nonlinear;
  takeSize(m, gain);
  m.columns = std::make_shared<RowMatrix>(q_.groups.columns.middleCols(shape.first, shape.count));
  return m;
}

void Search::takeSize(Member& member, const Gain& gain) { member.size = std::max(kSmallestSize, gain.size); }

Member Search::refined(const Evidence& evidence, const std::vector<Member>& others,
                       const Member& member) const {
  Member best = member;
  const Shape& shape = q_.groups.groups[member.group].shapes[member.shape];
  const Evidence::Given given = evidence.given(others);
  if (member.nonlinear.empty()) {
    takeSize(best, evidence.gainOf(given, *member.columns));
    return best;
  }
  const GroupColumns make(*q_.space);
  const std::vector<int> parameters = shape.effect->nature().nonlinear;
  double most = evidence.gainOf(given, *member.columns).value;
  std::vector<double> steps = {0.03, 0.01, 0.003, 0.001, 0.0003};
  if (!shape.effect->nature().fineWaves.lengths.empty())
    steps.insert(steps.end(), {1e-4, 3e-5});  // of many waves
  for (std::size_t k = 0; k < best.nonlinear.size(); ++k)
    for (const double step : steps)
      for (const double sign : {1.0, -1.0})
        for (int again = 0; again < 6; ++again) {
          std::vector<double> at = best.nonlinear;
          at[k] *= 1.0 + sign * step;
          const Parameter& limits = shape.effect->parameters()[static_cast<std::size_t>(parameters[k])];
          if (at[k] < limits.minimum || at[k] > limits.maximum || !shape.effect->mayBeClaimed(at)) break;
          RowMatrix columns = make(shape.effect, at);
          if (columns.cols() == 0) break;
          if (shape.count == shape.main) columns = columns.leftCols(shape.main).eval();
          const Gain gain = evidence.gainOf(given, columns);
          if (!(gain.value > most + kFiner)) break;
          most = gain.value;
          best.nonlinear = at;
          takeSize(best, gain);
          best.columns = std::make_shared<RowMatrix>(std::move(columns));
        }
  return best;
}

std::vector<Member> Search::beside(const Evidence& evidence, const std::vector<Member>& members,
                                   std::size_t j) const {
  const auto isCurve = [&](const Member& m) { return q_.groups.groups[m.group].profile; };
  std::vector<Member> others;
  for (std::size_t p = 0; p < members.size(); ++p) {
    if (p == j) continue;
    if (isCurve(members[p]) && !isCurve(members[j])) {
      std::vector<Member> rest;
      for (std::size_t k = 0; k < members.size(); ++k)
        if (k != j && k != p) rest.push_back(members[k]);
      const Evidence::Given given = evidence.given(rest);
      const auto explained = [&](const Member& m) {
        return -std::expm1(-2.0 * evidence.gainOf(given, *m.columns).value / given.freedoms);
      };
      if (explained(members[j]) > kMostOfIt * explained(members[p])) continue;
    }
    others.push_back(members[p]);
  }
  return others;
}

bool Search::hasCurve(const Evidence& evidence, const std::vector<Member>& members, std::size_t j) const {
  return beside(evidence, members, j).size() + 1 < members.size();
}

}  // namespace mm
