#include "interpreters/interpreter.h"

#include "base/error.h"
#include "base/names_of.h"
#include "base/nearest_name.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

struct Target {
  const char* name;
  std::unique_ptr<Interpreter> (*interpret)(const std::filesystem::path& folder);
};

constexpr Target kTargets[] = {{"linuxcnc", interpretLinuxcnc},
                               {"klipper", interpretKlipper},
                               {"marlin", interpretMarlin},
                               {"reprapfirmware", interpretReprapfirmware},
                               {"grblhal", interpretGrblhal},
                               {"siemens", interpretSiemens},
                               {"heidenhain", interpretHeidenhain},
                               {"fanuc", interpretFanuc},
                               {"beckhoff", interpretBeckhoff},
                               {"isg", interpretIsg},
                               {"csv", interpretCsv}};

}  // namespace

std::unique_ptr<Interpreter> interpret(const std::string& target, const std::filesystem::path& folder) {
  for (const Target& known : kTargets) {
    if (target != known.name) continue;
    if (!std::filesystem::is_directory(folder))
      throw InputError(folder.string() + ": is not a folder; the files that " + target +
                       " is given are expected there");
    return known.interpret(folder);
  }
  throw InputError("target '" + target + "' is not known" + didYouMean(target, interpretedTargets()) +
                   "; known: " + listOf(interpretedTargets()));
}

std::vector<std::string> interpretedTargets() { return allNames(kTargets); }

}  // namespace mm
