#include "posterior/noise_view.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "posterior/part_of_first.h"

namespace mm {
namespace {

constexpr std::size_t kColumnsTogether = 192;  // whitened at a time; part of the layout, not of the threads
constexpr std::size_t kKeptNumbers = 1 << 19;  // of what was asked lately: 4 MB, and as much before it

/// Of columns with each other: so few that to pack them takes longer.
Eigen::MatrixXd productsOf(const Eigen::MatrixXd& columns) {
  Eigen::MatrixXd products(columns.cols(), columns.cols());
  products.triangularView<Eigen::Lower>() = columns.transpose().lazyProduct(columns);
  return products.selfadjointView<Eigen::Lower>();
}

}  // namespace

double logSumExp(const Eigen::Ref<const Eigen::ArrayXd>& values) {
  const double most = values.maxCoeff();
  return most + std::log((values - most).exp().sum());
}

std::shared_ptr<const WhitenedRows> whitenedAt(const NoiseRows& rows, const std::vector<RandomBlock>& scatter,
                                               const NoiseState& state) {
  return std::make_shared<WhitenedRows>(rows, state.variance, state.drift, scatter, state.scatter);
}

NoiseView::NoiseView(const PosteriorProblem& problem, NoiseState state,
                     std::shared_ptr<const WhitenedRows> whitened)
    : problem_(problem),
      state_(std::move(state)),
      logPrior_(state_.logPrior(problem)),
      whitened_(std::move(whitened)),
      rest_(whitened_->rest() + problem.statedFreedoms),
      freedoms_(whitened_->freedoms() + problem.statedFreedoms) {}

NoiseView::NoiseView(const PosteriorProblem& problem, NoiseState state,
                     std::shared_ptr<const PackedColumns> packed)
    : NoiseView(problem, state, whitenedAt(problem.rows, problem.scatter, state)) {
  packed_ = std::move(packed);
}

void NoiseView::makeAll() const {
  CancelScope::check();
  const int all = static_cast<int>(problem_.columns.cols());
  byFixed_.resize(whitened_->fixed().cols(), all);
  allTarget_.resize(all);
  products_.resize(problem_.shapes.size());
  // parts of whole shapes
  std::vector<std::size_t> parts = {0};
  int columns = 0;
  for (std::size_t s = 0; s < problem_.shapes.size(); ++s) {
    if (columns + problem_.shapes[s].count > static_cast<int>(kColumnsTogether))
      parts.push_back(s), columns = 0;
    columns += problem_.shapes[s].count;
  }
  parts.push_back(problem_.shapes.size());
  // one thread: the chains are the parts that run together, and a thread that waited here for others could be
  // given a chain that waits for it
  for (std::size_t p = 0; p + 1 < parts.size(); ++p) {
    if (parts[p] == parts[p + 1]) continue;
    const int first = problem_.shapes[parts[p]].first;
    const CauseShape& last = problem_.shapes[parts[p + 1] - 1];
    const int count = last.first + last.count - first;
    const WhitenedRows::Columns part = whitened_->prepare(problem_.columns.middleCols(first, count));
    allTarget_.segment(first, count) = part.target;
    for (std::size_t s = parts[p]; s < parts[p + 1]; ++s) {
      const CauseShape& shape = problem_.shapes[s];
      const auto block = part.whitened.middleCols(shape.first - first, shape.count);
      const auto absorbed = part.byFixed.middleCols(shape.first - first, shape.count);
      products_[s] = productsOf(block) - productsOf(absorbed);
    }
    byFixed_.middleCols(first, count) = part.byFixed;
  }
}

NoiseView::OfShape& NoiseView::keptOf(int shape) const {
  OfShape* kept = nullptr;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    auto& slot = kept_[shape];
    if (!slot) slot = std::make_unique<OfShape>();
    kept = slot.get();
  }
  std::call_once(kept->once, [&] {
    const CauseShape& s = problem_.shapes[static_cast<std::size_t>(shape)];
    kept->columns = whitened_->prepare(problem_.columns.middleCols(s.first, s.count));
  });
  return *kept;
}

