#include "tools/json_output.h"

#include <cmath>

namespace mm {

nlohmann::json jsonNumber(double si, double toUnit) {
  const double value = si * toUnit;
  if (!std::isfinite(value)) return nullptr;
  return value;
}

void printJson(std::ostream& out, const nlohmann::ordered_json& value) {
  // Text that is not UTF-8 (a name from a foreign file) is replaced, never thrown over: the answer counts.
  out << value.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
}

}  // namespace mm
