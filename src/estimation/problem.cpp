#include "estimation/problem.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "machine/error.h"
#include "machine/units.h"

namespace mm {
namespace {

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Vector3d rotationVector(const Eigen::Matrix3d& r) {
  const Eigen::AngleAxisd a(r);
  // near the identity AngleAxis loses the axis: the skew part is exact to third order there
  const Eigen::Vector3d half(0.5 * (r(2, 1) - r(1, 2)), 0.5 * (r(0, 2) - r(2, 0)), 0.5 * (r(1, 0) - r(0, 1)));
  return half.norm() < 1e-4 && a.angle() < 1.0 ? half : Eigen::Vector3d(a.axis() * a.angle());
}

/// The temperature whose absence alone keeps a model from a value; "an input" where it is none.
std::string missingTemperature(const Model& model, const State& at, const std::vector<double>& parameters,
                               Model::Workspace& work) {
  const std::vector<std::string>& sensors = model.domain().sensors;
  State known = at;
  for (double& t : known.temperature)
    if (!std::isfinite(t)) t = kReferenceTemperature;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    if (std::isfinite(at.temperature[s])) continue;
    State without = known;
    without.temperature[s] = at.temperature[s];
    model.corrected(without, parameters.data(), work);
    for (const double error : work.errors)
      if (!std::isfinite(error)) return "temperature '" + sensors[s] + "'";
  }
  return "an input";
}

const char* const kAxisNames[] = {"x", "y", "z"};

}  // namespace

double UnitVector::weight(const Eigen::VectorXd& inverseSigma) const {
  constexpr double kConstraint = 1e7;  // any: the residuals do not depend on the length
  const double largest = inverseSigma.size() > 0 ? inverseSigma.maxCoeff() : 0.0;
  return penalty > 0.0 ? std::sqrt(penalty) * kMillimetre * largest : kConstraint;
}

Problem::Problem(const Session& session, Model model) : session_(&session), model_(std::move(model)) {
  if (session.observations.empty())
    throw InputError(session.source +
                     ": the session has no observations; record contacts or references first");
  const GeometricStart start = geometricStart(session);
  rotation0_ = start.rotation;
  translation0_ = start.translation;
  featureStart_.resize(start.features.size());
  for (std::size_t f = 0; f < start.features.size(); ++f)
    featureStart_[f] = session.artifact.features[f].known
                           ? session.artifact.features[f].position
                           : Eigen::Vector3d(rotation0_.transpose() * (start.features[f] - translation0_));
  states_ = std::make_shared<SessionStates>(session, model_.domain());
  states_->aim(start.features);
  addRows();
  addUnknowns();

  findUsable();
}

void Problem::findUsable() {
  const int count = static_cast<int>(session_->observations.size());
  usable_.assign(count, 1);
  Model::Workspace work;
  std::vector<double> r(kMaxRows);
  const Eigen::VectorXd x = start();
  for (int o = 0; o < count; ++o) {
    const int n = residualsOf(o, x, r.data(), nullptr, work);
    for (int i = 0; i < n; ++i)
      if (!std::isfinite(r[i])) usable_[o] = 0;
    if (!usable_[o]) leftOut_.push_back(o);
  }
  if (5 * leftOut_.size() <= usable_.size()) return;
  const int o = leftOut_.front();  // which effect lacks its input?
  const std::string where = session_->source + ": row " + std::to_string(session_->observations[o].row) +
                            " and " + std::to_string(leftOut_.size() - 1) + " more: ";
  for (const EffectPtr& e : model_.effects()) {
    Model one(model_.machine(), model_.domain(), {e});
    std::vector<double> p;
    for (const Parameter& q : e->parameters()) p.push_back(q.start);
    one.corrected(state(o), p.data(), work);
    for (double error : work.errors)
      if (!std::isfinite(error))
        throw InputError(where + "effect " + e->spec().yaml() + " lacks " +
                         missingTemperature(one, state(o), p, work) + " there (" + e->shownBy() +
                         "); log it, or leave the effect out");
  }
  throw InputError(where + "the model's value is not a number");
}

