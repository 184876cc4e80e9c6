#pragma once
#include <filesystem>
#include <string>

namespace mm {

/// Measurements by others, beside the repository or above it (a worktree); empty path when they are not
/// there.
inline std::filesystem::path sharedData(const std::string& name) {
  for (const char* folder : {"../shared/data", "../../shared/data"})
    if (const std::filesystem::path path = std::filesystem::path(folder) / name;
        std::filesystem::exists(path))
      return path;
  return {};
}

}  // namespace mm

#define MM_NEEDS_SHARED_DATA(variable, name)                                \
  const std::filesystem::path variable = mm::sharedData(name);              \
  if (variable.empty()) {                                                   \
    std::cout << "skipped: ../shared/data/" << (name) << " is not there\n"; \
    GTEST_SKIP() << "../shared/data/" << (name) << " is not there";         \
  }
