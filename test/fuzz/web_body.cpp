// The body of an action of the workbench, and names as people and files have them.
#include <nlohmann/json.hpp>

#include "fuzz_support.h"
#include "workbench/request_body.h"

namespace {

bool isUtf8(const std::string& text) {
  try {
    nlohmann::json(text).dump();
    return true;
  } catch (const nlohmann::json::exception&) {
    return false;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<std::string> known = {"who", "client", "effect", "id", "seed"};
  const std::string text = mm::fuzz::textOf(data, size);
  mm::fuzz::takes([&] {
    const mm::RequestBody body(text);
    const nlohmann::json whole = nlohmann::json::parse(text);  // what is taken is JSON, and no more than that
    if (!whole.is_object() || whole.size() > 32) mm::fuzz::broken("a body is one flat object");
    for (const auto& [key, value] : whole.items()) {
      if (value.is_string() && body.text(key) != value.get<std::string>())
        mm::fuzz::broken("a text is read as it is");
      if (value.is_number_unsigned() && body.number(key) != value.get<std::uint64_t>())
        mm::fuzz::broken("a whole number is read as it is");
      if (!value.is_string() && !value.is_number_unsigned())
        mm::fuzz::broken("a value is a text or a whole number");
    }
    body.refuseOthers("add", known);
    for (const std::string& key : known) mm::fuzz::takes([&] { body.text(key); });
    for (const std::string& key : known) mm::fuzz::takes([&] { body.number(key); });
  });
  const std::string name = mm::personsName(text), file = mm::shownFileName(text);
  if (name.size() > 40 || file.size() > 123) mm::fuzz::broken("a name is short");
  if (isUtf8(text) && !(isUtf8(name) && isUtf8(file))) mm::fuzz::broken("no letter is cut in two");
  return 0;
}