void Problem::addRows() {
  const auto& observations = session_->observations;
  for (std::size_t o = 0; o < observations.size(); ++o) {
    const Observation& at = observations[o];
    firstRow_.push_back(static_cast<int>(rows_.size()));
    ResidualRow row;
    row.observation = static_cast<int>(o);
    if (at.kind == ObservationKind::kContact) {
      const int count = session_->artifact.features[at.feature].kind == FeatureKind::kBall ? 1 : 3;
      for (row.component = 0; row.component < count; ++row.component) rows_.push_back(row);
    } else if (at.kind == ObservationKind::kPosition) {
      for (row.component = 0; row.component < 3; ++row.component)
        if (std::isfinite(at.reference[row.component])) rows_.push_back(row);
    } else {
      for (row.component = 0; row.component < static_cast<int>(at.deviation.size()); ++row.component)
        if (std::isfinite(at.deviation[row.component])) {
          ResidualRow r = row;
          r.angular = model_.machine().joints()[row.component].kind == JointKind::kRotary;
          if (row.component < static_cast<int>(at.deviationStd.size()) &&
              std::isfinite(at.deviationStd[row.component]))
            r.statedSigma = at.deviationStd[row.component];
          rows_.push_back(r);
        }
    }
  }
  firstRow_.push_back(static_cast<int>(rows_.size()));
  if (rows_.empty())
    throw InputError(session_->source + ": no observation has a measured value; nothing to fit");
}

void Problem::addUnknowns() {
  const auto add = [&](Unknown u) {
    if (u.priorStd > 0.0) priors_.push_back(static_cast<int>(unknowns_.size()));
    unknowns_.push_back(std::move(u));
  };
  for (int e = 0; e < static_cast<int>(model_.effects().size()); ++e) {
    const Effect& effect = *model_.effects()[e];
    for (int k = 0; k < effect.parameterCount(); ++k) {
      const Parameter& p = effect.parameters()[k];
      add({UnknownKind::kEffect, e, k, p.name, p.unit, p.toUnit, p.scale, p.bound, p.start, 0.0, p.minimum,
           p.maximum});
    }
    for (const int k : effect.unitVectors())
      unitVectors_.push_back({model_.offset(e) + k, effect.unitVectorPenalty()});
  }
  const auto& features = session_->artifact.features;
  std::vector<char> touched(features.size(), 0);
  bool positions = false;
  for (const Observation& o : session_->observations) {
    if (o.kind == ObservationKind::kContact) touched[o.feature] = 1;
    if (o.kind == ObservationKind::kPosition) positions = true;
  }
  bool knownTouched = positions;
  for (std::size_t f = 0; f < features.size(); ++f) knownTouched |= touched[f] && features[f].known;
  if (!session_->artifact.poseKnown &&
      knownTouched) {  // with free features only, the pose is absorbed by them
    poseOffset_ = unknownCount();
    for (int k = 0; k < 6; ++k) {
      const bool rotation = k < 3;
      add({UnknownKind::kPose, 0, k,
           std::string(rotation ? "rotation " : "position ") + kAxisNames[k % 3] + " of the artifact",
           rotation ? "arcsec" : "um", rotation ? 1.0 / kArcsecond : 1.0 / kMicrometre,
           rotation ? 1e-3 : 1e-4, rotation ? 0.5 : 1.0, 0.0, 0.0});
    }
  }
  featureOffset_.assign(features.size(), -1);
  radiusOffset_.assign(features.size(), -1);
  for (std::size_t f = 0; f < features.size(); ++f) {
    if (!touched[f]) continue;
    if (!features[f].known || features[f].positionStd > 0.0) {
      featureOffset_[f] = unknownCount();
      for (int k = 0; k < 3; ++k)
        add({UnknownKind::kFeature, static_cast<int>(f), k, features[f].name + " " + kAxisNames[k], "um",
             1.0 / kMicrometre, 1e-4, 1.0, 0.0, features[f].known ? features[f].positionStd : 0.0});
    }
    if (features[f].kind == FeatureKind::kBall && features[f].radiusStd > 0.0) {
      radiusOffset_[f] = unknownCount();
      add({UnknownKind::kRadius, static_cast<int>(f), 0, "radius of " + features[f].name, "um",
           1.0 / kMicrometre, 1e-6, 1e-2, 0.0, features[f].radiusStd});
    }
  }
  // one zero a setup and measured component; rows without a setup share one too, unless the model is the
  // user's own law from end to end: an instrument measures from a datum of its own, a law written as a
  // formula says where it starts
  const auto& effects = model_.effects();
  const bool lawOnly =
      !effects.empty() && std::all_of(effects.begin(), effects.end(),
                                      [](const EffectPtr& e) { return e->spec().type == "formula"; });
  const int named = static_cast<int>(session_->setups.size());
  for (const Observation& o : session_->observations)
    setupOf_.push_back(o.setup >= 0                                        ? o.setup
                       : o.kind == ObservationKind::kDeviation && !lawOnly ? named
                                                                           : -1);
  const int width = std::max(3, model_.machine().jointCount());
  setupOffset_.assign((named + 1) * width, -1);
  for (const ResidualRow& row : rows_) {
    const int setup = setupOf_[row.observation];
    if (session_->observations[row.observation].kind == ObservationKind::kContact || setup < 0) continue;
    int& offset = setupOffset_[setup * width + row.component];
    if (offset >= 0) continue;
    offset = unknownCount();
    const double unit = row.angular ? kArcsecond : kMicrometre;
    add({UnknownKind::kSetup, setup, row.component,
         (setup < named ? "zero of setup " + session_->setups[setup] : "zero of the instrument along ") +
             (setup < named ? "" : model_.machine().joints()[row.component].name),
         row.angular ? "arcsec" : "um", 1.0 / unit, unit, row.angular ? 1.0 : 1.0, 0.0, 0.0});
  }
}

