#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "workbench/web_handler.h"

namespace mm {

/// What the page shows, by name. Each has a number that rises when it changes: the live state tells the
/// numbers, and the page fetches what is new. Thread-safe.
class Documents {
 public:
  /// Puts a document in place of the one of that name. @param body empty: there is none any more.
  /// @param fileName not empty: to be kept under that name.
  void put(const std::string& name, std::string body, const std::string& type = "application/json",
           const std::string& fileName = {});
  void remove(const std::string& name);                          ///< none of that name any more
  std::optional<WebAnswer> find(const std::string& name) const;  ///< empty: none of that name
  std::map<std::string, std::uint64_t> numbers() const;          ///< of all that there are

 private:
  struct Document {
    std::uint64_t number = 0;
    WebAnswer answer;
  };
  mutable std::mutex mutex_;
  std::map<std::string, Document> documents_;
  std::uint64_t last_ = 0;
};

}  // namespace mm
