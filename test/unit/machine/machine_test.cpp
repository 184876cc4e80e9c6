#include "machine/machine.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <random>

#include "base/error.h"
#include "base/rotation.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr double kTouch = std::numeric_limits<double>::quiet_NaN();

/// LASER eq. (7), written out as printed, in the convention of the table that moves: readings x, y, z in m.
Eigen::Vector3d laserEquation(const Eigen::Vector3d& reading, double a, double b, double t, double y32,
                              const Eigen::Vector3d& q43, const Eigen::Vector3d& lmn) {
  Eigen::Matrix3d r21, r32;
  r21 << std::cos(b), std::sin(b), 0, -std::sin(b), std::cos(b), 0, 0, 0, 1;
  r32 << 1, 0, 0, 0, std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a);
  const Eigen::Vector3d q10(-reading.x(), -reading.y(), reading.z()), q32(0, y32, 0);
  return q10 + r21 * (r32 * (t * lmn + q43) + q32);
}

constexpr const char* kMiddle = R"(<robot name="m">
  <link name="base"/><link name="table"/><link name="workpiece"/><link name="column"/><link name="arm"/><link name="probe_tip"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="table"/>
    <origin xyz="0.3 -0.1 0.2" rpy="0.1 0.2 0.3"/><axis xyz="0 0.6 0.8"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="slide" type="prismatic"><parent link="table"/><child link="workpiece"/>
    <origin xyz="0.05 0.06 0.07" rpy="-0.2 0.4 0.1"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="lift" type="prismatic"><parent link="base"/><child link="column"/>
    <origin xyz="-0.2 0.1 0.4" rpy="0.3 -0.1 0.2"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="swing" type="continuous"><parent link="column"/><child link="arm"/>
    <origin xyz="0.1 0.2 -0.1" rpy="0.5 0.1 -0.3"/><axis xyz="0 1 0"/></joint>
  <joint name="mount" type="fixed"><parent link="arm"/><child link="probe_tip"/><origin xyz="0.01 0.02 0.15" rpy="0.2 0 0.1"/></joint>
</robot>)";

TEST(ThreeAxis, positiveReadingsMoveTheTipAlongTheWorkpiece) {
  const Machine machine = Machine::load("three_axis");
  ASSERT_EQ(machine.jointCount(), 3);
  EXPECT_EQ(machine.joints()[1].name, "y");
  EXPECT_DOUBLE_EQ(machine.joints()[1].upper, 0.035);
  const double q[] = {0.001, -0.002, 0.003};
  const ProbePose pose = machine.nominal(q, kTouch);
  EXPECT_LT((pose.position - Eigen::Vector3d(0.001, -0.002, 0.003)).norm(), 1e-15);
  EXPECT_LT((pose.orientation - Eigen::Matrix3d::Identity()).norm(), 1e-15);
  EXPECT_EQ(machine.findJoint("z"), 2);
  EXPECT_EQ(machine.findJoint("b"), -1);
}

TEST(FiveAxis, isLaserEquation7) {
  const Machine machine = Machine::load("five_axis");
  ASSERT_EQ(machine.jointCount(), 5);
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < 50; ++i) {
    double q[5];
    for (int j = 0; j < 5; ++j) {
      const Joint& joint = machine.joints()[j];
      q[machine.findJoint(joint.name)] = joint.kind == JointKind::kLinear ? 0.1 * u(random) : 1.5 * u(random);
    }
    const double t = 1e-3 * u(random);
    const double x = q[machine.findJoint("x")], y = q[machine.findJoint("y")], z = q[machine.findJoint("z")];
    const Eigen::Vector3d expected =
        laserEquation({x, y, z}, q[machine.findJoint("a")], q[machine.findJoint("b")], t, 0,
                      {0.120, 0.010, 0.020}, Eigen::Vector3d::UnitZ());
    EXPECT_LT((machine.nominal(q, t).position - expected).norm(), 1e-14);
  }
}