Eigen::VectorXd Problem::start() const {
  Eigen::VectorXd x(unknownCount());
  for (int i = 0; i < unknownCount(); ++i) x[i] = unknowns_[i].start;
  return x;
}

int Problem::find(UnknownKind kind, int owner) const {
  for (int i = 0; i < unknownCount(); ++i)
    if (unknowns_[i].kind == kind && unknowns_[i].owner == owner) return i;
  return -1;
}

Eigen::VectorXd Problem::sigmas(double linearSigma, double angularSigma) const {
  Eigen::VectorXd s(rowCount());
  for (int i = 0; i < rowCount(); ++i)
    s[i] =
        rows_[i].statedSigma > 0.0 ? rows_[i].statedSigma : (rows_[i].angular ? angularSigma : linearSigma);
  return s;
}

Eigen::Matrix3d Problem::poseRotation(const Eigen::VectorXd& x, Eigen::Matrix3d* leftJacobian) const {
  if (leftJacobian != nullptr) leftJacobian->setIdentity();
  if (poseOffset_ < 0) return rotation0_;
  const Eigen::Vector3d w = x.segment<3>(poseOffset_);
  const double angle = w.norm();
  if (angle < 1e-12) return (Eigen::Matrix3d::Identity() + skew(w)) * rotation0_;
  const Eigen::Matrix3d k = skew(w / angle);
  if (leftJacobian != nullptr)
    *leftJacobian = Eigen::Matrix3d::Identity() + (1 - std::cos(angle)) / angle * k +
                    (1 - std::sin(angle) / angle) * k * k;
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix() * rotation0_;
}

Eigen::Vector3d Problem::featureInWorkpiece(int feature, const Eigen::VectorXd& x) const {
  Eigen::Vector3d c = featureStart_[feature];
  if (featureOffset_[feature] >= 0) c += x.segment<3>(featureOffset_[feature]);
  Eigen::Vector3d t = translation0_;
  if (poseOffset_ >= 0) t += x.segment<3>(poseOffset_ + 3);
  return poseRotation(x, nullptr) * c + t;
}

