#include "thermal/dfnn_rules.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
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

void prune(DfnnRules& rules, const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, double threshold) {
  const Eigen::MatrixXd design = rules.design(x);
  if (rules.count() < 2 || design.rows() < design.cols()) return;
  const Eigen::VectorXd eta = errorReduction(design, y, rules.count());
  std::vector<int> kept;
  for (int j = 0; j < rules.count(); ++j)
    if (eta(j) >= threshold) kept.push_back(j);
  if (!kept.empty() && static_cast<int>(kept.size()) < rules.count()) rules.keep(kept);
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

void DfnnRules::strengths(const double* x, double* psi) const {
  const int rules = count(), r = inputs();
  double nearest = std::numeric_limits<double>::infinity();
  for (int j = 0; j < rules; ++j) {
    double square = 0.0;
    for (int i = 0; i < r; ++i) square += (x[i] - centres(j, i)) * (x[i] - centres(j, i));
    psi[j] = square / (widths(j) * widths(j));
    nearest = std::min(nearest, psi[j]);
  }
  double sum = 0.0;
  for (int j = 0; j < rules; ++j) sum += psi[j] = std::exp(nearest - psi[j]);
  for (int j = 0; j < rules; ++j) psi[j] /= sum;
}

Eigen::MatrixXd DfnnRules::design(const Eigen::MatrixXd& x) const {
  const Eigen::Index r = x.cols();
  Eigen::MatrixXd h(x.rows(), count() * (r + 1));
  Eigen::VectorXd point(r), psi(count());
  for (Eigen::Index k = 0; k < x.rows(); ++k) {
    point = x.row(k).transpose();
    strengths(point.data(), psi.data());
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

Eigen::VectorXd errorReduction(const Eigen::MatrixXd& design, const Eigen::MatrixXd& y, int rules) {
  const Eigen::Index columns = design.cols() / rules;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(design);
  // Rows of Q^T Y are q_c . t_p with q_c of unit length; their squares over t_p . t_p are the ratios.
  Eigen::MatrixXd ratio = (qr.householderQ().transpose() * y).topRows(design.cols());
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

DfnnRules growRules(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, const DfnnSettings& settings,
                    double ridge, const DfnnRules& start, int known) {
  const int most = settings.largestRules > 0 ? settings.largestRules : kMostRules;
  const int samples = static_cast<int>(x.rows());
  DfnnRules rules = start;
  const bool goingOn = rules.count() > 0;
  int first = known;
  if (!goingOn) {
    rules.add(x.row(0), settings.firstWidth);
    first = 1;
  }
  Consequents consequents(x, y, ridge);
  consequents.rebuild(rules, first);
  for (int i = first; i < samples; ++i) {
    const Eigen::RowVectorXd row = rules.design(x.row(i));
    const double error = consequents.error(row, i);
    Eigen::Index nearest = 0;
    const double distance =
        std::sqrt((rules.centres.rowwise() - x.row(i)).rowwise().squaredNorm().minCoeff(&nearest));
    const double distanceLimit =
        goingOn ? settings.distanceMin
                : std::max(settings.distanceMax * std::pow(settings.distanceDecay, i), settings.distanceMin);
    const double errorLimit =
        goingOn ? settings.errorMin
                : std::max(settings.errorMax * std::pow(settings.errorDecay, i), settings.errorMin);
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

}  // namespace mm