TEST(FiveAxis, mountErrorsOfThePaperLeaveTheFigureOfItsTable2) {
  const Machine machine = Machine::load("five_axis");
  const ErrorLayout at = machine.layout();
  const int a = machine.findJoint("a"), b = machine.findJoint("b");
  std::vector<double> errors(at.size(), 0.0);
  errors[at.axis(b)] = -0.15446 * kDegree;
  errors[at.jointTranslation(a, 1)] = -0.0544e-3;
  const Eigen::Vector3d probe =
      Eigen::Vector3d(120.0563, 10.3326, 19.5227) * 1e-3 - Eigen::Vector3d(0.120, 0.010, 0.020);
  const Eigen::Vector3d beam = Eigen::Vector3d(0.0267, 0.0405, 0.9988) - Eigen::Vector3d::UnitZ();
  for (int k = 0; k < 3; ++k) {
    errors[at.probe(k)] = probe[k];
    errors[at.beam(k)] = beam[k];
  }
  struct Row {
    double t, a, b;
    Eigen::Vector3d s1;
  };
  const Row table[] = {{0.0, 0, 0, {0.001743, 0.002189, -4.725415}},
                       {0.2, 90, 0, {0.088509, -30.046754, 4.432010}},
                       {0.4, -90, 0, {-0.012881, 9.609871, 25.132104}},
                       {0.6, 90, 90, {-139.878714, -130.717940, 4.430974}}};
  const Eigen::Vector3d s0 = Eigen::Vector3d(120.0261, 10.5916, 14.7853) * 1e-3;
  double squares = 0.0;
  for (const Row& row : table) {
    double q[5];
    q[machine.findJoint("x")] = row.s1.x() * 1e-3;
    q[machine.findJoint("y")] = row.s1.y() * 1e-3;
    q[machine.findJoint("z")] = row.s1.z() * 1e-3;
    q[a] = row.a * kDegree;
    q[b] = row.b * kDegree;
    squares += (machine.measure(q, row.t * 1e-3, errors.data()).position - s0).squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(squares / 12.0) / kMicrometre, 6.34, 0.1);
}

class Gradient : public testing::TestWithParam<std::tuple<const char*, bool, double>> {};

TEST_P(Gradient, agreesWithCentralDifferencesInEverySlot) {
  const auto [name, laser, size] = GetParam();
  const Machine machine = std::string(name) == "middle" ? Machine(kMiddle, name) : Machine::load(name);
  const ErrorLayout at = machine.layout();
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> u(-1, 1);
  std::vector<double> q;
  for (const Joint& joint : machine.joints())
    q.push_back((joint.kind == JointKind::kLinear ? 0.05 : 1.0) * u(random));
  const double reading = laser ? 0.7e-3 : kTouch;
  std::vector<double> errors(at.size());
  for (double& e : errors) e = size * u(random);
  Eigen::Matrix<double, 6, Eigen::Dynamic> gradient;
  machine.measure(q.data(), reading, errors.data(), &gradient);
  ASSERT_EQ(gradient.cols(), at.size());
  const double h = 1e-5;
  // The gradient leaves out products of two errors; a turn has a lever of at most 0.2 m.
  const double tolerance = 1e-9 + 2.0 * size;
  for (int slot = 0; slot < at.size(); ++slot) {
    std::vector<double> up = errors, down = errors;
    up[slot] += h;
    down[slot] -= h;
    const ProbePose high = machine.measure(q.data(), reading, up.data());
    const ProbePose low = machine.measure(q.data(), reading, down.data());
    const Eigen::Vector3d moved = (high.position - low.position) / (2 * h);
    const Eigen::Vector3d turned = rotationVectorOf(high.orientation * low.orientation.transpose()) / (2 * h);
    EXPECT_LT((gradient.col(slot).head<3>() - moved).norm(), tolerance) << "position, slot " << slot;
    EXPECT_LT((gradient.col(slot).tail<3>() - turned).norm(), tolerance) << "orientation, slot " << slot;
  }
}

