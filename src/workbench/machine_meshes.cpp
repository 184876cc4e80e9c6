#include "workbench/machine_meshes.h"

#include <tinyxml2.h>

#include <algorithm>
#include <cstdint>

#include "base/error.h"
#include "base/json_text.h"
#include "base/read_file.h"
#include "base/text.h"

namespace mm {
namespace {

constexpr std::size_t kMostMeshes = 64;
constexpr std::size_t kMostBytes = 16u << 20;  // of all meshes together
/// What is read as text holds up the page, whose heartbeat must come within 0.9 s, or the machine stops.
constexpr std::uintmax_t kLargestText = 2u << 20;
const std::string kPackageScheme = "package://", kFileScheme = "file://";

void collectNames(const tinyxml2::XMLElement* element, bool visual, std::vector<std::string>& names) {
  for (; element != nullptr; element = element->NextSiblingElement()) {
    const std::string kind = element->Name();
    const char* name = element->Attribute("filename");
    if (visual && kind == "mesh" && name != nullptr &&
        std::find(names.begin(), names.end(), name) == names.end())
      names.emplace_back(name);
    collectNames(element->FirstChildElement(), visual || kind == "visual", names);
  }
}

bool isWithin(const std::filesystem::path& file, const std::filesystem::path& folder) {
  const auto ends = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  return ends.first == folder.end();
}

std::filesystem::path inPackage(const std::string& name, const PackageFolder& packages) {
  const std::string rest = name.substr(kPackageScheme.size());
  const std::size_t slash = rest.find('/');
  const std::string package = rest.substr(0, slash);
  if (slash == std::string::npos || package.empty())
    throw InputError("names no file; write package://<package>/<path within it>");
  const std::filesystem::path folder = packages ? packages(package) : std::filesystem::path();
  if (folder.empty())
    throw InputError("no package '" + package.substr(0, 80) +
                     "' is known; source the workspace that contains it");
  std::error_code failed;
  const std::filesystem::path home = std::filesystem::canonical(folder, failed);
  if (failed) throw InputError("the folder of the package cannot be read: " + failed.message());
  const std::filesystem::path within = std::filesystem::path(rest.substr(slash)).relative_path();
  const std::filesystem::path file = std::filesystem::canonical(home / within, failed);
  if (failed == std::errc::no_such_file_or_directory)
    throw InputError("the package has no such file; correct the URDF, or add the file");
  if (failed) throw InputError("cannot be read: " + failed.message());
  if (!isWithin(file, home)) throw InputError("leads out of the folder of its package");
  return file;
}

std::string kindOf(const std::filesystem::path& file) { return lower(file.extension().string()); }

}  // namespace

std::vector<std::string> meshNames(const std::string& urdf) {
  tinyxml2::XMLDocument document;
  std::vector<std::string> names;
  if (document.Parse(urdf.data(), urdf.size()) == tinyxml2::XML_SUCCESS)
    collectNames(document.RootElement(), false, names);
  return names;
}

std::filesystem::path meshFile(const std::string& name, UrdfOrigin origin, const PackageFolder& packages) {
  std::filesystem::path file;
  if (startsWith(name, kPackageScheme)) {
    file = inPackage(name, packages);
  } else {
    const std::string path = startsWith(name, kFileScheme) ? name.substr(kFileScheme.size()) : name;
    if (path.empty() || path.front() != '/')
      throw InputError("is neither package:// nor file:///; a relative path cannot be resolved");
    if (origin == UrdfOrigin::kSent)
      throw InputError("may be a path on another computer, because the file was uploaded; use package://");
    std::error_code failed;
    file = std::filesystem::canonical(path, failed);
    if (failed) throw InputError("cannot be read: " + failed.message());
  }
  const std::string kind = kindOf(file);
  if (kind != ".stl" && kind != ".dae" && kind != ".obj")
    throw InputError("is not a supported mesh; use .stl, .dae or .obj");
  if (!std::filesystem::is_regular_file(file)) throw InputError("is not a file");
  return file;
}

std::string meshBytes(const std::filesystem::path& file) {
  std::error_code failed;
  const std::uintmax_t size = std::filesystem::file_size(file, failed);
  if (failed) throw InputError("cannot be read: " + failed.message());
  if (const std::uintmax_t most = kindOf(file) == ".stl" ? kMostBytes : kLargestText; size > most)
    throw InputError("has " + std::to_string(size >> 20) + " MB, and at most " + std::to_string(most >> 20) +
                     " are drawn; simplify it" + (most < kMostBytes ? ", or save it as a binary STL" : ""));
  return readWholeFile(file, "check the mesh");
}

std::string meshesDocument(const std::string& urdf, UrdfOrigin origin, const PackageFolder& packages) {
  const std::vector<std::string> names = meshNames(urdf);
  if (names.empty()) return {};
  Json list = Json::array();
  std::string whole;
  for (const std::string& name : names) {
    try {
      if (list.size() >= kMostMeshes)
        throw InputError("is one more than the " + std::to_string(kMostMeshes) + " that are drawn");
      const std::filesystem::path file = meshFile(name, origin, packages);
      const std::string bytes = meshBytes(file);
      if (whole.size() + bytes.size() > kMostBytes)
        throw InputError("is left out: at most " + std::to_string(kMostBytes >> 20) +
                         " MB are drawn in all; simplify the meshes");
      list.push_back(
          {{"name", name}, {"kind", kindOf(file)}, {"first", whole.size()}, {"count", bytes.size()}});
      whole += bytes;
    } catch (const Error& e) {
      list.push_back({{"name", name}, {"why", e.what()}});
    }
  }
  const std::string head = jsonLine({{"meshes", std::move(list)}});
  std::string document;
  for (int byte = 0; byte < 4; ++byte) document += static_cast<char>(head.size() >> (8 * byte) & 0xff);
  return document + head + whole;
}

}  // namespace mm
