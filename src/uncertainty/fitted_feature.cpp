#include "uncertainty/fitted_feature.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "base/dense.h"
#include "base/error.h"

namespace mm {
namespace {

constexpr int kSteps = 4;  // each makes the error smaller by deviation over radius

/// By the order of FittedFeature::Kind: centre and radius; the same in the plane; height and two tilts;
/// height and tilt.
constexpr int kUnknowns[] = {4, 3, 3, 2};

}  // namespace

FittedFeature::FittedFeature(Kind kind, const Eigen::Vector3d& centre, const Eigen::Vector3d& normal,
                             double radius, const std::vector<Eigen::Vector3d>& nominal)
    : kind_(kind),
      centre_(centre),
      normal_(normal),
      first_(normal.unitOrthogonal()),
      second_(normal.cross(first_)),
      radius_(radius) {
  const int unknowns = kUnknowns[static_cast<std::size_t>(kind)];
  design_.resize(nominal.size(), unknowns);
  Eigen::Vector3d along = Eigen::Vector3d::Zero();  // of a line
  if (kind == Kind::kLine && nominal.size() > 1) along = (nominal.back() - nominal.front()).normalized();
  double reach = radius_;
  for (const Eigen::Vector3d& p : nominal) reach = std::max(reach, (p - centre_).norm());
  for (std::size_t i = 0; i < nominal.size(); ++i) {
    const Eigen::Vector3d from = nominal[i] - centre_;
    switch (kind) {
      case Kind::kSphere:
        design_.row(i) << from.normalized().transpose(), 1.0;
        break;
      case Kind::kCircle:
        design_.row(i) << from.normalized().dot(first_), from.normalized().dot(second_), 1.0;
        break;
      case Kind::kPlane:
        design_.row(i) << 1.0, from.dot(first_) / reach, from.dot(second_) / reach;
        break;
      case Kind::kLine:
        design_.row(i) << 1.0, from.dot(along) / reach;
        break;
    }
  }
  if (design_.rows() < unknowns || rankOf(design_) < unknowns)
    throw InputError("the " + std::to_string(design_.rows()) +
                     " points do not determine the feature; it needs " + std::to_string(unknowns) +
                     " or more, not all on one line");
  inverse_ = pseudoInverse(design_);
}

double FittedFeature::deviation(const Eigen::Vector3d& measured, const Eigen::VectorXd& feature,
                                std::size_t i) const {
  const Eigen::Vector3d from = measured - centre_;
  switch (kind_) {
    case Kind::kSphere:
      return (from - feature.head<3>()).norm() - radius_ - feature[3];
    case Kind::kCircle:
      return std::hypot(from.dot(first_) - feature[0], from.dot(second_) - feature[1]) - radius_ - feature[2];
    case Kind::kPlane:
    case Kind::kLine:
      break;
  }
  return from.dot(normal_) - design_.row(i).dot(feature);
}

FittedFeature::Found FittedFeature::fit(const std::vector<Eigen::Vector3d>& measured,
                                        std::size_t first) const {
  const std::size_t count = design_.rows();
  Eigen::VectorXd feature = Eigen::VectorXd::Zero(design_.cols()), left(design_.rows());
  const bool linear = kind_ == Kind::kPlane || kind_ == Kind::kLine;
  for (int step = 0;; ++step) {
    for (std::size_t i = 0; i < count; ++i) left[i] = deviation(measured[first + i], feature, i);
    if (step == (linear ? 1 : kSteps)) break;
    feature += inverse_ * left;
  }
  Found found;
  found.form = left.maxCoeff() - left.minCoeff();
  switch (kind_) {
    case Kind::kSphere:
      found.centre = feature.head<3>();
      found.radius = feature[3];
      break;
    case Kind::kCircle:
      found.centre = feature[0] * first_ + feature[1] * second_;
      found.radius = feature[2];
      break;
    case Kind::kPlane:
    case Kind::kLine:
      found.centre = feature[0] * normal_;
      break;
  }
  return found;
}

}  // namespace mm