const RowMatrix& NoiseView::crossOf(int shape) const {
  std::call_once(onceAll_, [this] { makeAll(); });
  OfShape& own = keptOf(shape);
  std::call_once(own.onceCross, [&] {
    const CauseShape& s = problem_.shapes[static_cast<std::size_t>(shape)];
    RowMatrix weighted = problem_.columns.middleCols(s.first, s.count);  // V^-1 times these
    const int rows = problem_.rows.rows();
    for (int k = 0; k < s.count; ++k) {
      const Eigen::VectorXd column = weighted.col(k).head(rows);
      weighted.col(k).head(rows) =
          (column - whitened_->whitener().driftIn(column)).cwiseQuotient(state_.variance);
    }
    own.cross.resize(s.count, problem_.columns.cols());
    if (packed_)
      packed_->productsWith(weighted, 0, static_cast<int>(problem_.columns.cols()), own.cross);
    else
      own.cross = rowProducts(weighted, problem_.columns);
    own.cross.noalias() -= own.columns.byFixed.transpose() * byFixed_;
  });
  return own.cross;
}

/// Products of the columns of two shapes, with everything free integrated out: a chain meets the same pairs
/// again and again.
Eigen::MatrixXd NoiseView::productOf(int a, int b) const {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = keptProducts_.find({a, b});
    if (found != keptProducts_.end()) return found->second;
  }
  Eigen::MatrixXd product = WhitenedRows::productOf(keptOf(a).columns, keptOf(b).columns);
  const std::lock_guard<std::mutex> lock(mutex_);
  return keptProducts_.emplace(std::make_pair(a, b), std::move(product)).first->second;
}

NoiseView::Joint NoiseView::jointOf(const ActingSet& set) const {
  Joint joint;
  for (const Acting& a : set) joint.members.push_back({sizeGrid()[a.size], &keptOf(a.shape).columns});
  static_cast<WhitenedRows::Joint&>(joint) = WhitenedRows::jointOf(
      joint.members, [&](std::size_t i, std::size_t j) { return productOf(set[i].shape, set[j].shape); });
  joint.rest = std::max(problem_.statedFreedoms * 1e-12, rest_ - joint.explained.squaredNorm());
  return joint;
}

double NoiseView::logDensity(const ActingSet& set) const {
  const Joint joint = jointOf(set);
  double prior = logPrior_;
  for (const Acting& a : set) {
    const CauseShape& s = problem_.shapes[static_cast<std::size_t>(a.shape)];
    prior += problem_.causes[static_cast<std::size_t>(s.cause)].logPriorOdds + s.logPrior[a.size];
  }
  return prior + logPossible(set, joint) -
         0.5 * (whitened_->logDeterminant() + joint.factor.logDeterminant()) -
         0.5 * freedoms_ * std::log(joint.rest);
}

/// Of each member whose coefficients are not free, for itself.
double NoiseView::logPossible(const ActingSet& set, const Joint& joint) const {
  const auto isLimited = [&](const Acting& a) {
    return problem_.shapes[static_cast<std::size_t>(a.shape)].secondPartOfFirst;
  };
  if (std::none_of(set.begin(), set.end(), isLimited)) return 0.0;
  const WhitenedRows::Fit fit = fitOf(joint);
  double sum = 0.0;
  for (std::size_t k = 0; k < set.size(); ++k)
    if (isLimited(set[k]))
      sum += logPartOfFirst(Eigen::Vector2d(fit.values[k].head<2>()),
                            Eigen::Matrix2d(fit.covariance[k].topLeftCorner<2, 2>()));
  return sum;
}

double NoiseView::whiteVariance(const ActingSet& set) const { return jointOf(set).rest / freedoms_; }

WhitenedRows::Fit NoiseView::fit(const ActingSet& set) const { return fitOf(jointOf(set)); }

WhitenedRows::Fit NoiseView::fitOf(const Joint& joint) const {
  return WhitenedRows::fitOf(joint.members, joint, joint.rest / freedoms_);
}

