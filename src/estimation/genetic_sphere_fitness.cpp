#include "estimation/genetic_sphere_fitness.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/dense.h"
#include "base/tiny.h"

namespace mm {
namespace {

constexpr double kOpen = 1e-9;     // of a ball's information: contacts leave the direction open
constexpr double kSettled = 1e-9;  // of the radius: a centre that moves by less has been found

/// Contacts handed to the kernel at a time: their rows stay in the first-level cache while all chromosomes
/// pass.
constexpr std::size_t kBlock = 192;

std::size_t roundUp(std::size_t value, std::size_t multiple) {
  return (value + multiple - 1) / multiple * multiple;
}

}  // namespace

SphereFitness::SphereFitness(const SphereContacts& contacts, std::vector<SphereBall> balls,
                             const LinearRows& rows, std::size_t coefficients, CentreRule rule)
    : dimension_(coefficients), contactCount_(contacts.size()), rule_(rule), balls_(std::move(balls)) {
  copyContacts(contacts, rows);
}

void SphereFitness::copyContacts(const SphereContacts& contacts, const LinearRows& rows) {
  std::vector<std::size_t> order(contactCount_);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return contacts.ball[a] < contacts.ball[b]; });
  std::vector<const SparseColumn*> all;
  std::size_t* sizes[4] = {&terms_.x, &terms_.y, &terms_.z, &terms_.distance};
  for (std::size_t part = 0; part < 4; ++part) {
    const auto& columns = part < 3 ? contacts.displacement[part] : contacts.distanceColumns;
    *sizes[part] = columns.size();
    for (const SparseColumn& column : columns) all.push_back(&column);
  }
  for (const SparseColumn* column : all) termCoefficient_.push_back(column->coefficient);

  for (std::size_t i : order) {
    for (std::size_t axis = 0; axis < 3; ++axis) position_[axis].push_back(contacts.position[axis][i]);
    distance_.push_back(contacts.distance[i]);
    rootWeight_.push_back(contacts.weight.empty() ? 1.0 : std::sqrt(contacts.weight[i]));
    for (const SparseColumn* column : all) columns_.push_back(column->values[i]);
  }
  corrected_ = position_;
  correctedDistance_ = distance_;

  stride_ = kRowHead + all.size();
  std::size_t row = 0;
  for (std::size_t i = 0; i < contactCount_;) {
    Group group;
    group.ball = contacts.ball[order[i]];
    group.first = i;
    while (i < contactCount_ && contacts.ball[order[i]] == group.ball) ++i;
    group.count = i - group.first;
    group.padded = roundUp(group.count, kSphereTile);
    group.row = row;
    row += group.padded;
    anyFree_ = anyFree_ || balls_[group.ball].free;
    groups_.push_back(group);
  }
  rows_.assign(row * stride_, 0.0f);

  linearRows_ = rows.offset.size();
  linearTerms_ = rows.columns.size();
  residualCount_ = contactCount_ + linearRows_;
  for (const SparseColumn& column : rows.columns) linearCoefficient_.push_back(column.coefficient);
  for (std::size_t i = 0; i < linearRows_; ++i) {
    linear_.push_back(rows.offset[i]);
    for (const SparseColumn& column : rows.columns) linear_.push_back(column.values[i]);
  }
}

bool SphereFitness::newGeneration(const double* best) {
  if (filled_ && !anyFree_) return false;
  filled_ = true;
  correct(best);
  for (Group& group : groups_) {
    if (balls_[group.ball].free) recomputeCentre(group);
    fillRows(group);
  }
  return anyFree_;
}

void SphereFitness::correct(const double* coefficients) {
  const std::size_t terms = terms_.total();
  const std::size_t ends[4] = {terms_.x, terms_.x + terms_.y, terms_.x + terms_.y + terms_.z, terms};
  for (std::size_t i = 0; i < contactCount_; ++i) {
    const double* column = columns_.data() + i * terms;
    double sums[4] = {0, 0, 0, 0};
    for (std::size_t part = 0, t = 0; part < 4; ++part)
      for (; t < ends[part]; ++t) sums[part] += column[t] * coefficients[termCoefficient_[t]];
    for (std::size_t axis = 0; axis < 3; ++axis) corrected_[axis][i] = position_[axis][i] + sums[axis];
    correctedDistance_[i] = distance_[i] + sums[3];
  }
}

