#pragma once
#include <map>
#include <string>
#include <string_view>
#include <unordered_map>

#include "session/session.h"

namespace mm {

/// Finds the features of an artifact by the names that a file gives them.
class FeatureNames {
 public:
  /// @param anyCase as in somebody else's file. @param renamed names in the file -> names in the artifact.
  void take(const Artifact& artifact, bool anyCase, const std::map<std::string, std::string>& renamed);
  /// Index in the artifact, or -1.
  int find(std::string_view name) const;
  bool has(std::string_view name) const { return find(name) >= 0; }
  /// Why a name that is not found is refused, with the remedy.
  std::string fault(std::string_view name, const Artifact& artifact) const;

 private:
  bool anyCase_ = false;
  std::map<std::string, std::string> renamed_;
  std::unordered_map<std::string, int> index_;
};

}  // namespace mm
