#pragma once
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "base/error.h"

namespace mm::fuzz {

/// Ends the program, so that libFuzzer keeps the input: a promise of the parser is broken.
[[noreturn]] inline void broken(const std::string& promise) {
  std::fprintf(stderr, "broken promise: %s\n", promise.c_str());
  std::abort();
}

/// A file in memory, written anew for each input: a parser that takes a path reads it as any other file.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(::memfd_create("input", MFD_CLOEXEC)) {
    if (descriptor_ < 0) broken("memfd_create");
    path_ = "/proc/self/fd/" + std::to_string(descriptor_);
  }
  ~MemoryFile() { ::close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  const std::filesystem::path& write(const void* data, std::size_t size) {
    if (::ftruncate(descriptor_, 0) != 0 ||
        ::pwrite(descriptor_, data, size, 0) != static_cast<ssize_t>(size))
      broken("the file in memory cannot be written");
    return path_;
  }
  const std::filesystem::path& write(const std::string& text) { return write(text.data(), text.size()); }

 private:
  int descriptor_;
  std::filesystem::path path_;
};

/// Runs a parser. What it refuses, it refuses with a message, as the package's own exception; any other
/// exception ends the program. @return whether it took the input.
template <typename Parse>
bool takes(Parse parse) {
  try {
    parse();
    return true;
  } catch (const Error& e) {
    if (std::string(e.what()).empty()) broken("a refusal says why");
    return false;
  }
}

/// What the package wrote, it reads.
template <typename Parse>
void mustTake(Parse parse, const char* what) {
  try {
    parse();
  } catch (const Error& e) {
    broken(std::string(what) + ": " + e.what());
  }
}

inline std::string textOf(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

}  // namespace mm::fuzz