/// Gauss-Newton with the distance held: the sphere of known radius through the corrected contacts.
void SphereFitness::recomputeCentre(const Group& group) {
  Eigen::Vector3d centre = balls_[group.ball].centre;
  constexpr int kIterations = 20;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    double size = 0.0;
    for (std::size_t i = group.first; i < group.first + group.count; ++i) {
      const Eigen::Vector3d p(corrected_[0][i] - centre.x(), corrected_[1][i] - centre.y(),
                              corrected_[2][i] - centre.z());
      const double length = p.norm();
      if (!(length > 0.0)) continue;
      const double weight = rootWeight_[i] * rootWeight_[i];
      const Eigen::Vector3d n = p / length;
      normal += weight * n * n.transpose();
      right += weight * (length - correctedDistance_[i]) * n;
      size = std::max(size, distance_[i]);
    }
    // A trace of damping keeps the directions that few contacts leave open where they are.
    normal.diagonal().array() += kOpen * normal.trace() + kTiny;
    Eigen::Vector3d step = normal.ldlt().solve(right);
    if (!step.allFinite()) return;
    if (step.norm() > size) step *= size / step.norm();
    centre += step;
    if (step.norm() < kSettled * size) break;
  }
  balls_[group.ball].centre = centre;
}

void SphereFitness::fillRows(Group& group) {
  const Eigen::Vector3d centre = balls_[group.ball].centre;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  const std::size_t terms = terms_.total();
  for (std::size_t k = 0; k < group.padded; ++k) {
    const bool real = k < group.count;
    const std::size_t i = group.first + std::min(k, group.count - 1);
    const Eigen::Vector3d p(position_[0][i] - centre.x(), position_[1][i] - centre.y(),
                            position_[2][i] - centre.z());
    const Eigen::Vector3d moved(corrected_[0][i] - centre.x(), corrected_[1][i] - centre.y(),
                                corrected_[2][i] - centre.z());
    const double distance = distance_[i], root = real ? rootWeight_[i] : 0.0;
    const Eigen::Vector3d n =
        moved.norm() > 0.0 ? Eigen::Vector3d(root / moved.norm() * moved) : Eigen::Vector3d::Zero();
    normal += n * n.transpose();
    float* row = rows_.data() + (group.row + k) * stride_;
    row[kExcess] = static_cast<float>(p.squaredNorm() - distance * distance);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      row[kTwoX + axis] = static_cast<float>(2.0 * p[axis]);
      row[kNormalX + axis] = static_cast<float>(n[axis]);
    }
    row[kSquare] = static_cast<float>(distance * distance);
    row[kDistance] = static_cast<float>(distance);
    row[kRootWeight] = static_cast<float>(root);
    for (std::size_t t = 0; t < terms; ++t) row[kRowHead + t] = static_cast<float>(columns_[i * terms + t]);
  }
  if (rule_ != CentreRule::kFollow || !balls_[group.ball].free) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(normal);
  Eigen::Vector3d inverse = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i)
    if (eigen.eigenvalues()[i] > kOpen * eigen.eigenvalues()[2]) inverse[i] = 1.0 / eigen.eigenvalues()[i];
  group.inverse = eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

void SphereFitness::finishGroup(const Group& group, std::size_t lanes, const double* sums,
                                double* costs) const {
  if (rule_ != CentreRule::kFollow || !balls_[group.ball].free) {
    for (std::size_t l = 0; l < lanes; ++l) costs[l] += sums[l];
    return;
  }
  const Eigen::Matrix3d& h = group.inverse;
  const double xx = h(0, 0), yy = h(1, 1), zz = h(2, 2);
  const double xy = 2.0 * h(0, 1), xz = 2.0 * h(0, 2), yz = 2.0 * h(1, 2);
  const double *gx = sums + lanes, *gy = gx + lanes, *gz = gy + lanes;
  for (std::size_t l = 0; l < lanes; ++l) {
    const double explained = gx[l] * (xx * gx[l] + xy * gy[l] + xz * gz[l]) +
                             gy[l] * (yy * gy[l] + yz * gz[l]) + zz * gz[l] * gz[l];
    costs[l] += std::max(0.0, sums[l] - explained);
  }
}

