#include "thermal/dfnn_rules.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "base/dense.h"
#include "base/error.h"

namespace mm {
namespace {

void require(bool fine, const char* setting, double value, const char* bound) {
  if (!fine)
    throw InputError(std::string("dfnn: ") + setting + " = " + std::to_string(value) + "; it must be " +
                     bound);
}

/// Normal equations of the consequents, kept up to date while samples come in and rules change.
class Consequents {
 public:
  Consequents(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, double ridge)
      : x_(x), y_(y), ridge_(ridge) {}

  void rebuild(const DfnnRules& rules, int samples) {
    const Eigen::MatrixXd h = rules.design(x_.topRows(samples));
    gram_ = h.transpose() * h;
    right_ = h.transpose() * y_.topRows(samples);
    samples_ = samples;
    solve();
  }
  void include(const Eigen::RowVectorXd& row) {
    gram_.noalias() += row.transpose() * row;
    right_.noalias() += row.transpose() * y_.row(samples_);
    ++samples_;
    solve();
  }
  /// Root mean square over the outputs of the error at a sample whose row of the design this is.
  double error(const Eigen::RowVectorXd& row, int sample) const {
    return std::sqrt((row * weights_ - y_.row(sample)).squaredNorm() / static_cast<double>(y_.cols()));
  }

 private:
  void solve() {
    // Without a ridge a trace of one stands for the minimum-norm solution while samples are fewer than
    // columns.
    constexpr double kLeastRidge = 1e-11;  // of the mean diagonal, above the rounding of its sums
    const double least = kLeastRidge * gram_.trace() / static_cast<double>(gram_.rows());
    Eigen::MatrixXd matrix = gram_;
    matrix.diagonal().array() += std::max(ridge_ * samples_, least);
    weights_ = solveSymmetric(matrix, right_);
  }

