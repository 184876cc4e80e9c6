#include "report/web_files.h"

#include <filesystem>
#include <vector>

#include "base/error.h"
#include "calibration_file/atomic_file.h"

namespace mm {
namespace {

std::filesystem::path firstOf(const std::string& name, const std::vector<const char*>& folders) {
  for (const char* folder : folders)
    if (const std::filesystem::path path = std::filesystem::path(folder) / name;
        std::filesystem::is_regular_file(path))
      return path;
  return {};
}

}  // namespace

std::string webFile(const std::string& name) {
  const std::filesystem::path path = firstOf(name, {MM_SOURCE_WEB, MM_INSTALLED_WEB});
  if (path.empty())
    throw InputError("the page's " + name + " is neither in " + MM_SOURCE_WEB + " nor in " +
                     MM_INSTALLED_WEB + "; install the package again");
  return readFile(path);
}

std::string fetchedFile(const std::string& name) {
  const std::filesystem::path path = firstOf(name, {MM_BUILD_WEB, MM_INSTALLED_WEB});
  return path.empty() ? std::string() : readFile(path);
}

std::string whyNotFetched(const std::string& key) {
  const std::filesystem::path path = firstOf(key + "_missing.txt", {MM_BUILD_WEB});
  const std::string why = path.empty() ? std::string() : readFile(path).substr(0, 400);
  return why.substr(0, why.find('\n'));
}

}  // namespace mm