INSTANTIATE_TEST_SUITE_P(Machines, Gradient,
                         testing::Combine(testing::Values("three_axis", "five_axis", "middle"),
                                          testing::Bool(), testing::Values(0.0, 1e-4)));

TEST(Measure, withoutErrorsIsNominal) {
  const Machine machine = Machine::load("five_axis");
  const double q[] = {0.1, 0.05, -0.02, 0.4, -0.9};
  const std::vector<double> none(machine.layout().size(), 0.0);
  for (const double reading : {kTouch, 0.0, 0.3e-3}) {
    const ProbePose nominal = machine.nominal(q, reading),
                    measured = machine.measure(q, reading, none.data());
    EXPECT_EQ((nominal.position - measured.position).norm(), 0.0);
    EXPECT_EQ((nominal.orientation - measured.orientation).norm(), 0.0);
  }
}

TEST(Measure, axisErrorsAreExactlyAddedToTheReading) {
  const Machine machine = Machine::load("five_axis");
  const double q[] = {0.1, 0.05, -0.02, 0.4, -0.9};
  std::vector<double> errors(machine.layout().size(), 0.0);
  double moved[5];
  for (int j = 0; j < 5; ++j) moved[j] = q[j] + (errors[machine.layout().axis(j)] = 0.01 * (j + 1));
  const ProbePose expected = machine.nominal(moved, kTouch),
                  measured = machine.measure(q, kTouch, errors.data());
  EXPECT_LT((expected.position - measured.position).norm(), 1e-15);
}

