#include "effects/angular_motion.h"

#include "base/legendre.h"
#include "effects/catalogue_effect.h"
#include "effects/quantity.h"
#include "effects/tilt.h"

namespace mm {
namespace {

constexpr int kHighestDegree = 5;
constexpr double kAcross = 0.7;  // cosine between a direction and an axis: with a larger one it is not across

class AngularMotion : public CatalogueEffect {
 public:
  explicit AngularMotion(SpecReader& read)
      : CatalogueEffect(read, Stage::kVolume),
        axis_(read.joint("axis")),
        scaled_(read.domain(), axis_),
        about_(read.axisOf("about")) {
    degree_ = read.integer("degree", 1, kHighestDegree, 1);
    name_ = read.canonical().text("axis");
    parameters_ = {parameter("angle", kUnitArcsecond, kArcsecond, 0.02)};
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    addTilt(layout_, about_, state, 0, p[0], legendre(degree_, scaled_(state)), sink);
  }

  std::vector<std::string> shapeKeys() const override { return {"degree"}; }
  /// Further degrees; and a carriage turns about a place of its own, not about the origin: beside the angle
  /// there is a displacement of the same degree in the directions across `about`.
  std::vector<ShapeFreedom> freedom(const Domain& domain) const override {
    constexpr double kPlace = 0.3;  // of the Abbe offsets: from where it turns to where the artifact stands
    std::vector<ShapeFreedom> all = otherValues(spec(), "degree", degree_, 1, kHighestDegree, 1);
    for (const Joint& joint : domain.joints) {
      if (joint.kind != JointKind::kLinear || std::abs(joint.axis[about_]) > kAcross) continue;
      const bool own = joint.name == name_;
      EffectSpec shift(degree_ > 1 ? (own ? "positioning_polynomial" : "straightness")
                                   : (own ? "scale" : "squareness"));
      shift.set("axis", degree_ > 1 ? name_ : joint.name);
      if (!own) shift.set(degree_ > 1 ? "direction" : "of", degree_ > 1 ? joint.name : name_);
      if (degree_ > 1) shift.set("degree", degree_);
      all.push_back({shift, kPlace});
    }
    return all;
  }
  std::vector<int> mustMove() const override { return {axis_}; }

  std::string cause() const override {
    return "Angular error motion of " + name_ + " about " + axisName(about_) +
           " (roll, pitch or yaw): with the Abbe offset of the probe as its lever it becomes a displacement.";
  }
  std::string remedy() const override {
    return "Check preload and straightness of the guideway of " + name_ +
           "; keep the Abbe offset small: scale in line with the measurement, measuring point close to the "
           "guideway.";
  }
  std::string shownBy() const override {
    return "Contacts at different Abbe offsets (distances from the axis " + axisName(about_) +
           "), over the whole travel of " + name_ + ".";
  }

 private:
  int axis_;
  ScaledPosition scaled_;
  int about_, degree_ = 1;
  std::string name_;
};

}  // namespace

EffectType angularMotionType() {
  return effectType<AngularMotion>("angular_motion", {"axis", "about", "degree"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const std::string& joint : jointNames(domain, JointKind::kLinear))
      for (int about = 0; about < 3; ++about)
        for (int degree = 1; degree <= kHighestDegree; ++degree) {
          specs.push_back(EffectSpec("angular_motion").set("axis", joint).set("about", axisName(about)));
          if (degree > 1) specs.back().set("degree", degree);
        }
    return specs;
  });
}

}  // namespace mm
