#include "ros_bridge/package_folder.h"

#include <rospack/rospack.h>

#include <mutex>
#include <vector>

namespace mm {

std::filesystem::path packageFolder(const std::string& package) {
  static std::mutex mutex;
  const std::lock_guard<std::mutex> lock(mutex);
  rospack::Rospack packages;
  packages.setQuiet(true);
  std::vector<std::string> path;
  if (!packages.getSearchPathFromEnv(path)) return {};
  std::string folder;
  for (const bool force : {false, true}) {  // a list of packages that is older than the package is made anew
    packages.crawl(path, force);
    if (packages.find(package, folder)) return folder;
  }
  return {};
}

}  // namespace mm