Eigen::Isometry3d origin(double x, double y, double z, double r, double p, double w) {
  return Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(w, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(p, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(r, Eigen::Vector3d::UnitX());
}

TEST(Measure, anErrorOfATablesAxisIsOnItsSideTowardsTheBed) {
  const Machine machine(kMiddle, "middle");
  ASSERT_EQ(machine.tableJoints(), 2);
  const int turn = machine.findJoint("turn");
  std::vector<double> q(4, 0.0), errors(machine.layout().size(), 0.0);
  const Eigen::Vector3d shift(3e-6, -2e-6, 5e-6), tilt(4e-6, 1e-6, -3e-6);
  for (int k = 0; k < 3; ++k) {
    errors[machine.layout().jointTranslation(turn, k)] = shift[k];
    errors[machine.layout().jointRotation(turn, k)] = tilt[k];
  }
  for (const double angle : {-0.9, 0.0, 0.7}) {
    q[turn] = angle;
    q[machine.findJoint("slide")] = 0.2;
    // the table from the bed: seat, error of the axis, rotation; the tip does not move with it
    const Eigen::Isometry3d seat = origin(0.3, -0.1, 0.2, 0.1, 0.2, 0.3);
    const Eigen::Isometry3d carried = Eigen::AngleAxisd(angle, Eigen::Vector3d(0.0, 0.6, 0.8)) *
                                      origin(0.05, 0.06, 0.07, -0.2, 0.4, 0.1) *
                                      Eigen::Translation3d(0.2, 0.0, 0.0);
    const Eigen::Isometry3d wrong =
        Eigen::Translation3d(shift) * Eigen::AngleAxisd(tilt.norm(), tilt.normalized());
    const Eigen::Vector3d tip = machine.nominal(q.data(), kTouch).position;
    const Eigen::Vector3d expected = (seat * wrong * carried).inverse() * (seat * carried * tip);
    EXPECT_LT((machine.measure(q.data(), kTouch, errors.data()).position - expected).norm(), 1e-10) << angle;
  }
}

TEST(Chain, mayHaveTheWorkpieceInTheMiddleOfTheTree) {
  const Machine machine(kMiddle, "middle");
  ASSERT_EQ(machine.jointCount(), 4);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < 20; ++i) {
    const double turn = u(random), slide = 0.2 * u(random), lift = 0.2 * u(random), swing = u(random);
    const Eigen::Isometry3d workpiece =
        origin(0.3, -0.1, 0.2, 0.1, 0.2, 0.3) * Eigen::AngleAxisd(turn, Eigen::Vector3d(0, 0.6, 0.8)) *
        origin(0.05, 0.06, 0.07, -0.2, 0.4, 0.1) * Eigen::Translation3d(slide, 0, 0);
    const Eigen::Isometry3d tip = origin(-0.2, 0.1, 0.4, 0.3, -0.1, 0.2) * Eigen::Translation3d(0, 0, lift) *
                                  origin(0.1, 0.2, -0.1, 0.5, 0.1, -0.3) *
                                  Eigen::AngleAxisd(swing, Eigen::Vector3d::UnitY()) *
                                  origin(0.01, 0.02, 0.15, 0.2, 0, 0.1);
    const Eigen::Isometry3d expected = workpiece.inverse() * tip;
    std::vector<double> q(4);
    q[machine.findJoint("turn")] = turn;
    q[machine.findJoint("slide")] = slide;
    q[machine.findJoint("lift")] = lift;
    q[machine.findJoint("swing")] = swing;
    const ProbePose pose = machine.nominal(q.data(), kTouch);
    EXPECT_LT((pose.position - expected.translation()).norm(), 1e-12);
    EXPECT_LT((pose.orientation - expected.linear()).norm(), 1e-12);

    const auto jacobian = machine.jacobian(q.data(), kTouch);
    for (int j = 0; j < 4; ++j) {
      const double h = 1e-6;
      std::vector<double> up = q, down = q;
      up[j] += h;
      down[j] -= h;
      const Eigen::Vector3d velocity =
          (machine.nominal(up.data(), kTouch).position - machine.nominal(down.data(), kTouch).position) /
          (2 * h);
      EXPECT_LT((jacobian.col(j).head<3>() - velocity).norm(), 1e-9);
    }
  }
}

std::string refusal(const std::string& urdf) {
  try {
    Machine(urdf, "mine");
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}

TEST(Urdf, isRefusedWithItsNameAndACause) {
  EXPECT_NE(refusal("not xml").find("'mine'"), std::string::npos);
  EXPECT_NE(refusal("<other/>").find("<robot>"), std::string::npos);
  EXPECT_NE(refusal("<robot name='r'><link name='workpiece'/></robot>").find("'probe_tip'"),
            std::string::npos);
  const std::string rigid =
      "<robot name='r'><link name='workpiece'/><link name='probe_tip'/><joint name='j' type='fixed'>"
      "<parent link='workpiece'/><child link='probe_tip'/></joint></robot>";
  EXPECT_NE(refusal(rigid).find("no moving joint"), std::string::npos);
  std::string many = "<robot name='r'><link name='workpiece'/>";
  for (int i = 0; i < 17; ++i) {
    const std::string parent = i == 0 ? "workpiece" : "l" + std::to_string(i),
                      child = i == 16 ? "probe_tip" : "l" + std::to_string(i + 1);
    many += "<link name='" + child + "'/><joint name='j" + std::to_string(i) +
            "' type='prismatic'><parent link='" + parent + "'/><child link='" + child +
            "'/><axis xyz='1 0 0'/><limit lower='0' upper='1' effort='1' velocity='1'/></joint>";
  }
  EXPECT_NE(refusal(many + "</robot>").find("17"), std::string::npos);
}

TEST(Load, namesWhatItCannotFind) {
  try {
    Machine::load("six_axis");
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("'six_axis'"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find("three_axis"), std::string::npos);
  }
  EXPECT_THROW(Machine::load("nowhere/machine.urdf"), InputError);
  EXPECT_EQ(Machine::load("three_axis.urdf", "urdf").jointCount(), 3);
}

}  // namespace
}  // namespace mm
