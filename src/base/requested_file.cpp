#include "base/requested_file.h"

#include <cstdint>
#include <system_error>

#include "base/error.h"

namespace mm {
namespace {

constexpr std::uintmax_t kLargest = 1 << 20;  // bytes
constexpr std::size_t kLongestPath = 4096;

}  // namespace

bool namesFile(const std::string& text) {
  std::error_code failed;
  return text.find('\n') == std::string::npos && text.size() < kLongestPath &&
         std::filesystem::is_regular_file(text, failed) && !failed;
}

std::filesystem::path requestedYaml(const std::string& path, const std::string& what) {
  const std::string shown = "'" + path.substr(0, 200) + "'";
  if (!namesFile(path))
    throw InputError(what + " " + shown + " is no file, seen from " +
                     std::filesystem::current_path().string() + "; give a whole path");
  const std::string kind = std::filesystem::path(path).extension();
  std::error_code failed;
  const std::uintmax_t size = std::filesystem::file_size(path, failed);
  if ((kind != ".yaml" && kind != ".yml") || failed || size > kLargest)
    throw InputError(what + " " + shown + " is no " + what +
                     " file: its name ends in .yaml, and it is short");
  return path;
}

}  // namespace mm