int Problem::residualsOf(int observation, const Eigen::VectorXd& x, double* r, Derivative* d,
                         Model::Workspace& work) const {
  const Observation& o = session_->observations[observation];
  const State& at = state(observation);
  const ErrorLayout layout = model_.machine().layout();
  const int rows = firstRow_[observation + 1] - firstRow_[observation];
  const int parameters = model_.parameterCount();
  if (!usable_[observation]) {
    std::fill(r, r + rows, 0.0);
    if (d == nullptr) return rows;
    d->effects.setZero(rows, parameters);
    d->pose.setZero(rows, 6);
    d->feature.setZero(rows, 3);
    d->slots.setZero(rows, layout.size());
    d->radius.setZero(rows);
    return rows;
  }
  const ProbePose pose = model_.corrected(at, x.data(), work, d != nullptr ? &d->unused : nullptr);
  if (d != nullptr) {
    d->effects.setZero(rows, parameters);
    d->pose.setZero(rows, 6);
    d->feature.setZero(rows, 3);
    d->slots.setZero(rows, layout.size());
    d->radius.setZero(rows);
  }
  // by: derivative of a scalar residual with respect to the pose of the probe (6)
  const auto chain = [&](int row, const Eigen::Matrix<double, 1, 6>& by) {
    for (int s = 0; s < layout.size(); ++s) d->slots(row, s) += (by * work.bySlot.col(s)).value();
  };

  if (o.kind == ObservationKind::kDeviation) {
    const ProbePose nominal = model_.machine().nominal(o.position.data(), o.laserReading);
    const Eigen::Vector3d moved = pose.position - nominal.position;
    const Eigen::Vector3d turned = rotationVector(pose.orientation * nominal.orientation.transpose());
    for (int i = 0; i < rows; ++i) {
      const int joint = rows_[firstRow_[observation] + i].component;
      const Eigen::Matrix<double, 1, 6> by =
          model_.machine().seenAsDeviation(joint, o.position.data(), o.laserReading);
      r[i] = o.deviation[joint] - by.head<3>().dot(moved) - by.tail<3>().dot(turned);
      if (d != nullptr) chain(i, -by);
    }
  } else {
    const Artifact& artifact = session_->artifact;
    Eigen::Matrix3d leftJacobian;
    const Eigen::Matrix3d rotation = poseRotation(x, d != nullptr ? &leftJacobian : nullptr);
    Eigen::Vector3d translation = translation0_;
    if (poseOffset_ >= 0) translation += x.segment<3>(poseOffset_ + 3);
    double growth = 1.0;
    if (artifact.expansion != 0.0 && !artifact.temperatureSensor.empty()) {
      const int sensor = model_.domain().findSensor(artifact.temperatureSensor);
      if (sensor >= 0) growth += artifact.expansion * (at.temperature[sensor] - kReferenceTemperature);
    }
    if (o.kind ==
        ObservationKind::kPosition) {  // in the artifact's frame, where its components were measured
      const Eigen::Vector3d inArtifact = rotation.transpose() * (pose.position - translation);
      for (int i = 0; i < rows; ++i) {
        const int k = rows_[firstRow_[observation] + i].component;
        r[i] = o.reference[k] - inArtifact[k];
        if (d == nullptr) continue;
        Eigen::Matrix<double, 1, 6> by = Eigen::Matrix<double, 1, 6>::Zero();
        by.head<3>() = -rotation.col(k).transpose();
        chain(i, by);
        // inArtifact = R'(p - t); a left rotation by w turns it by -w
        d->pose.block<1, 3>(i, 0) =
            -rotation.col(k).transpose() * skew(pose.position - translation) * leftJacobian;
        d->pose.block<1, 3>(i, 3) = rotation.col(k).transpose();
      }
    } else {
      const Feature& feature = artifact.features[o.feature];
      Eigen::Vector3d inArtifact = featureStart_[o.feature];
      if (featureOffset_[o.feature] >= 0) inArtifact += x.segment<3>(featureOffset_[o.feature]);
      const double* errors = work.errors.data();
      inArtifact = growth * inArtifact + Eigen::Map<const Eigen::Vector3d>(errors + layout.feature(0));
      const Eigen::Vector3d offset = rotation * inArtifact;
      const Eigen::Vector3d away = pose.position - offset - translation;
      const auto geometry = [&](int row,
                                const Eigen::RowVector3d& n) {  // residual changes by n . (tip - feature)
        Eigen::Matrix<double, 1, 6> by = Eigen::Matrix<double, 1, 6>::Zero();
        by.head<3>() = n;
        chain(row, by);
        d->pose.block<1, 3>(row, 0) = n * skew(offset) * leftJacobian;
        d->pose.block<1, 3>(row, 3) = -n;
        d->feature.row(row) = -growth * n * rotation;
        d->slots.block<1, 3>(row, layout.feature(0)) -= n * rotation;
      };
      if (feature.kind == FeatureKind::kPoint) {
        for (int k = 0; k < 3; ++k) {
          r[k] = away[k];
          if (d != nullptr) geometry(k, Eigen::RowVector3d::Unit(k));
        }
      } else {
        double distance = growth * feature.radius +
                          (std::isfinite(o.laserReading) ? 0.0 : artifact.tipRadius) +
                          errors[layout.distance()];
        if (radiusOffset_[o.feature] >= 0) distance += x[radiusOffset_[o.feature]];
        const double length = away.norm();
        r[0] = length - distance;
        if (d != nullptr) {
          geometry(0, (away / length).transpose());
          d->slots(0, layout.distance()) -= 1.0;
          d->radius[0] = -1.0;
        }
      }
    }
  }
  if (setupOf_[observation] >= 0 && o.kind != ObservationKind::kContact) {
    const int width = std::max(3, model_.machine().jointCount());
    for (int i = 0; i < rows; ++i) {
      const int offset =
          setupOffset_[setupOf_[observation] * width + rows_[firstRow_[observation] + i].component];
      r[i] -= x[offset];
    }
  }
  if (d != nullptr)
    for (const Model::Derivative& one : work.derivatives)
      d->effects.col(one.parameter) += d->slots.col(one.slot) * one.value;
  return rows;
}

