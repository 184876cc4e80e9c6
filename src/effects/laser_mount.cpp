#include <cmath>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"
#include "effects/special_laws.h"

namespace mm {
namespace {

/// LASER eq. (7): q0 = Q10 + R21 (R32 (t R43 + Q43) + Q32), R21 turned by theta_B + omega_B, Q32 = (0, y32,
/// 0), R43 the unit vector along (l, m, n). The nominal chain has the same form: the difference goes to the
/// slots.
class LaserMount : public CatalogueEffect {
 public:
  explicit LaserMount(SpecReader& read) : CatalogueEffect(read, Stage::kProbe) {
    const Domain& domain = read.domain();
    zero_ = domain.probeZero;
    toTip_ = domain.probeRotation.transpose();
    const int b = domain.findJoint("b"), a = domain.findJoint("a");
    if (b >= 0 && a >= 0 && domain.joints[b].kind == JointKind::kRotary &&
        domain.joints[a].kind == JointKind::kRotary) {
      b_ = b;
      a_ = a;
      y32_ = domain.joints[a].origin.y();
      parameters_.push_back(parameter("omega_B", kUnitDegree, 1e-3, 0.2));
      parameters_.push_back(parameter("y32", kUnitMillimetre, 1e-4, 0.05, y32_));
    }
    first_ = parameterCount();
    for (int k = 0; k < 3; ++k)
      parameters_.push_back(parameter(std::string{"xyz"[k]} + "43", kUnitMillimetre, 1e-4, 0.05, zero_[k]));
    penalty_ = read.number("penalty", 0.0, 1e12, 0.0);
    nature_.linear = false;
    nature_.startTells = true;
    nature_.unitVectorPenalty = penalty_;
    if (domain.laser) addBeam(domain);
    for (int k = 0; k < parameterCount(); ++k) nature_.choosesFrame.push_back(k);
  }

  void evaluate(const State&, const double* p, ErrorSink& sink) const override {
    if (a_ >= 0) {
      sink.add(layout_.axis(b_), 0, p[0], 1.0);
      sink.value(layout_.jointTranslation(a_, 1), p[1] - y32_);
      if (sink.wantsDerivatives()) sink.derivative(layout_.jointTranslation(a_, 1), 1, 1.0);
    }
    const Eigen::Vector3d moved = toTip_ * (Eigen::Map<const Eigen::Vector3d>(p + first_) - zero_);
    put(sink, layout_.probe(0), first_, moved, toTip_);
    if (beam_ < 0) return;
    const Eigen::Map<const Eigen::Vector3d> lmn(p + beam_);
    if (penalty_ > 0.0) {
      put(sink, layout_.beam(0), beam_, toTip_ * lmn - Eigen::Vector3d::UnitZ(), toTip_);
      return;
    }
    const double norm = lmn.norm();
    const Eigen::Vector3d unit =
        norm > 0.0 ? Eigen::Vector3d(lmn / norm) : Eigen::Vector3d::Constant(kUnknown);
    const Eigen::Matrix3d across = (Eigen::Matrix3d::Identity() - unit * unit.transpose()) / norm;
    Eigen::Vector3d turned = toTip_ * unit;
    turned.z() = turned.z() > 0.0
                     ? -turned.head<2>().squaredNorm() / (1.0 + turned.z())  // z - 1, all its digits
                     : turned.z() - 1.0;
    put(sink, layout_.beam(0), beam_, turned, toTip_ * across);
  }

 private:
  void addBeam(const Domain& domain) {
    beam_ = parameterCount();
    nature_.unitVectors = {beam_};
    for (int k = 0; k < 3; ++k)
      parameters_.push_back(
          parameter(std::string{"lmn"[k]}, {"1", 1.0}, 1e-2, 1.0, domain.probeRotation(k, 2)));
  }

  static void put(ErrorSink& sink, int slot, int parameter, const Eigen::Vector3d& value,
                  const Eigen::Matrix3d& slope) {
    for (int k = 0; k < 3; ++k) {
      sink.value(slot + k, value[k]);
      if (!sink.wantsDerivatives()) continue;
      for (int i = 0; i < 3; ++i) sink.derivative(slot + k, parameter + i, slope(k, i));
    }
  }

  int b_ = -1, a_ = -1, first_ = 0, beam_ = -1;
  double penalty_ = 0.0;                                 // M of LASER (11); 0: a unit vector by constraint
  double y32_ = 0.0;                                     // nominal, m
  Eigen::Vector3d zero_ = Eigen::Vector3d::Zero();       // nominal, m, frame of the last joint
  Eigen::Matrix3d toTip_ = Eigen::Matrix3d::Identity();  // from the frame of the last joint to probe_tip
};

}  // namespace

EffectType laserMountType() {
  return effectType<LaserMount>("laser_mount", {"penalty"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    if (domain.laser) specs.emplace_back("laser_mount");
    return specs;
  });
}

}  // namespace mm
