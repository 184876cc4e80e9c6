#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace mm {

/// Folder of a package of ROS by its name; empty: there is none of that name.
using PackageFolder = std::function<std::filesystem::path(const std::string&)>;

/// Where the URDF came from, that names the files.
enum class UrdfOrigin {
  kThisComputer,  // the running machine's, or that of a file that was named on the command line
  kSent           // of a file that a page sent: what it names may be any file of this computer
};

/// Names of the mesh files that a URDF's visuals name, each once, in the order of the text; none of a text
/// that is no XML.
std::vector<std::string> meshNames(const std::string& urdf);

/// The file that a name means: `package://<package>/<path within it>`, and of a URDF of this computer also
/// `file:///…` or an absolute path. The file's name ends in .stl, .dae or .obj.
/// @throw InputError: why it is not read; a URDF that was sent names nothing outside a package's folder.
std::filesystem::path meshFile(const std::string& name, UrdfOrigin origin, const PackageFolder& packages);

/// What it holds, which the page reads. @throw InputError: it cannot be read, or is too large to draw.
std::string meshBytes(const std::filesystem::path& file);

/// All mesh files of a URDF for the page, one after the other: the length of a text (4 bytes, little endian),
/// the text, the files. The text is JSON: `{"meshes": [{"name": as in the URDF, "kind": ".stl", ".dae" or
/// ".obj", "first": its first byte, counted from the end of the text, "count": of its bytes}, …]}`, with
/// `why` in place of these three for one that is not there. Empty: the URDF names none.
std::string meshesDocument(const std::string& urdf, UrdfOrigin origin, const PackageFolder& packages);

}  // namespace mm
