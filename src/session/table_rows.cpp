#include "session/table_rows.h"

#include <algorithm>
#include <cmath>

#include "base/names_of.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "session/time_stamp.h"

namespace mm {

std::string rowFault(const Observation& o, const RowKinds& kinds, const Machine& machine) {
  if (kinds.measured() > 1)
    return "a row holds one of feature, length_mm, reference_*_mm and deviation_*; leave the others empty";
  if (kinds.measured() == 0)
    return "the row holds no measurement: feature, length, reference and deviation are all empty or have no "
           "column";
  if (kinds.length && !kinds.feature)
    return "length_mm: 'feature' must name the point of the artifact file from which it was measured";
  if (kinds.length && !kinds.setup && o.length <= 0.0)
    return "length_mm must be above 0; lengths that count from an unknown zero need a 'setup'";
  if (kinds.contact() && kinds.setup)
    return "'setup' belongs to rows with a length, a reference or a deviation";
  for (std::size_t j = 0; j < o.position.size(); ++j)
    if (std::isnan(o.position[j])) return "the reading of joint '" + machine.joints()[j].name + "' is empty";
  return "";
}

void setKind(Observation& o, const RowKinds& kinds) {
  o.kind = kinds.deviation   ? ObservationKind::kDeviation
           : kinds.length    ? ObservationKind::kLength
           : kinds.reference ? ObservationKind::kPosition
                             : ObservationKind::kContact;
  if (o.kind == ObservationKind::kDeviation) return;
  o.deviation.clear();
  o.deviationStd.clear();
}

FeatureNames::FeatureNames(const Artifact& artifact, const TableForm& form)
    : form_(form), artifact_(artifact) {
  for (std::size_t i = 0; i < artifact.features.size(); ++i)
    index_[artifact.features[i].name] = static_cast<int>(i);
  for (std::size_t i = 0; !form.own && i < artifact.features.size(); ++i)
    index_.emplace(lower(artifact.features[i].name), static_cast<int>(i));
}

int FeatureNames::find(std::string_view name) const {
  const std::string key = renamed(name);
  auto found = index_.find(key);
  if (found == index_.end() && !form_.own) found = index_.find(lower(key));
  return found == index_.end() ? -1 : found->second;
}

std::string FeatureNames::fault(std::string_view name) const {
  const std::string key = renamed(name);
  const std::vector<std::string> names = allNames(artifact_.features);
  return "feature '" + shownText(key) + "' is not in artifact '" + artifact_.name + "'" +
         didYouMean(key, names) +
         (form_.own ? ""
                    : "; if it is one of them, add to the mapping: features: {" + shownText(key) + ": " +
                          (names.empty() ? "ball" : names.front()) + "}");
}

std::string FeatureNames::renamed(std::string_view name) const {
  const auto other = form_.features.find(std::string(name));
  return other != form_.features.end() ? other->second : std::string(name);
}

void LoggedSeries::add(std::size_t series, std::int64_t stamp, double value) {
  if (logged_.size() <= series) logged_.resize(series + 1);
  logged_[series].push_back({stamp, value});
}

void LoggedSeries::fill(std::vector<Series>& series, std::int64_t zero) {
  const auto earlier = [](const Logged& a, const Logged& b) { return a.stamp < b.stamp; };
  for (std::size_t i = 0; i < logged_.size(); ++i) {
    if (!std::is_sorted(logged_[i].begin(), logged_[i].end(), earlier))
      std::stable_sort(logged_[i].begin(), logged_[i].end(), earlier);
    for (const Logged& l : logged_[i]) {
      series[i].time.push_back(secondsBetween(zero, l.stamp));
      series[i].value.push_back(l.value);
    }
    std::vector<Logged>().swap(logged_[i]);
  }
}

}  // namespace mm