/// @param absorbed by the members of the set: their factor's rows x columns from `firstColumn` on.
void NoiseView::askShapes(int first, int end, const ActingSet& set, const Joint& joint,
                          const RowMatrix& absorbed, int firstColumn, Conditionals& look) const {
  for (int s = first; s < end; ++s) {
    const CauseShape& shape = problem_.shapes[static_cast<std::size_t>(s)];
    Eigen::MatrixXd products = products_[static_cast<std::size_t>(s)];
    Eigen::VectorXd target = allTarget_.segment(shape.first, shape.count);
    if (!set.empty()) {
      const auto by = absorbed.middleCols(shape.first - firstColumn, shape.count);
      products.noalias() -= by.transpose() * by;
      target.noalias() -= by.transpose() * joint.explained;
    }
    const Sizes possible = shape.secondPartOfFirst ? logPartOfFirst(products, target, joint.rest, freedoms_)
                                                   : Sizes(Sizes::Zero());
    look.logWeights.row(s) =
        (possible + logBayesFactors(products, target, joint.rest, freedoms_) + shape.logPrior +
         problem_.causes[static_cast<std::size_t>(shape.cause)].logPriorOdds)
            .transpose();
  }
}

std::shared_ptr<const Conditionals> NoiseView::look(const ActingSet& set) const {
  CancelScope::check();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const auto* kept : {&lately_, &before_}) {
      const auto found = kept->find(set);
      if (found != kept->end()) return found->second;
    }
  }
  std::shared_ptr<const Conditionals> answer = ask(set);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (lately_.size() * static_cast<std::size_t>(answer->logWeights.size()) > kKeptNumbers)
    before_ = std::exchange(lately_, {});
  lately_.emplace(set, answer);
  return answer;
}

std::shared_ptr<const Conditionals> NoiseView::ask(const ActingSet& set) const {
  std::call_once(onceAll_, [this] { makeAll(); });
  const int shapes = static_cast<int>(problem_.shapes.size());
  const auto answer = std::make_shared<Conditionals>();
  Conditionals& out = *answer;
  out.logWeights.resize(shapes, kSizes);
  // what each cause would bring beside those of `beside`
  const auto absorbedBy = [&](const ActingSet& beside, const Joint& joint, int first, int count) {
    RowMatrix absorbed(joint.explained.size(), count);
    int at = 0;
    for (const Acting& a : beside) {
      const RowMatrix& cross = crossOf(a.shape);
      absorbed.middleRows(at, cross.rows()) = sizeGrid()[a.size] * cross.middleCols(first, count);
      at += static_cast<int>(cross.rows());
    }
    joint.factor.solveLowerInPlace(absorbed);
    return absorbed;
  };
  const Joint joint = jointOf(set);
  askShapes(0, shapes, set, joint, absorbedBy(set, joint, 0, static_cast<int>(problem_.columns.cols())), 0,
            out);
  for (std::size_t k = 0; k < set.size(); ++k) {
    ActingSet others = set;
    others.erase(others.begin() + static_cast<long>(k));
    const Joint rest = jointOf(others);
    const Cause& own =
        problem_
            .causes[static_cast<std::size_t>(problem_.shapes[static_cast<std::size_t>(set[k].shape)].cause)];
    const CauseShape &first = problem_.shapes[static_cast<std::size_t>(own.first)],
                     &last = problem_.shapes[static_cast<std::size_t>(own.end - 1)];
    askShapes(own.first, own.end, others, rest,
              absorbedBy(others, rest, first.first, last.first + last.count - first.first), first.first, out);
  }
  for (const Cause& c : problem_.causes) {
    const auto part = out.logWeights.middleRows(c.first, c.end - c.first);
    const double most = part.maxCoeff();
    out.logOdds.push_back(most + std::log((part - most).exp().sum()));
    if (std::isnan(out.logOdds.back()))
      throw NumericalError(
          "the evidence of a cause is not a number, so no cause can be judged; leave rows of extreme values "
          "out of the session, or send it with this line to the maintainers");
  }
  return answer;
}

}  // namespace mm
