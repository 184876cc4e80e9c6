#include "session/feature_names.h"

#include <vector>

#include "base/nearest_name.h"
#include "base/text.h"

namespace mm {

void FeatureNames::take(const Artifact& artifact, bool anyCase,
                        const std::map<std::string, std::string>& renamed) {
  anyCase_ = anyCase;
  renamed_ = renamed;
  for (std::size_t i = 0; i < artifact.features.size(); ++i)
    index_[artifact.features[i].name] = static_cast<int>(i);
  for (std::size_t i = 0; anyCase && i < artifact.features.size(); ++i)
    index_.emplace(lower(artifact.features[i].name), static_cast<int>(i));
}

int FeatureNames::find(std::string_view name) const {
  std::string key(name);
  if (const auto renamed = renamed_.find(key); renamed != renamed_.end()) key = renamed->second;
  auto found = index_.find(key);
  if (found == index_.end() && anyCase_) found = index_.find(lower(key));
  return found == index_.end() ? -1 : found->second;
}

std::string FeatureNames::fault(std::string_view name, const Artifact& artifact) const {
  std::string key(name);
  if (const auto renamed = renamed_.find(key); renamed != renamed_.end()) key = renamed->second;
  std::vector<std::string> names;
  for (const Feature& f : artifact.features) names.push_back(f.name);
  return "feature '" + key + "' is not in artifact '" + artifact.name + "'" + didYouMean(key, names) +
         (anyCase_ ? "; if it is one of them, write into the mapping: features: {" + key + ": " +
                         (names.empty() ? "ball" : names.front()) + "}"
                   : "");
}

}  // namespace mm
