#pragma once
#include <map>
#include <optional>
#include <string>

#include "workbench/web_handler.h"

namespace mm {

/// The page's own files and the libraries it uses, read once: a path is looked up among them and never
/// opened.
class Page {
 public:
  /// @throw InputError naming a file that is missing, and how to get it.
  Page();

  /// The page itself. @param token for the addresses of its parts.
  WebAnswer index(const std::string& token) const;
  /// A part: "/app/main.js"; empty: there is none of that name.
  std::optional<WebAnswer> part(const std::string& path) const;

 private:
  std::string html_;
  std::map<std::string, WebAnswer> parts_;
};

}  // namespace mm
