// Error models of the papers, as they print them.
#include <cmath>

#include "effects/law.h"
#include "effects/quantity.h"

namespace mm {
namespace {

double power(double value, int exponent) {
  return exponent == 0 ? 1.0 : exponent == 1 ? value : value * value;
}

/// MMT eq. (13), one line of it: for X with the other axes Y and Z
///   Cxx1 X + X^a (S sin(k X/Pr) + K cos(k X/Pr)) + Cyx Y^n + Czx Z^n + Y cos(pi/2 + alpha_yx) + Z cos(pi/2 +
///   alpha_zx),
/// with C2 and phi as S = C2 cos(phi), K = C2 sin(phi). Lengths in m, alpha in rad.
Law mmtDeviation(SpecReader& read) {
  const int axis = read.joint("axis", JointKind::kLinear), slot = read.layout().axis(axis);
  const Domain& domain = read.domain();
  std::vector<int> others;
  for (int j = 0; j < static_cast<int>(domain.joints.size()); ++j)
    if (j != axis && domain.joints[j].kind == JointKind::kLinear) others.push_back(j);
  if (others.size() != 2)
    read.fail("mmt_deviation needs a machine with three linear joints; use scale, squareness and the others");
  const double lead = read.number("lead_mm", 1e-4, 1e4) * kMillimetre;
  const int exponent = read.integer("exponent", 1, 2, 2),
            amplitudeExponent = read.integer("amplitude_exponent", 0, 1, 1);
  const double waveNumber = (read.choice("argument", {"2pi", "1"}) == "2pi" ? 2.0 * kPi : 1.0) / lead;  // 1/m

  const std::string name = domain.joints[axis].name;
  const Unit one{"1", 1.0}, perMetre{"1/m", 1.0};
  Law law;
  law.parameters.push_back(parameter("C" + name + name + "1", one, 1e-4, 0.02));
  for (const char* letter : {"S", "K"})
    law.parameters.push_back(amplitudeExponent == 1
                                 ? parameter(letter + name + name, one, 1e-4, 0.02)
                                 : parameter(letter + name + name, kUnitMicrometre, 1e-6, 1e-3));
  for (const int j : others)
    law.parameters.push_back(exponent == 2
                                 ? parameter("C" + domain.joints[j].name + name, perMetre, 5e-3, 2.0)
                                 : parameter("C" + domain.joints[j].name + name, one, 1e-4, 0.02));
  for (const int j : others)
    law.parameters.push_back(parameter("alpha_" + domain.joints[j].name + name, kUnitArcsecond, 1e-4, 0.02));
  law.add = [=](const State& s, const double* p, ErrorSink& sink) {
    const double q = s.position[axis];
    const double amplitude = power(q, amplitudeExponent), phase = waveNumber * q;
    const double sine = std::sin(phase), cosine = std::cos(phase);
    sink.add(slot, 0, p[0], q);
    sink.add(slot, 1, p[1], amplitude * sine);
    sink.add(slot, 2, p[2], amplitude * cosine);
    for (int i = 0; i < 2; ++i) {
      const double other = s.position[others[i]];
      sink.add(slot, 3 + i, p[3 + i], power(other, exponent));
      // cos(pi/2 + alpha) = -sin(alpha)
      const double alpha = p[5 + i], sineOf = std::sin(alpha), cosineOf = std::cos(alpha);
      sink.value(slot, -sineOf * other);
      if (sink.wantsDerivatives()) sink.derivative(slot, 5 + i, -cosineOf * other);
    }
  };
  law.coefficient = [](int parameter, double value) { return parameter < 5 ? value : std::sin(value); };
  law.nature.linear = false;
  law.nature.separable = true;
  law.nature.composite = true;
  law.nature.nonlinear = law.nature.choosesFrame = {5, 6};  // alpha
  law.nature.searchStarts = {{0.0, 0.0}};
  law.nature.shapeKeys = {"lead_mm", "exponent", "amplitude_exponent", "argument"};
  law.nature.mustMove = {axis};
  // Whatever the order in which the effects are listed: alpha of an axis by one before it is zero
  // (alpha_xy, alpha_xz, alpha_yz).
  for (int i = 0; i < 2; ++i)
    if (others[static_cast<std::size_t>(i)] < axis) law.nature.zeroByConvention.push_back(5 + i);
  return law;
}

void put(ErrorSink& sink, int slot, int parameter, const Eigen::Vector3d& value,
         const Eigen::Matrix3d& slope) {
  for (int k = 0; k < 3; ++k) {
    sink.value(slot + k, value[k]);
    if (!sink.wantsDerivatives()) continue;
    for (int i = 0; i < 3; ++i) sink.derivative(slot + k, parameter + i, slope(k, i));
  }
}

/// LASER eq. (7): q0 = Q10 + R21 (R32 (t R43 + Q43) + Q32), R21 turned by theta_B + omega_B, Q32 = (0, y32,
/// 0), R43 the unit vector along (l, m, n), with absolute parameters that start at the nominal chain: omega_B
/// (rad) added to the reading of joint b, y32 (m) offset of joint a along y of its fixed side, Q43 (m) probe
/// zero and (l, m, n) beam direction in the frame of the last joint. Without rotary joints b and a: no
/// omega_B and y32; without a laser: no (l, m, n). The nominal chain has the same form: the difference goes
/// to the slots.
Law laserMount(SpecReader& read) {
  const Domain& domain = read.domain();
  const int b = domain.findJoint("b"), a = domain.findJoint("a");
  const bool rotary = b >= 0 && a >= 0 && domain.joints[b].kind == JointKind::kRotary &&
                      domain.joints[a].kind == JointKind::kRotary;
  Law law;
  law.nature.stage = Stage::kProbe;
  const double y32 = rotary ? domain.joints[a].origin.y() : 0.0;  // nominal, m
  if (rotary)
    law.parameters = {parameter("omega_B", kUnitDegree, 1e-3, 0.2),
                      parameter("y32", kUnitMillimetre, 1e-4, 0.05, y32)};
  const int first = static_cast<int>(law.parameters.size());
  const Eigen::Vector3d zero = domain.probeZero;
  for (int k = 0; k < 3; ++k)
    law.parameters.push_back(parameter(std::string{"xyz"[k]} + "43", kUnitMillimetre, 1e-4, 0.05, zero[k]));
  const double penalty = read.number("penalty", 0.0, 1e12, 0.0);  // M of LASER (11); 0: a constraint
  const int beam = domain.laser ? first + 3 : -1;
  if (domain.laser) {
    law.nature.unitVectors = {beam};
    for (int k = 0; k < 3; ++k)
      law.parameters.push_back(
          parameter(std::string{"lmn"[k]}, {"1", 1.0}, 1e-2, 1.0, domain.probeRotation(k, 2)));
  }
  law.nature.linear = false;
  law.nature.startTells = true;
  law.nature.unitVectorPenalty = penalty;
  for (std::size_t k = 0; k < law.parameters.size(); ++k)
    law.nature.choosesFrame.push_back(static_cast<int>(k));
  // from the frame of the last joint to probe_tip
  const Eigen::Matrix3d toTip = domain.probeRotation.transpose();
  law.add = [=, layout = read.layout()](const State&, const double* p, ErrorSink& sink) {
    if (rotary) {
      sink.add(layout.axis(b), 0, p[0], 1.0);
      sink.value(layout.jointTranslation(a, 1), p[1] - y32);
      if (sink.wantsDerivatives()) sink.derivative(layout.jointTranslation(a, 1), 1, 1.0);
    }
    const Eigen::Vector3d moved = toTip * (Eigen::Map<const Eigen::Vector3d>(p + first) - zero);
    put(sink, layout.probe(0), first, moved, toTip);
    if (beam < 0) return;
    const Eigen::Map<const Eigen::Vector3d> lmn(p + beam);
    if (penalty > 0.0) {
      put(sink, layout.beam(0), beam, toTip * lmn - Eigen::Vector3d::UnitZ(), toTip);
      return;
    }
    const double norm = lmn.norm();
    const Eigen::Vector3d unit =
        norm > 0.0 ? Eigen::Vector3d(lmn / norm) : Eigen::Vector3d::Constant(kUnknown);
    const Eigen::Matrix3d across = (Eigen::Matrix3d::Identity() - unit * unit.transpose()) / norm;
    Eigen::Vector3d turned = toTip * unit;
    turned.z() = turned.z() > 0.0
                     ? -turned.head<2>().squaredNorm() / (1.0 + turned.z())  // z - 1, all its digits
                     : turned.z() - 1.0;
    put(sink, layout.beam(0), beam, turned, toTip * across);
  };
  return law;
}

}  // namespace

std::vector<LawRow> lawsOfPapers() {
  return {
      compositeRow({"axis", "lead_mm", "exponent", "amplitude_exponent", "argument"}, mmtDeviation,
                   {EffectSpec("mmt_deviation").set("axis", "x").set("lead_mm", 2)}),
      {"laser_mount",
       {"penalty"},
       {},
       [](const EffectSpec&, const Domain& domain) { return domain.laser; },
       laserMount},
  };
}

}  // namespace mm
