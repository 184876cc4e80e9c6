#include "ros_bridge/residual_markers.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "model/observed_domain.h"

namespace mm {
namespace {

constexpr double kTooFar = 4e-4;  // m more a m of travel of x: 4 um at 10 mm

Session emptySession() {
  Session session(Machine::load("three_axis"));
  session.source = "made.csv";
  session.artifact.tipRadius = 1e-3;
  session.artifact.repeatability = 0.1e-6;
  return session;
}

/// An observation of a machine that stands at `true position`: what its scales indicate there.
Observation seenAt(const Eigen::Vector3d& truePosition, ObservationKind kind, Session& session) {
  Observation o;
  o.kind = kind;
  o.row = static_cast<std::int64_t>(session.observations.size()) + 1;
  o.time = 10.0 * static_cast<double>(o.row);
  o.position = {truePosition.x() / (1.0 + kTooFar), truePosition.y(), truePosition.z()};
  return o;
}

/// x of each arrow over the length that it stands for, um, and where it begins, mm.
std::vector<std::pair<double, double>> arrowsAlongX(const Session& session) {
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  options.rejectOutliers = false;
  const Model empty(session.machine, observedDomain(session), std::vector<EffectSpec>());
  const CalibrationResult fit = calibrate(session, empty, options);
  std::vector<std::pair<double, double>> seen;
  for (const auto& marker : residualMarkers(fit, 1000.0, "workpiece").markers)
    if (marker.ns == "residuals")
      for (std::size_t i = 0; i + 1 < marker.points.size(); i += 2)
        seen.emplace_back(1e3 * marker.points[i].x, (marker.points[i + 1].x - marker.points[i].x) * 1e3);
  return seen;
}

/// An arrow leads from where it is to where the machine, which goes too far in x, found it: too low by 0.4 um
/// a mm.
void expectFoundTooLow(const Session& session, double tolerance) {
  const auto arrows = arrowsAlongX(session);
  ASSERT_EQ(arrows.size(), session.observations.size());
  double most = 0.0;
  for (const auto& [at, along] : arrows) {
    EXPECT_LE(along * at, 1e-9) << at;
    most = std::max(most, std::abs(along));
  }
  EXPECT_NEAR(most, 4.0, tolerance);
}

TEST(ResidualMarkers, AreAlikeForContactsPositionsAndDeviations) {
  Session contacts = emptySession(), positions = emptySession(), deviations = emptySession();
  Feature ball;
  ball.name = "ball";
  ball.radius = 9e-3;
  contacts.artifact.features.push_back(ball);
  positions.artifact.name = "frame of the tracker";  // of known pose
  for (int i = 0; i < 20; ++i) {
    const double turn = 2.0 * M_PI * i / 20.0;
    const Eigen::Vector3d at(10e-3 * std::cos(turn), 10e-3 * std::sin(turn), 0.0);
    Observation contact = seenAt(at, ObservationKind::kContact, contacts);
    contact.feature = 0;
    contact.approach = -at.normalized();
    contacts.observations.push_back(contact);
    Observation position = seenAt(at, ObservationKind::kPosition, positions);
    position.reference = at;
    positions.observations.push_back(position);
    Observation deviation = seenAt(at, ObservationKind::kDeviation, deviations);
    deviation.deviation = {at.x() - deviation.position[0], kNotMeasured, kNotMeasured};
    deviations.observations.push_back(deviation);
  }
  for (Session* session : {&contacts, &positions, &deviations}) session->prepare();
  expectFoundTooLow(contacts, 0.01);
  expectFoundTooLow(positions, 0.01);
  expectFoundTooLow(deviations, 0.01);
}

TEST(ResidualMarkers, BeginWhereTheBallWasTouched) {
  Session session = emptySession();
  Feature ball;
  ball.name = "ball";
  ball.radius = 9e-3;
  session.artifact.features.push_back(ball);
  for (const double side : {-1.0, 1.0}) {
    Observation contact = seenAt({side * 10e-3, 0.0, 0.0}, ObservationKind::kContact, session);
    contact.feature = 0;
    contact.approach = Eigen::Vector3d(-side, 0.0, 0.0);
    session.observations.push_back(contact);
  }
  session.prepare();
  for (const auto& [at, along] : arrowsAlongX(session)) EXPECT_NEAR(std::abs(at), 9.0, 0.01) << along;
}

}  // namespace
}  // namespace mm