  const Eigen::MatrixXd& x_;
  const Eigen::MatrixXd& y_;
  double ridge_;
  Eigen::MatrixXd gram_, right_, weights_;
  int samples_ = 0;
};

/// eta_j of each rule: root mean square, over its columns and the outputs, of the error reduction ratios of
/// the orthogonalised design. Needs no fewer samples than columns.
Eigen::VectorXd errorReduction(const Eigen::MatrixXd& design, const Eigen::MatrixXd& y, int rules) {
  const Eigen::Index columns = design.cols() / rules;
  // Rows of Q^T Y are q_c . t_p with q_c of unit length; their squares over t_p . t_p are the ratios.
  Eigen::MatrixXd ratio = orthogonalParts(design, y);
  for (Eigen::Index p = 0; p < y.cols(); ++p) {
    const double total = y.col(p).squaredNorm();
    ratio.col(p) = total > 0.0 ? Eigen::VectorXd(ratio.col(p).array().square() / total)
                               : Eigen::VectorXd(Eigen::VectorXd::Zero(ratio.rows()));
  }
  Eigen::VectorXd eta(rules);
  for (int j = 0; j < rules; ++j)
    eta(j) = std::sqrt(ratio.middleRows(j * columns, columns).squaredNorm() /
                       static_cast<double>(columns * y.cols()));
  return eta;
}

void prune(DfnnRules& rules, const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, double threshold) {
  const Eigen::MatrixXd design = rules.design(x);
  if (rules.count() < 2 || design.rows() < design.cols()) return;
  const Eigen::VectorXd eta = errorReduction(design, y, rules.count());
  std::vector<int> kept;
  for (int j = 0; j < rules.count(); ++j)
    if (eta(j) >= threshold) kept.push_back(j);
  if (!kept.empty() && static_cast<int>(kept.size()) < rules.count()) rules.keep(kept);
}

/// Centres, then logarithms of widths.
Eigen::VectorXd packed(const DfnnRules& rules) {
  Eigen::VectorXd p(rules.centres.size() + rules.count());
  p << Eigen::Map<const Eigen::VectorXd>(rules.centres.data(), rules.centres.size()),
      rules.widths.array().log().matrix();
  return p;
}

DfnnRules unpacked(const Eigen::VectorXd& p, const DfnnRules& start) {
  DfnnRules rules = start;
  rules.centres = Eigen::Map<const Eigen::MatrixXd>(p.data(), start.centres.rows(), start.centres.cols());
  rules.widths =
      p.tail(start.count()).array().exp().max(start.widths.array() * 0.1).min(start.widths.array() * 10.0);
  return rules;
}

/// Residuals of the samples and of the penalties, all outputs one below the other.
Eigen::VectorXd residuals(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, const DfnnRules& rules,
                          double ridge, double departureRidge) {
  const Eigen::MatrixXd z = RidgeConsequents::design(x, rules);
  const Eigen::MatrixXd w = RidgeConsequents(z, y, x.cols()).solve(ridge, departureRidge);
  const Eigen::Index departures = z.cols() - 1 - x.cols();
  Eigen::MatrixXd all(z.rows() + departures, y.cols());
  all << y - z * w, std::sqrt(departureRidge * static_cast<double>(z.rows())) * w.bottomRows(departures);
  return Eigen::Map<const Eigen::VectorXd>(all.data(), all.size());
}

}  // namespace

void DfnnSettings::validate() const {
  require(distanceMin > 0.0, "distanceMin", distanceMin, "above 0");
  require(distanceMax >= distanceMin, "distanceMax", distanceMax, "at least distanceMin");
  require(errorMin >= 0.0, "errorMin", errorMin, "at least 0");
  require(errorMax >= errorMin, "errorMax", errorMax, "at least errorMin");
  require(distanceDecay > 0.0 && distanceDecay <= 1.0, "distanceDecay", distanceDecay,
          "above 0 and at most 1");
  require(errorDecay > 0.0 && errorDecay <= 1.0, "errorDecay", errorDecay, "above 0 and at most 1");
  require(firstWidth > 0.0, "firstWidth", firstWidth, "above 0");
  require(overlap > 0.0, "overlap", overlap, "above 0");
  require(widening >= 1.0, "widening", widening, "at least 1");
  require(pruning >= 0.0, "pruning", pruning, "at least 0");
  require(largestRules >= 0 && largestRules <= kMostRules, "largestRules", largestRules, "from 0 to 64");
}

Eigen::MatrixXd DfnnRules::design(const Eigen::MatrixXd& x) const {
  const Eigen::Index r = x.cols();
  Eigen::MatrixXd h(x.rows(), count() * (r + 1));
  Eigen::VectorXd psi(count());
  for (Eigen::Index k = 0; k < x.rows(); ++k) {
    const double sum = memberships([&](int i) { return x(k, i); }, psi.data());
    for (int j = 0; j < count(); ++j) psi(j) /= sum;
    for (int j = 0; j < count(); ++j) {
      h(k, j * (r + 1)) = psi(j);
      h.block(k, j * (r + 1) + 1, 1, r) = psi(j) * x.row(k);
    }
  }
  return h;
}

void DfnnRules::limitTo(const Eigen::MatrixXd& x) {
  constexpr double kMargin = 0.2;  // of the span: so far a bend may be trusted to go on
  const Eigen::RowVectorXd least = x.colwise().minCoeff(), most = x.colwise().maxCoeff();
  low = least - kMargin * (most - least);
  high = most + kMargin * (most - least);
}

Eigen::MatrixXd DfnnRules::limited(const Eigen::MatrixXd& x) const {
  if (low.size() == 0) return x;
  Eigen::MatrixXd inside = x;
  for (Eigen::Index i = 0; i < x.cols(); ++i) inside.col(i) = x.col(i).cwiseMax(low(i)).cwiseMin(high(i));
  return inside;
}

void DfnnRules::add(const Eigen::RowVectorXd& centre, double width) {
  centres.conservativeResize(count() + 1, centre.size());
  centres.row(count()) = centre;
  widths.conservativeResize(count() + 1);
  widths(count() - 1) = width;
}

void DfnnRules::keep(const std::vector<int>& rules) {
  DfnnRules kept;
  for (int j : rules) kept.add(centres.row(j), widths(j));
  *this = kept;
}

DfnnRules growRules(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, const DfnnSettings& settings,
                    double ridge) {
  const int most = settings.largestRules > 0 ? settings.largestRules : kMostRules;
  const int samples = static_cast<int>(x.rows());
  DfnnRules rules;
  rules.add(x.row(0), settings.firstWidth);
  Consequents consequents(x, y, ridge);
  consequents.rebuild(rules, 1);
  for (int i = 1; i < samples; ++i) {
    const Eigen::RowVectorXd row = rules.design(x.row(i));
    const double error = consequents.error(row, i);
    Eigen::Index nearest = 0;
    const double distance =
        std::sqrt((rules.centres.rowwise() - x.row(i)).rowwise().squaredNorm().minCoeff(&nearest));
    const double distanceLimit =
        std::max(settings.distanceMax * std::pow(settings.distanceDecay, i), settings.distanceMin);
    const double errorLimit =
        std::max(settings.errorMax * std::pow(settings.errorDecay, i), settings.errorMin);
    if (error <= errorLimit) {
      consequents.include(row);
    } else {
      if (distance <= distanceLimit) {
        rules.widths(nearest) *= settings.widening;
      } else if (rules.count() < most) {
        rules.add(x.row(i), settings.overlap * distance);
        prune(rules, x.topRows(i + 1), y.topRows(i + 1), settings.pruning);
      }
      consequents.rebuild(rules, i + 1);
    }
  }
  return rules;
}

Eigen::MatrixXd RidgeConsequents::design(const Eigen::MatrixXd& x, const DfnnRules& rules) {
  const Eigen::Index r = x.cols();
  const Eigen::Index departures = rules.count() > 1 ? rules.count() * (r + 1) : 0;
  Eigen::MatrixXd z(x.rows(), 1 + r + departures);
  z.col(0).setOnes();
  z.middleCols(1, r) = x;
  if (departures > 0) z.rightCols(departures) = rules.design(rules.limited(x));
  return z;
}

RidgeConsequents::RidgeConsequents(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y, Eigen::Index inputs)
    : gram_(z.transpose() * z),
      right_(z.transpose() * y),
      samples_(static_cast<double>(z.rows())),
      line_(1 + inputs) {}

std::vector<Eigen::MatrixXd> RidgeConsequents::solve(const std::vector<double>& ridges,
                                                     double departureRidge) const {
  constexpr double kLeast = 1e-13;  // keeps inputs that do not vary, and rules that never fire, regular
  const Eigen::Index departures = gram_.rows() - line_;
  Eigen::MatrixXd own = gram_.bottomRightCorner(departures, departures);
  own.diagonal().array() += std::max(departureRidge, kLeast) * samples_;
  Eigen::MatrixXd sides(departures, right_.cols() + line_);
  sides << right_.bottomRows(departures), gram_.bottomLeftCorner(departures, line_);
  const Eigen::MatrixXd solved = solveSymmetric(own, sides);
  std::vector<Eigen::MatrixXd> solutions;
  for (double ridge : ridges) {
    Eigen::MatrixXd matrix = gram_.topLeftCorner(line_, line_);
    matrix.diagonal().tail(line_ - 1).array() += std::max(ridge, kLeast) * samples_;
    Eigen::MatrixXd w(gram_.rows(), right_.cols());
    w.topRows(line_) = solveSymmetric(matrix, right_.topRows(line_));
    if (departures > 0)
      w.bottomRows(departures) = solved.leftCols(right_.cols()) - solved.rightCols(line_) * w.topRows(line_);
    solutions.push_back(std::move(w));
  }
  return solutions;
}

DfnnRules refineRules(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, const DfnnRules& start,
                      double ridge, double departureRidge) {
  if (start.count() < 2) return start;
  Eigen::VectorXd p = packed(start);
  const auto at = [&](const Eigen::VectorXd& q) {
    return residuals(x, y, unpacked(q, start), ridge, departureRidge);
  };
  Eigen::VectorXd r = at(p);
  constexpr double kUnseen = 1e-9, kZero = 1e-300;  // a width that no sample feels stays where it is
  constexpr double kLeastDamping = 1e-9;            // Gauss-Newton
  constexpr double kWorthwhile = 1e-4;  // of the squared error: a step that gains less is the last
  constexpr int kIterations = 40;
  double damping = 1e-2;
  for (int i = 0; i < kIterations; ++i) {
    Eigen::MatrixXd jacobian(r.size(), p.size());
    constexpr double kStep = 1e-5;
    for (Eigen::Index c = 0; c < p.size(); ++c) {
      Eigen::VectorXd moved = p;
      moved(c) += kStep;
      jacobian.col(c) = (at(moved) - r) / kStep;
    }
    const Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
    const Eigen::VectorXd gradient = jacobian.transpose() * r;
    bool better = false;
    double gain = 0.0;
    for (int tries = 0; tries < 8 && !better; ++tries) {
      Eigen::MatrixXd matrix = normal;
      matrix.diagonal().array() += damping * (normal.diagonal().array() + kUnseen * normal.trace() + kZero);
      const Eigen::VectorXd q = p - solveSymmetric(matrix, gradient);
      if (q.allFinite()) {
        const Eigen::VectorXd s = at(q);
        if (s.squaredNorm() < r.squaredNorm()) {
          gain = 1.0 - s.squaredNorm() / r.squaredNorm();
          p = q;
          r = s;
          better = true;
        }
      }
      damping = better ? std::max(kLeastDamping, damping * 0.3) : damping * 4.0;
    }
    if (!better || gain < kWorthwhile) break;
  }
  return unpacked(p, start);
}

}  // namespace mm
