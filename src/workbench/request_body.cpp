#include "workbench/request_body.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/error.h"

namespace mm {
namespace {

constexpr std::size_t kMostKeys = 32, kLongestName = 40, kLongestFileName = 120;

/// Reads one flat object as it comes: nothing is built that a client could make deep.
class FlatObject : public nlohmann::json_sax<nlohmann::json> {
 public:
  struct Item {
    std::string key;
    bool isText = false;
    std::string text;
    std::uint64_t number = 0;
  };
  std::vector<Item> items;
  std::string wrong;

  bool null() override { return refuse("null"); }
  bool boolean(bool) override { return refuse("true or false"); }
  bool number_integer(number_integer_t) override { return refuse("a negative number"); }
  bool number_unsigned(number_unsigned_t value) override { return add(false, {}, value); }
  bool number_float(number_float_t, const string_t&) override { return refuse("a number with a fraction"); }
  bool string(string_t& value) override { return add(true, value, 0); }
  bool binary(binary_t&) override { return refuse("bytes"); }
  bool start_object(std::size_t) override { return open_++ == 0 || refuse("an object"); }
  bool key(string_t& name) override {
    key_ = name;
    return items.size() < kMostKeys || refuse("one more key than is known");
  }
  bool end_object() override { return true; }
  bool start_array(std::size_t) override { return refuse("a list"); }
  bool end_array() override { return true; }
  bool parse_error(std::size_t at, const std::string&, const nlohmann::detail::exception&) override {
    wrong = "the request is not JSON: character " + std::to_string(at);
    return false;
  }

 private:
  bool add(bool isText, const std::string& text, std::uint64_t number) {
    if (open_ == 0) return refuse("a single value");
    items.push_back({key_, isText, text, number});
    return true;
  }
  bool refuse(const std::string& what) {
    wrong = "the request" + (key_.empty() ? std::string() : "'s '" + key_.substr(0, kLongestName) + "'") +
            " is " + what + "; a text or a whole number is understood";
    return false;
  }
  int open_ = 0;
  std::string key_;
};

std::string printable(const std::string& given) {
  std::string text;
  for (const char c : given)
    if (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f) text += c;
  return text;
}

/// Whether this byte goes on with a letter of UTF-8 that began before it.
bool insideLetter(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

}  // namespace

RequestBody::RequestBody(const std::string& json) {
  FlatObject object;
  if (!nlohmann::json::sax_parse(json, &object))
    throw InputError(object.wrong.empty() ? "the request is not JSON" : object.wrong);
  for (const FlatObject::Item& item : object.items)
    if (!values_.emplace(item.key, Value{item.isText, item.text, item.number}).second)
      throw InputError("the request has '" + item.key.substr(0, kLongestName) + "' twice");
}

std::string RequestBody::text(const std::string& key) const {
  const auto found = values_.find(key);
  if (found == values_.end()) return {};
  if (!found->second.isText) throw InputError("the request's '" + key + "' is not a text");
  return found->second.text;
}

std::uint64_t RequestBody::number(const std::string& key) const {
  const auto found = values_.find(key);
  if (found == values_.end()) return 0;
  if (found->second.isText) throw InputError("the request's '" + key + "' is not a whole number");
  return found->second.number;
}

void RequestBody::refuseOthers(const std::string& action, const std::vector<std::string>& known) const {
  for (const auto& [key, value] : values_)
    if (std::find(known.begin(), known.end(), key) == known.end())
      throw InputError("'" + action + "' knows no '" + key.substr(0, kLongestName) + "'");
}

std::string personsName(const std::string& given) {
  const std::string name = printable(given);
  std::size_t end = std::min(name.size(), kLongestName);
  while (end > 0 && end < name.size() && insideLetter(name[end])) --end;
  return name.substr(0, end);
}

std::string shownFileName(const std::string& given) {
  const std::string name = printable(given);
  if (name.size() <= kLongestFileName) return name;
  std::size_t begin = name.size() - kLongestFileName;
  while (begin < name.size() && insideLetter(name[begin])) ++begin;
  return "…" + name.substr(begin);
}

}  // namespace mm
