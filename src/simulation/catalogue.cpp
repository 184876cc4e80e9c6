#include "simulation/catalogue.h"

#include "simulation/catalogue_parts.h"

namespace mm {

Direction directionOf(const Machine& machine, const std::string& name) {
  const int joint = machine.findJoint(name);
  return {joint, joint >= 0 ? -1 : name[0] - 'x'};
}

Eigen::Vector3d Making::unitVector(const std::string& key) const {
  return Eigen::Vector3d::Unit(source.key(key)[0] - 'x');
}

Direction Making::direction() const { return directionOf(workshop.machine, source.key("direction")); }

Tilt Making::tilt() const { return {source.key("lever") == "chain" ? joint() : -1, unitVector("about")}; }

const std::vector<SourceKind>& sourceKinds() {
  static const source_kinds::Kinds kinds = [] {
    source_kinds::Kinds all;
    for (const source_kinds::Kinds& group :
         {source_kinds::screw(), source_kinds::guideway(), source_kinds::structure(), source_kinds::probe(),
          source_kinds::rotary()})
      all.insert(all.end(), group.begin(), group.end());
    return all;
  }();
  return kinds;
}

}  // namespace mm
