#include "drivers/linuxcnc_state.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.h"

namespace mm {
namespace {

using nlohmann::json;

constexpr std::size_t kPlaces = 6;  // X Y Z A B C

std::vector<double> placesOf(const json& line, const char* key) {
  const auto values = line.at(key).get<std::vector<double>>();
  if (values.size() != kPlaces) throw Error(std::string(key) + " does not have 6 values");
  return values;
}

// Not a number that is cut to one.
std::int64_t wholeOf(const json& value) {
  if (!value.is_number_integer()) throw Error("'" + value.dump() + "' is not a whole number");
  return value.get<std::int64_t>();
}

LinuxCncState stateOf(const json& line) {
  LinuxCncState s;
  for (const auto& [key, value] : {std::pair<const char*, double*>{"time", &s.time},
                                   {"within", &s.within},
                                   {"linear", &s.linear},
                                   {"angular", &s.angular},
                                   {"override", &s.override}})
    *value = line.at(key).get<double>();
  for (const auto& [key, flag] : {std::pair<const char*, bool*>{"busy", &s.busy},
                                  {"emergency", &s.emergency},
                                  {"on", &s.on},
                                  {"probe", &s.probe},
                                  {"tripped", &s.tripped}})
    *flag = line.at(key).get<bool>();
  s.echo = wholeOf(line.at("echo"));
  s.lapses = wholeOf(line.at("lapses"));
  s.axes = wholeOf(line.at("axes"));
  for (const json& limit : line.at("limits").get_ref<const json::array_t&>())
    s.limits.push_back(wholeOf(limit));
  line.at("homed").get_to(s.homed);
  line.at("said").get_to(s.said);
  s.actual = placesOf(line, "actual");
  s.commanded = placesOf(line, "commanded");
  s.probed = placesOf(line, "probed");
  if (s.override < 0.0 || s.within < 0.0 || s.time < 0.0) throw Error("a number is below 0");
  return s;
}

}  // namespace

LinuxCncLine parseLinuxCncLine(const std::string& text) {
  LinuxCncLine line;
  try {
    const json parsed = json::parse(text);
    if (parsed.contains("trouble")) {
      line.trouble = parsed.at("trouble").get<std::string>();
    } else if (parsed.contains("taken")) {
      line.kind = LinuxCncLine::Kind::kTaken;
      line.taken = wholeOf(parsed.at("taken"));
      line.serial = wholeOf(parsed.at("serial"));
    } else {
      line.kind = LinuxCncLine::Kind::kState;
      line.state = stateOf(parsed);
    }
  } catch (const std::exception& e) {  // of the JSON, or of a value in it
    throw Error("received data are not from linuxcnc_helper: " + std::string(e.what()));
  }
  return line;
}

}  // namespace mm
