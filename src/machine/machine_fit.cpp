#include "machine/machine_fit.h"

#include <tinyxml2.h>

#include <vector>

#include "base/format.h"
#include "base/names_of.h"
#include "base/text.h"
#include "base/units.h"
#include "machine/iso230_axes.h"

namespace mm {
namespace {

constexpr double kSameDirection = 1e-9, kSamePlace = 1e-9;  // 1, m

std::string jointsOf(const Machine& machine) { return joined(allNames(machine.joints()), ", "); }

std::string placeText(const Eigen::Vector3d& v) {
  return format("(%.6g, %.6g, %.6g) mm", v.x() / kMillimetre, v.y() / kMillimetre, v.z() / kMillimetre);
}

std::string directionText(const Eigen::Vector3d& v) {
  return format("(%.6g, %.6g, %.6g)", v.x(), v.y(), v.z());
}

const char* kindText(const Joint& joint) { return joint.kind == JointKind::kLinear ? "linear" : "rotary"; }

/// What the URDF's `<robot>` says of the machine as a whole.
struct Stated {
  std::string name, serial;  // empty: not stated
};

Stated statedBy(const Machine& machine) {
  tinyxml2::XMLDocument document;
  if (document.Parse(machine.urdf().c_str(), machine.urdf().size()) != tinyxml2::XML_SUCCESS) return {};
  const tinyxml2::XMLElement* robot = document.FirstChildElement("robot");
  if (robot == nullptr) return {};
  Stated stated;
  if (const char* name = robot->Attribute("name")) stated.name = name;
  const tinyxml2::XMLElement* serial = robot->FirstChildElement("serial");
  if (serial != nullptr && serial->GetText() != nullptr) stated.serial = serial->GetText();
  return stated;
}

}  // namespace

std::string serialOf(const Machine& machine) { return statedBy(machine).serial; }

std::string differenceOf(const Machine& calibrated, const Machine& other, const std::string& there) {
  const Stated stated = statedBy(calibrated), otherwise = statedBy(other);
  const bool serials = !stated.serial.empty() && !otherwise.serial.empty();
  if (serials && stated.serial != otherwise.serial)
    return "its serial is '" + stated.serial + "', " + there + " '" + otherwise.serial + "'";
  if (jointsOf(calibrated) != jointsOf(other))
    return "it has the joints " + jointsOf(calibrated) + ", " + there + " there are " + jointsOf(other);
  const std::vector<Eigen::Matrix3d> sides = fixedSides(calibrated), otherSides = fixedSides(other);
  for (int j = 0; j < calibrated.jointCount(); ++j) {
    const Joint &a = calibrated.joints()[j], &b = other.joints()[j];
    const std::string joint = "joint " + a.name + " ";
    if (a.kind != b.kind) return joint + "is " + kindText(a) + ", " + there + " " + kindText(b);
    if ((sides[j] - otherSides[j]).norm() > kSameDirection)
      return joint + "is mounted turned otherwise than " + there;
    if ((a.axis - b.axis).norm() > kSameDirection)
      return joint + "moves along " + directionText(a.axis) + ", " + there + " along " +
             directionText(b.axis);
    if ((a.origin - b.origin).norm() > kSamePlace)
      return joint + "stands at " + placeText(a.origin) + ", " + there + " at " + placeText(b.origin);
  }
  if ((calibrated.tipTranslation() - other.tipTranslation()).norm() > kSamePlace)
    return "its probe's tip stands at " + placeText(calibrated.tipTranslation()) + ", " + there + " at " +
           placeText(other.tipTranslation());
  if ((calibrated.tipRotation() - other.tipRotation()).norm() > kSameDirection)
    return "its probe points otherwise than " + there;
  if (!serials && !stated.name.empty() && !otherwise.name.empty() && stated.name != otherwise.name)
    return "its URDF calls it '" + stated.name + "', " + there + " it is '" + otherwise.name + "'";
  return {};
}

}  // namespace mm
