#include <algorithm>
#include <iostream>

#include "base/erase_if.h"
#include "base/error.h"
#include "base/json_text.h"
#include "base/nearest_name.h"
#include "effects/catalogue.h"
#include "tools/commands.h"

namespace mm {
namespace {

struct EffectsOptions {
  std::string type;
  bool json = false;
};

Json keyJson(const CatalogueKey& k) {
  const bool number = k.use.kind == KeyUse::Kind::kNumber || k.use.kind == KeyUse::Kind::kInteger;
  const bool standard = k.use.absent && !k.use.absent->empty();
  return jsonObject({{{"key", k.use.key}, {"required", k.required}},
                     entryIf(k.known, "takes", takesInWords(k.use)),
                     number ? Json{{"lower", k.use.lower}, {"upper", k.use.upper}} : Json(),
                     entryIf(!k.use.words.empty(), "words", k.use.words),
                     entryIf(standard, "default", k.use.absent.value_or("")),
                     entryIf(!k.onlyAt.empty(), "only_at", k.onlyAt)});
}

Json parameterJson(const CatalogueParameter& p) {
  return jsonObject({{{"name", p.name}, {"unit", p.unit.empty() ? p.rotaryUnit : p.unit}},
                     entryIf(!p.rotaryUnit.empty(), "unit_rotary", p.rotaryUnit)});
}

Json entryJson(const CatalogueEntry& e) {
  return jsonObject({{{"type", e.type}, {"composite", e.composite}, {"example", e.example}},
                     entryIf(!e.iso230.empty(), "iso230", e.iso230),
                     {{"keys", jsonList(e.keys, keyJson)},
                      {"parameters", jsonList(e.parameters, parameterJson)},
                      {"needs", e.needs},
                      {"shown_by", e.shownBy},
                      {"cause", e.cause},
                      {"remedy", e.remedy}}});
}

std::string unitOf(const CatalogueParameter& p) {
  if (p.unit.empty()) return p.rotaryUnit + " (rotary axes only)";
  return p.unit + (p.rotaryUnit.empty() || p.rotaryUnit == p.unit ? "" : " (rotary: " + p.rotaryUnit + ")");
}

void print(const CatalogueEntry& e) {
  std::cout << e.type << (e.composite ? "  (composite: never a candidate of a diagnosis)" : "") << '\n';
  if (!e.example.empty()) std::cout << "  example     " << e.example << '\n';
  if (!e.iso230.empty())
    std::cout << "  ISO 230-1   " << e.iso230 << ", the example on " << kExampleMachine << '\n';
  const char* title = "  keys        ";
  for (const CatalogueKey& k : e.keys) {
    std::cout << title << k.use.key << ": " << (k.known ? takesInWords(k.use) : "see its package");
    if (!k.onlyAt.empty()) std::cout << " (" << k.onlyAt << " axes alone)";
    if (!k.required && k.known)
      std::cout << (k.use.absent && !k.use.absent->empty() ? " [" + *k.use.absent + "]" : " (optional)");
    std::cout << '\n';
    title = "              ";
  }
  title = "  parameters  ";
  constexpr std::size_t kShown = 12;
  for (std::size_t i = 0; i < std::min(kShown, e.parameters.size()); ++i) {
    std::cout << title << e.parameters[i].name << ", " << unitOf(e.parameters[i]) << '\n';
    title = "              ";
  }
  if (e.parameters.size() > kShown) std::cout << title << "and " << e.parameters.size() - kShown << " more\n";
  if (!e.needs.empty()) std::cout << "  needs       " << listOf(e.needs) << '\n';
  if (!e.shownBy.empty()) std::cout << "  shown by    " << e.shownBy << '\n';
  if (!e.cause.empty()) std::cout << "  cause       " << e.cause << '\n';
  if (!e.remedy.empty()) std::cout << "  remedy      " << e.remedy << '\n';
}

void runEffects(const EffectsOptions& options) {
  std::vector<CatalogueEntry> entries = effectCatalogue();
  if (!options.type.empty()) {
    std::vector<std::string> known;
    for (const CatalogueEntry& e : entries) known.push_back(e.type);
    eraseIf(entries, [&](const CatalogueEntry& e) { return e.type != options.type; });
    if (entries.empty())
      throw InputError("'" + options.type + "' is not an effect of the catalogue" +
                       didYouMean(options.type, known) + " (mm effects lists them)");
  }
  if (options.json) {
    std::cout << jsonText({{"effects", jsonList(entries, entryJson)}}) << '\n';
    return;
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (i > 0) std::cout << '\n';
    print(entries[i]);
  }
  std::cout
      << "\n"
         "any effect, keys  from_session: of several sessions, the number of the first in which it acts\n"
         "                  stylus: name of the only stylus with which it acts\n";
}

}  // namespace

void addEffectsCommand(CLI::App& app, int& exitStatus) {
  auto [options, command] = addCommand<EffectsOptions>(
      app, exitStatus, runEffects, "effects", "List the catalogue of physical effects and their keys");
  command.add_option("type", options.type, "show only this effect, e.g. backlash");
  command.add_flag("--json", options.json, "print as JSON on standard output");
  command.footer(
      "Effects of your own packages are included. Defaults stand in [ ]. Any effect also takes from_session: "
      "N\n"
      "(acts from the N-th of several sessions on) and stylus: NAME (acts with this stylus only).\n"
      "Example:\n"
      "  mm effects thermal_growth");
}

}  // namespace mm