void SphereFitness::evaluate(const double* population, std::size_t count, double* costs) const {
  thread_local std::vector<float> packed;
  thread_local std::vector<double> linear, sums, total;  // grow once a thread
  const std::size_t lanes = roundUp(count, kSphereLanes), terms = terms_.total();
  packed.resize(terms * lanes);
  linear.resize(linearTerms_ * lanes);
  sums.resize(4 * lanes);
  total.assign(lanes, 0.0);

  for (std::size_t l = 0; l < lanes; ++l) {  // the lanes beyond `count` repeat the last chromosome
    const double* c = population + std::min(l, count - 1) * dimension_;
    for (std::size_t t = 0; t < terms; ++t)
      packed[t * lanes + l] = static_cast<float>(c[termCoefficient_[t]]);
    for (std::size_t t = 0; t < linearTerms_; ++t) linear[t * lanes + l] = c[linearCoefficient_[t]];
  }
  SphereBlock block;
  block.stride = stride_;
  block.terms = terms_;
  block.coefficients = packed.data();
  block.lanes = lanes;
  for (const Group& group : groups_) {
    std::fill(sums.begin(), sums.end(), 0.0);
    for (std::size_t first = 0; first < group.padded; first += kBlock) {
      block.rows = rows_.data() + (group.row + first) * stride_;
      block.contacts = std::min(kBlock, group.padded - first);
      addSphereBlock(block, sums.data());
    }
    finishGroup(group, lanes, sums.data(), total.data());
  }
  if (linearRows_ > 0)
    addLinearRows(linear_.data(), linearRows_, linearTerms_, linear.data(), lanes, total.data());
  for (std::size_t l = 0; l < count; ++l) costs[l] = total[l] / static_cast<double>(residualCount_);
}

/// Mean square of the residuals as a quadratic form of the coefficients, about the last newGeneration().
Eigen::MatrixXd SphereFitness::informationOfCoefficients() const {
  const auto n = static_cast<Eigen::Index>(dimension_);
  const std::size_t terms = terms_.total();
  const std::size_t ends[4] = {terms_.x, terms_.x + terms_.y, terms_.x + terms_.y + terms_.z, terms};
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
  for (const Group& group : groups_) {
    const auto rows = static_cast<Eigen::Index>(group.count);
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(rows, n);
    Eigen::MatrixXd normals(rows, 3);
    for (Eigen::Index k = 0; k < rows; ++k) {
      const std::size_t i = group.first + static_cast<std::size_t>(k);
      const float* row = rows_.data() + (group.row + static_cast<std::size_t>(k)) * stride_;
      double factor[4] = {row[kNormalX], row[kNormalY], row[kNormalZ], -rootWeight_[i]};
      normals.row(k) << factor[0], factor[1], factor[2];
      for (std::size_t part = 0, t = 0; part < 4; ++part)
        for (; t < ends[part]; ++t)
          jacobian(k, static_cast<Eigen::Index>(termCoefficient_[t])) +=
              factor[part] * columns_[i * terms + t];
    }
    information += jacobian.transpose() * jacobian;
    const Eigen::MatrixXd shift = normals.transpose() * jacobian;
    information -= shift.transpose() * group.inverse * shift;  // zero where the centre does not follow
  }
  Eigen::VectorXd line = Eigen::VectorXd::Zero(n);
  for (std::size_t i = 0; i < linearRows_; ++i) {
    line.setZero();
    for (std::size_t t = 0; t < linearTerms_; ++t)
      line[static_cast<Eigen::Index>(linearCoefficient_[t])] += linear_[i * (linearTerms_ + 1) + t + 1];
    information += line * line.transpose();
  }
  return information / static_cast<double>(residualCount_);
}

std::vector<double> SphereFitness::principalAxes(const GeneticRanges& ranges) const {
  const auto n = static_cast<Eigen::Index>(dimension_);
  Eigen::VectorXd half(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto g = static_cast<std::size_t>(j);
    half[j] = 0.5 * (ranges.high[g] - ranges.low[g]);
  }
  const SymmetricEigen eigen(half.asDiagonal() * informationOfCoefficients() * half.asDiagonal());
  const double strongest = eigen.values[n - 1];
  if (!(strongest > 0.0)) return {};
  constexpr double kNoEffect = 1e-18;  // of the strongest information: rounding, squared
  std::vector<double> axes;
  axes.reserve(dimension_ * dimension_);
  for (Eigen::Index a = 0; a < n; ++a) {
    // An axis without any effect is not longer than its range, like the others in the first stage.
    const double length = std::sqrt(strongest / std::max(eigen.values[a], kNoEffect * strongest));
    for (Eigen::Index j = 0; j < n; ++j) axes.push_back(length * half[j] * eigen.vectors(j, a));
  }
  return axes;
}

SphereFitness ballCentreFitness(const std::array<std::vector<double>, 3>& position,
                                const std::vector<double>& distance, const Eigen::Vector3d& near) {
  SphereContacts contacts;
  contacts.position = position;
  contacts.distance = distance;
  contacts.ball.assign(distance.size(), 0);
  for (std::size_t axis = 0; axis < 3; ++axis)
    contacts.displacement[axis] = {{axis, std::vector<double>(distance.size(), -1.0)}};
  // The ball stays at `near`; the genes move the contacts by what they differ from it.
  return {contacts, {{near, false}}, {}, 3, CentreRule::kOfBest};
}

}  // namespace mm
