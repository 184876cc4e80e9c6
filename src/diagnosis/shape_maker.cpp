#include "diagnosis/shape_maker.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "diagnosis/unknown_inputs.h"
#include "effects/linearity.h"
#include "effects/registry.h"
#include "effects/smooth_basis.h"

namespace mm {
namespace {

/// Less than this share of a column is left by the model's unknowns: it is rounding, or would have to be
/// enormous.
constexpr double kSeen = 1e-3;
/// Of the largest column of an effect, less is rounding: both phases of a cycle whose period divides the time
/// between two readings, of which one is nothing and the other constant.
constexpr double kOfLargest = 1e-9;
/// Of a wave, either phase: where less is left, its nodes are at the places of the session, or the other
/// unknowns absorb it there (places at equal distances, and a period that divides them), and it would have to
/// be large to be seen at all.
constexpr double kWaveSeen = 0.2;
constexpr double kMostOfOne =
    1.0 / 3.0;                   // of what is left of a shape: more in one observation may be a bad reading
constexpr double kMoved = 1e-9;  // m or rad: less is the rounding of a reading
constexpr double kDistinct = 1e-4;  // of a joint's range: positions further apart are two
constexpr double kUsualOfBound =
    0.1;                          // of the largest plausible size: what is met, where nothing else is known
constexpr int kMostMissing = 10;  // an input may be unknown in one of so many rows

constexpr int kCurveAlong = 8;       // functions of the curve by which a size changes along a joint
constexpr double kAsALine = 0.5;     // RMS of its functions; a line from -1 to 1 has 0.58, a parabola 0.45
constexpr double kSmoothness = 1.0;  // of that curve (SmoothBasis): wear is local

/// Of a joint in a row, -1 to 1 over what the session covers of it; 0: it never moved.
double scaledPosition(const Problem& problem, int row, int joint) {
  const Domain& domain = problem.model().domain();
  const double lower = domain.lower[joint], upper = domain.upper[joint];
  const double q = problem.state(problem.rows()[row].observation).position[joint];
  return upper > lower ? (2.0 * q - upper - lower) / (upper - lower) : 0.0;
}

const Parameter& firstLinear(const Effect& effect) {
  return effect.parameters()[static_cast<std::size_t>(linearParameters(effect).front())];
}

}  // namespace

std::vector<int> positionNumbers(const Problem& problem, int joint) {
  std::vector<std::pair<double, std::size_t>> q;
  for (std::size_t o = 0; o < problem.session().observations.size(); ++o)
    q.emplace_back(problem.state(static_cast<int>(o)).position[joint], o);
  std::sort(q.begin(), q.end());
  const double apart = kDistinct * std::max(q.back().first - q.front().first, kMoved);
  std::vector<int> numbers(q.size());
  int number = 0;
  for (std::size_t i = 0; i < q.size(); ++i) {
    if (i > 0 && q[i].first - q[i - 1].first > apart) ++number;
    numbers[q[i].second] = number;
  }
  return numbers;
}

int distinctPositions(const Problem& problem, int joint) {
  const std::vector<int> numbers = positionNumbers(problem, joint);
  return 1 + *std::max_element(numbers.begin(), numbers.end());
}

std::string ShapeMaker::notTried(const Effect& effect) const {
  for (const int joint : effect.nature().mustMove)
    if (!(domain_.upper[joint] - domain_.lower[joint] > kMoved))
      return domain_.joints[joint].name + " never moved";
  if (effect.nature().positionsNeeded > 0)
    for (const int joint : effect.nature().mustMove)
      if (distinctPositions(problem_, joint) < effect.nature().positionsNeeded)
        return "too few distinct positions of " + domain_.joints[joint].name + " to determine a period";
  return "";
}

DraftShape ShapeMaker::draft(const EffectPtr& effect, const std::vector<double>& nonlinear,
                             SizeAlong along) const {
  DraftShape d;
  d.shape.spec = effect->spec();
  d.shape.effect = effect;
  d.shape.nonlinear = nonlinear;
  std::vector<RowMatrix> columns;
  int count = 0;
  const auto take = [&](RowMatrix part, double share) {
    d.parts.push_back({count, static_cast<int>(part.cols()), share});
    count += static_cast<int>(part.cols());
    columns.push_back(std::move(part));
  };
  take(columnsOf(*effect, nonlinear, d.why), 1.0);
  if (!d.why.empty()) return d;
  const auto beside = [&](const Effect& other, const std::vector<double>& at, double share) {
    std::string why;
    RowMatrix part = columnsOf(other, at, why);
    if (why.empty()) take(std::move(part), share);
  };
  for (const ShapeFreedom& f : effect->freedom(domain_)) {  // another cause is asked by itself (Group::parts)
    const EffectPtr other = createEffect(f.spec, domain_);
    if (causeOf(*other) == causeOf(*effect)) beside(*other, {}, f.share);
  }
  for (const Effect::NonlinearFreedom& f : effect->freedomBeside(nonlinear))
    beside(*effect, f.nonlinear, f.share);
  for (const int joint : effect->nature().variesAlong) {
    if (along == SizeAlong::kAsACurve) {
      take(curveAlong(problem_, space_.used(), joint, columns.front()), kVariation);
      continue;
    }
    RowMatrix varied = columns.front();
    varyAlong(problem_, space_.used(), joint, varied);
    RowMatrix most = varied;  // Legendre's polynomial of degree 2: a nut works most in the middle
    varyAlong(problem_, space_.used(), joint, most);
    take(std::move(varied), kVariation);
    if (nonlinear.empty()) take(3.0 / 2.0 * most - 1.0 / 2.0 * columns.front(), kVariation);
  }
  if (effect->nature().variesInTime && along != SizeAlong::kAsACurve) {
    RowMatrix varied = columns.front();
    varyInTime(problem_, space_.used(), varied);
    take(std::move(varied), kVariation);
  }
  d.raw.resize(space_.length(), count);
  for (std::size_t k = 0; k < columns.size(); ++k)
    d.raw.middleCols(d.parts[k].first, d.parts[k].count) = columns[k];
  return d;
}

/// @param left norm of what the model's unknowns leave, a column of the draft.
MadeShape ShapeMaker::finish(const DraftShape& draft, const Eigen::VectorXd& left) const {
  MadeShape made;
  made.shape = draft.shape;
  made.columns.resize(space_.length(), draft.raw.cols());
  Eigen::VectorXd after(draft.raw.cols());  // left of the columns as they are kept
  int at = 0;
  for (const DraftShape::Part& part : draft.parts) {
    const auto raw = draft.raw.middleCols(part.first, part.count);
    const Eigen::VectorXd rest = left.segment(part.first, part.count);
    const double scale = scaleOf(raw, rest, made.why);
    if (!made.why.empty()) {
      if (at == 0) return made;
      made.why.clear();
      continue;
    }
    if (at == 0) {
      const Parameter& first = firstLinear(*draft.shape.effect);
      made.shape.seldomNegative = first.seldomNegative;
      const double usual = std::isfinite(first.usual) ? first.usual : kUsualOfBound * first.bound;
      made.shape.usual = usual / first.scale / scale;
    }
    made.columns.middleCols(at, part.count) = part.share * scale * raw;
    after.segment(at, part.count) = part.share * scale * rest;
    at += part.count;
  }
  made.columns.conservativeResize(Eigen::NoChange, at);
  made.shape.count = at;
  made.shape.main = draft.parts.front().count;
  weightByPriors(*draft.shape.effect, after.head(at), made);
  return made;
}

/// Whether both phases of a wave show. @param raw sine and cosine. @param sine, cosine, both norms of what is
/// left of them and of their sum.
bool ShapeMaker::isSeen(const Eigen::Ref<const RowMatrix, 0, Eigen::OuterStride<>>& raw, double sine,
                        double cosine, double both) {
  const double product = 0.5 * (both * both - sine * sine - cosine * cosine);
  const double mean = 0.5 * (sine * sine + cosine * cosine);
  const double least = mean - std::hypot(0.5 * (sine * sine - cosine * cosine), product);
  return least > kWaveSeen * kWaveSeen * 0.5 * raw.squaredNorm();
}

std::vector<MadeShape> ShapeMaker::finished(const std::vector<DraftShape>& drafts) const {
  const auto isWave = [](const DraftShape& d) {
    return d.why.empty() && d.parts.front().count == 2 && d.shape.effect->nature().fineWaves.joint >= 0;
  };
  int columns = 0;
  for (const DraftShape& d : drafts) columns += static_cast<int>(d.raw.cols()) + (isWave(d) ? 1 : 0);
  RowMatrix together(space_.length(), columns);
  int at = 0;
  for (const DraftShape& d : drafts) {
    if (d.raw.cols() > 0) together.middleCols(at, d.raw.cols()) = d.raw;
    at += static_cast<int>(d.raw.cols());
    if (isWave(d)) together.col(at++) = d.raw.col(0) + d.raw.col(1);
  }
  const Eigen::VectorXd left = space_.leftOf(together);
  std::vector<MadeShape> made(drafts.size());
  at = 0;
  for (std::size_t i = 0; i < drafts.size(); ++i) {
    const int count = static_cast<int>(drafts[i].raw.cols());
    if (drafts[i].why.empty())
      made[i] = finish(drafts[i], left.segment(at, count));
    else
      made[i].why = drafts[i].why;
    if (made[i].why.empty() &&
        space_.mostInOneObservation(drafts[i].raw.leftCols(drafts[i].parts.front().count)) > kMostOfOne)
      made[i].why = "only one observation would show it, and that may be a bad reading";
    if (isWave(drafts[i])) {
      if (made[i].why.empty() && !isSeen(drafts[i].raw.leftCols(2), left[at], left[at + 1], left[at + count]))
        made[i].why = "it is zero at the positions of this session, or the other unknowns absorb it";
      at += 1;
    }
    at += count;
  }
  return made;
}

/// Columns of the linear parameters, whitened. @param why not empty on return: an input is missing.
RowMatrix ShapeMaker::columnsOf(const Effect& effect, const std::vector<double>& nonlinear,
                                std::string& why) const {
  int missing = 0;
  const Eigen::MatrixXd all = space_.columns(effect, startsAt(effect, nonlinear), &missing);
  if (kMostMissing * missing > space_.rows()) {
    why = unknownInput(effect, space_.problem());
    if (why.empty())
      why = "its value is not a number for " + std::to_string(missing) + " of " +
            std::to_string(space_.rows()) + " residuals";
    return {};
  }
  RowMatrix columns = linearColumns(effect, all);
  if (settlesAtOnce(effect, nonlinear, columns)) why = "it settles before there are readings that show it";
  return columns;
}

/// Whether a process of this time constant is over so soon that hardly a reading differs from what it comes
/// to.
bool ShapeMaker::settlesAtOnce(const Effect& effect, const std::vector<double>& nonlinear,
                               const RowMatrix& columns) const {
  constexpr double kReadings = 3.0;  // that it is not there yet, added up: a mean of fewer says little
  const std::vector<int>& at = effect.nature().nonlinear;
  if (at.size() != 1 || nonlinear.empty()) return false;
  const Parameter& constant = effect.parameters()[static_cast<std::size_t>(at.front())];
  if (constant.unit != "s" || constant.minimum != 0.0) return false;
  const RowMatrix settled = linearColumns(effect, space_.columns(effect, startsAt(effect, {0.0}), nullptr));
  double missing = 0.0;
  for (int i = 0; i < space_.rows(); ++i)
    if (const double whole = settled.row(i).norm(); whole > 0.0)
      missing += (settled.row(i) - columns.row(i)).norm() / whole;
  return missing < kReadings && settled.topRows(space_.rows()).norm() > 0.0;
}

/// What gives the largest column a unit root mean square after projection; the others keep their
/// proportion: two phases of a wave have one size. @param why not empty on return: nothing of it is seen.
double ShapeMaker::scaleOf(const Eigen::Ref<const RowMatrix, 0, Eigen::OuterStride<>>& raw,
                           const Eigen::VectorXd& left, std::string& why) const {
  const Eigen::VectorXd norms = raw.colwise().norm();
  if (!(norms.norm() > 0.0)) {
    why = "nothing in this session excites it";
    return 0.0;
  }
  double largest = 0.0;
  for (int k = 0; k < norms.size(); ++k)
    if (left[k] > std::max(kSeen * norms[k], kOfLargest * norms.maxCoeff()))
      largest = std::max(largest, left[k]);
  if (!(largest > 0.0)) {
    why = "the model's other unknowns absorb it completely";
    return 0.0;
  }
  return std::sqrt(static_cast<double>(std::max(1, space_.rows()))) / largest;
}

/// What is drawn with a prior (a profile's coefficients) has weights of its own.
void ShapeMaker::weightByPriors(const Effect& effect, Eigen::VectorXd left, MadeShape& made) const {
  const std::vector<int> linear = linearParameters(effect);
  const auto weightOf = [&](int k) {
    const Parameter& p = effect.parameters()[linear[static_cast<std::size_t>(k)]];
    return p.priorStd / p.scale;
  };
  double widest = 0.0;
  for (int k = 0; k < static_cast<int>(linear.size()); ++k) widest = std::max(widest, weightOf(k));
  if (!(widest > 0.0)) return;
  for (int k = 0; k < static_cast<int>(linear.size()); ++k) {
    made.columns.col(k) *= weightOf(k) / widest;
    left[k] *= weightOf(k) / widest;
  }
  if (left.norm() > 0.0)
    made.columns *= std::sqrt(static_cast<double>(space_.rows())) / left.norm();
  else
    made.why = "the model's other unknowns absorb it completely";
}

RowMatrix GroupColumns::operator()(const EffectPtr& effect, const std::vector<double>& nonlinear) const {
  std::vector<MadeShape> made = maker_.finished({maker_.draft(effect, nonlinear)});
  return made.front().why.empty() ? std::move(made.front().columns) : RowMatrix(space_.length(), 0);
}

void varyAlong(const Problem& problem, const std::vector<int>& rows, int joint, RowMatrix& columns) {
  for (std::size_t i = 0; i < rows.size(); ++i)
    columns.row(static_cast<int>(i)) *= scaledPosition(problem, rows[i], joint);
}

void varyInTime(const Problem& problem, const std::vector<int>& rows, RowMatrix& columns) {
  const auto& all = problem.session().observations;
  const auto time = [&](int row) { return all[problem.rows()[row].observation].time; };
  const double first = all.front().time, last = all.back().time;
  for (std::size_t i = 0; i < rows.size(); ++i)
    columns.row(static_cast<int>(i)) *=
        last > first ? (2.0 * time(rows[i]) - first - last) / (last - first) : 0.0;
}

RowMatrix curveAlong(const Problem& problem, const std::vector<int>& rows, int joint,
                     const RowMatrix& columns) {
  const SmoothBasis curve(kCurveAlong, kSmoothness);
  std::vector<double> values(kCurveAlong);
  RowMatrix all = RowMatrix::Zero(columns.rows(), kCurveAlong * columns.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    curve.values(scaledPosition(problem, rows[i], joint), values.data());
    const auto row = static_cast<Eigen::Index>(i);  // of data: what a session knows beforehand stands below
    for (int f = 0; f < kCurveAlong; ++f)
      all.row(row).segment(f * columns.cols(), columns.cols()) =
          kAsALine * curve.priorStd(f) / curve.priorStd(0) * values[static_cast<std::size_t>(f)] *
          columns.row(row);
  }
  return all;
}

}  // namespace mm
