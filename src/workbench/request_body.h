#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

namespace mm {

/// What an action was asked with: an object of texts and whole numbers, nothing within another.
class RequestBody {
 public:
  /// @throw InputError: no JSON, no object, a value of another kind, a key twice, more than 32 keys, a text
  /// that is not UTF-8.
  explicit RequestBody(const std::string& json);

  std::string text(const std::string& key) const;      ///< empty: not there. @throw InputError: no text
  std::uint64_t number(const std::string& key) const;  ///< 0: not there. @throw InputError: no whole number
  /// @throw InputError naming a key that is none of these.
  void refuseOthers(const std::string& action, const std::vector<std::string>& known) const;

 private:
  std::map<std::string, std::variant<std::string, std::uint64_t>> values_;
};

/// A name as a person gives it: at most 40 bytes, no letter cut in two, no control characters.
std::string personsName(const std::string& given);
/// A file's name as it is shown: at most 120 bytes, of a longer one the end; no control characters.
std::string shownFileName(const std::string& given);

}  // namespace mm
