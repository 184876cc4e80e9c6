#include "estimation/genetic_sphere_fitness.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/error.h"
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

void checkColumn(const char* what, const std::vector<double>& values, std::size_t size) {
  if (values.size() != size)
    throw InputError(std::string("sphere fitness: ") + what + " has " + std::to_string(values.size()) +
                     " values where there are " + std::to_string(size) + " rows");
  for (std::size_t i = 0; i < size; ++i)
    if (!std::isfinite(values[i]))
      throw InputError(std::string("sphere fitness: ") + what + " of row " + std::to_string(i) +
                       " is not finite");
}

void checkColumns(const char* what, const std::vector<SparseColumn>& columns, std::size_t size,
                  std::size_t coefficients) {
  for (const SparseColumn& column : columns) {
    checkColumn(what, column.values, size);
    if (column.coefficient >= coefficients)
      throw InputError(std::string("sphere fitness: ") + what + " asks for coefficient " +
                       std::to_string(column.coefficient) + " of " + std::to_string(coefficients));
  }
}

double rootOf(const std::vector<double>& weight, std::size_t i) {
  if (weight.empty()) return 1.0;
  if (weight[i] < 0.0)
    throw InputError("sphere fitness: weight of row " + std::to_string(i) + " is negative");
  return std::sqrt(weight[i]);
}

}  // namespace

SphereFitness::SphereFitness(const SphereContacts& contacts, std::vector<SphereBall> balls,
                             const LinearRows& rows, std::size_t coefficients, CentreRule rule,
                             Mapping mapping, std::size_t dimension)
    : coefficientCount_(coefficients),
      dimension_(mapping ? dimension : coefficients),
      contactCount_(contacts.size()),
      rule_(rule),
      mapping_(std::move(mapping)),
      balls_(std::move(balls)) {
  if (dimension_ == 0) throw InputError("sphere fitness: there is nothing to estimate: no genes");
  const std::size_t n = contactCount_;
  for (const auto& component : contacts.position) checkColumn("position", component, n);
  checkColumn("distance", contacts.distance, n);
  for (const auto& component : contacts.displacement)
    checkColumns("displacement", component, n, coefficients);
  checkColumns("distance column", contacts.distanceColumns, n, coefficients);
  if (!contacts.weight.empty()) checkColumn("weight", contacts.weight, n);
  if (contacts.ball.size() != n) throw InputError("sphere fitness: each contact needs the index of its ball");
  for (std::size_t i = 0; i < n; ++i) {
    if (contacts.ball[i] >= balls_.size())
      throw InputError("sphere fitness: contact " + std::to_string(i) + " is on ball " +
                       std::to_string(contacts.ball[i]) + " of " + std::to_string(balls_.size()));
    if (!(contacts.distance[i] > 0.0))
      throw InputError("sphere fitness: contact " + std::to_string(i) +
                       " has a distance (R + r) that is not positive");
  }
  checkColumn("linear offset", rows.offset, rows.offset.size());
  checkColumns("linear column", rows.columns, rows.offset.size(), coefficients);
  if (!rows.weight.empty()) checkColumn("linear weight", rows.weight, rows.offset.size());
  if (n + rows.offset.size() == 0) throw InputError("sphere fitness: no contacts and no linear rows");
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
    rootWeight_.push_back(rootOf(contacts.weight, i));
    for (const SparseColumn* column : all) columns_.push_back(column->values[i]);
  }
  corrected_ = position_;
  correctedDistance_ = distance_;
  scratch_.resize(coefficientCount_);

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
    const double root = rootOf(rows.weight, i);
    linear_.push_back(root * rows.offset[i]);
    for (const SparseColumn& column : rows.columns) linear_.push_back(root * column.values[i]);
  }
}

void SphereFitness::mapCoefficients(const double* chromosome, double* coefficients) const {
  if (mapping_)
    mapping_(chromosome, coefficients);
  else
    std::copy_n(chromosome, coefficientCount_, coefficients);
}

bool SphereFitness::newGeneration(const double* best) {
  if (filled_ && !anyFree_) return false;
  filled_ = true;
  reference_.assign(best, best + dimension_);
  mapCoefficients(best, scratch_.data());
  correct(scratch_.data());
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
  thread_local std::vector<double> coefficients, linear, sums, total;  // grow once a thread
  const std::size_t lanes = roundUp(count, kSphereLanes), terms = terms_.total();
  packed.resize(terms * lanes);
  linear.resize(linearTerms_ * lanes);
  coefficients.resize(coefficientCount_);
  sums.resize(4 * lanes);
  total.assign(lanes, 0.0);

  for (std::size_t l = 0; l < lanes; ++l) {  // the lanes beyond `count` repeat the last chromosome
    const double* chromosome = population + std::min(l, count - 1) * dimension_;
    const double* c = chromosome;
    if (mapping_) {
      mapping_(chromosome, coefficients.data());
      c = coefficients.data();
    }
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

SphereFitness ballCentreFitness(const std::array<std::vector<double>, 3>& position,
                                const std::vector<double>& distance, const Eigen::Vector3d& near) {
  SphereContacts contacts;
  contacts.position = position;
  contacts.distance = distance;
  contacts.ball.assign(distance.size(), 0);
  for (std::size_t axis = 0; axis < 3; ++axis)
    contacts.displacement[axis] = {{axis, std::vector<double>(distance.size(), -1.0)}};
  // The ball of the fitness stays at `near`; the genes move the contacts by what they differ from it.
  const auto fromNear = [near](const double* centre, double* shift) {
    for (int axis = 0; axis < 3; ++axis) shift[axis] = centre[axis] - near[axis];
  };
  return {contacts, {{near, false}}, {}, 3, CentreRule::kOfBest, fromNear, 3};
}

}  // namespace mm