Eigen::VectorXd Problem::residuals(const Eigen::VectorXd& x) const {
  Eigen::VectorXd r(rowCount());
  Model::Workspace work;
  for (std::size_t o = 0; o < session_->observations.size(); ++o)
    residualsOf(static_cast<int>(o), x, r.data() + firstRow_[o], nullptr, work);
  return r;
}

void Problem::scatter(int observation, const Derivative& d, Eigen::MatrixXd& rows) const {
  const Observation& at = session_->observations[observation];
  const int first = firstRow_[observation], n = firstRow_[observation + 1] - first;
  rows.setZero(n, unknownCount());
  if (!usable_[observation]) return;
  if (model_.parameterCount() > 0) rows.leftCols(model_.parameterCount()) = d.effects;
  if (at.kind != ObservationKind::kDeviation && poseOffset_ >= 0) rows.middleCols(poseOffset_, 6) = d.pose;
  if (at.kind == ObservationKind::kContact) {
    if (featureOffset_[at.feature] >= 0) rows.middleCols(featureOffset_[at.feature], 3) = d.feature;
    if (radiusOffset_[at.feature] >= 0) rows.col(radiusOffset_[at.feature]) = d.radius;
  } else if (setupOf_[observation] >= 0) {
    const int width = std::max(3, model_.machine().jointCount());
    for (int i = 0; i < n; ++i)
      rows(i, setupOffset_[setupOf_[observation] * width + rows_[first + i].component]) = -1.0;
  }
}

Eigen::VectorXd Problem::residuals(const Eigen::VectorXd& x, Eigen::MatrixXd& jacobian) const {
  Eigen::VectorXd r(rowCount());
  jacobian.resize(rowCount(), unknownCount());
  Model::Workspace work;
  Derivative d;
  Eigen::MatrixXd rows;
  for (std::size_t o = 0; o < session_->observations.size(); ++o) {
    const int n = residualsOf(static_cast<int>(o), x, r.data() + firstRow_[o], &d, work);
    scatter(static_cast<int>(o), d, rows);
    jacobian.middleRows(firstRow_[o], n) = rows;
  }
  return r;
}

void Problem::linearise(const Eigen::VectorXd& x) {
  slotGradients_.resize(rowCount(), model_.machine().layout().size());
  Model::Workspace work;
  Derivative d;
  std::vector<double> r(kMaxRows);
  for (std::size_t o = 0; o < session_->observations.size(); ++o) {
    const int n = residualsOf(static_cast<int>(o), x, r.data(), &d, work);
    slotGradients_.middleRows(firstRow_[o], n) = d.slots;
  }
}

namespace {

/// Takes the derivatives of one effect at one state to the residuals of one observation.
class ColumnSink final : public ErrorSink {
 public:
  ColumnSink(const Eigen::MatrixXd& gradients, Eigen::MatrixXd& columns)
      : gradients_(gradients), columns_(columns) {}
  void at(int first, int rows) { first_ = first, rows_ = rows; }
  void add(int slot, int parameter, double, double basis) override { derivative(slot, parameter, basis); }
  void value(int, double) override {}
  void derivative(int slot, int parameter, double derivative) override {
    for (int i = first_; i < first_ + rows_; ++i) {
      const double gradient = gradients_(i, slot);
      if (gradient != 0.0) columns_(i, parameter) += gradient * derivative;
    }
  }
  bool wantsDerivatives() const override { return true; }

 private:
  const Eigen::MatrixXd& gradients_;
  Eigen::MatrixXd& columns_;
  int first_ = 0, rows_ = 0;
};

}  // namespace

Eigen::MatrixXd Problem::effectColumns(const Effect& effect, const std::vector<double>& p) const {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(rowCount(), effect.parameterCount());
  ColumnSink sink(slotGradients_, columns);
  for (std::size_t o = 0; o < session_->observations.size(); ++o) {
    sink.at(firstRow_[o], firstRow_[o + 1] - firstRow_[o]);
    effect.evaluate(state(static_cast<int>(o)), p.data(), sink);
  }
  return columns;
}

}  // namespace mm
