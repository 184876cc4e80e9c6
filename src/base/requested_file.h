#pragma once
#include <filesystem>
#include <string>

namespace mm {

/// Whether a text of a request names a file: a text of many letters or lines is none, whatever the file
/// system says to it.
bool namesFile(const std::string& text);

/// A file that a request names, which whoever reaches the node may send: a short YAML file, so that what
/// stands in any other file is never told. @param what "plan", "model", for the message.
/// @throw InputError: it is no such file.
std::filesystem::path requestedYaml(const std::string& path, const std::string& what);

}  // namespace mm
