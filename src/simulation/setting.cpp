#include "simulation/setting.h"

#include <algorithm>
#include <memory>

namespace mm {

Setting::Setting(const HiddenSource& hidden, const Workshop& w)
    : source(hidden), lower(w.lower), upper(w.upper) {
  const std::vector<TrueCovariate>& logged = w.settings.covariates;
  for (const auto& [key, value] : source.keys) {
    const auto covariate = std::find_if(logged.begin(), logged.end(),
                                        [&v = value](const TrueCovariate& c) { return c.name == v; });
    named.push_back({key, w.machine.findJoint(value), w.thermal.findBody(value),
                     covariate == logged.end() ? -1 : static_cast<int>(covariate - logged.begin()),
                     value.empty() ? -1 : value[0] - 'x'});
  }
  for (int j = 0; j < w.machine.jointCount(); ++j) axes.push_back(w.chain.axis(j));
  for (const TrueCovariate& covariate : logged) covariateMeans.push_back(covariate.mean);
}

const Setting::Named& Setting::at(const std::string& key) const {
  return *std::find_if(named.begin(), named.end(), [&](const Named& n) { return n.key == key; });
}

double Instant::position(const std::string& key) const {
  const int j = joint(key);
  return now.drive[j] - 0.5 * (setting.lower[j] + setting.upper[j]);
}

double Instant::change(const std::string& key) const {
  const int covariate = setting.at(key).covariate;
  return now.covariates[covariate] - setting.covariateMeans[covariate];
}

Eigen::Vector3d Instant::unitVector(const std::string& key) const {
  return Eigen::Vector3d::Unit(setting.at(key).component);
}

Direction Instant::direction() const {
  const Setting::Named& named = setting.at("direction");
  return {named.joint, named.component};
}

Tilt Instant::tilt() const {
  return {setting.source.key("lever") == "chain" ? joint() : -1, unitVector("about")};
}

void Making::add(SourceLaw law) const {
  workshop.physics.sources.push_back(
      [law = std::move(law), setting = std::make_shared<const Setting>(source, workshop)](const Condition& c,
                                                                                          Distortion& d) {
        law({*setting, c}, d);
      });
}

}  // namespace mm
