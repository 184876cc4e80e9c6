// docs/effects.md says of every effect what the registry says. What follows from the code is compared to the
// letter; after a change it is written anew by
//   MM_WRITE_DOCS=1 build/devel/lib/measuring_machine/test_effects --gtest_filter='CataloguePage.*'
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "base/format.h"
#include "effects/iso230_symbol.h"
#include "effects_support.h"

namespace mm {
namespace {

constexpr const char* kPage = "docs/effects.md";

struct PageExample {
  EffectPtr effect;
  std::string symbol;  // of ISO 230-1; empty: it has none
};

/// One member of each type, on a machine that can have it.
PageExample exampleOf(const std::string& type) {
  for (const int which : {0, 1, 2}) {
    const MachineRig rig = rigOf(which);
    for (const EffectSpec& spec : everySpec(rig.domain, which))
      if (spec.type == type)
        return {createEffect(spec, rig.domain, networksOf(rig.domain)), ErrorSymbols(rig.machine).of(spec)};
  }
  return {};
}

/// The last cells of its row: its symbol, and its parameters, those of one unit and plausible limit together.
std::string registryCells(const PageExample& example) {
  constexpr std::size_t kMost = 7;
  const auto& parameters = example.effect->parameters();
  const std::size_t shown = std::min(kMost, parameters.size());
  const auto limit = [&](std::size_t i) {
    return " (" + parameters[i].unit + format(", %.4g)", parameters[i].bound * parameters[i].toUnit);
  };
  std::string text = "| " + example.symbol + " | ";
  for (std::size_t i = 0; i < shown; ++i) {
    text += (i == 0 ? "" : ", ") + parameters[i].name;
    if (i + 1 == shown || limit(i + 1) != limit(i)) text += limit(i);
  }
  if (parameters.size() > kMost) text += format(" … %zu in all", parameters.size());
  return text + (example.effect->nature().composite ? "; no candidate |" : " |");
}

struct Row {
  std::string type, written, registry;  // written: by people, the formula and the keys
  std::size_t begin = 0, size = 0;      // of the registry's cells in the page
};

std::vector<Row> rowsOf(const std::string& page) {
  const std::string title = "\n| `";
  std::vector<Row> rows;
  for (std::size_t at = page.find(title); at != std::string::npos; at = page.find(title, at + 1)) {
    const std::size_t name = at + title.size(), end = page.find('\n', name);
    const std::size_t written = page.find(" | ", name), registry = page.find(" | ", written + 1);
    Row row;
    row.type = page.substr(name, page.find('`', name) - name);
    if (written < registry && registry < end) {
      row.written = page.substr(written, registry - written);
      row.begin = registry + 1;
      row.size = end - row.begin;
      row.registry = page.substr(row.begin, row.size);
    }
    rows.push_back(row);
  }
  return rows;
}

std::string readPage() {
  std::ifstream in(kPage);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

TEST(CataloguePage, hasARowForEachTypeInTheOrderOfTheRegistry) {
  std::vector<std::string> wanted, there;
  for (const EffectType& type : effectRegistry()) wanted.push_back(type.type);
  for (const Row& row : rowsOf(readPage())) there.push_back(row.type);
  EXPECT_EQ(there, wanted);
}

TEST(CataloguePage, namesEveryKey) {
  const std::vector<Row> rows = rowsOf(readPage());
  ASSERT_EQ(rows.size(), effectRegistry().size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const EffectType& type = effectRegistry()[i];
    for (const std::string& key : type.keys)
      EXPECT_NE(rows[i].written.find("`" + key + "`"), std::string::npos) << type.type << ": " << key;
  }
}

TEST(CataloguePage, saysWhatTheRegistrySays) {
  std::string page = readPage();
  std::vector<Row> rows = rowsOf(page);
  const bool write = std::getenv("MM_WRITE_DOCS") != nullptr;
  for (auto row = rows.rbegin(); row != rows.rend(); ++row) {
    const PageExample example = exampleOf(row->type);
    ASSERT_NE(example.effect, nullptr) << row->type;
    ASSERT_GT(row->begin, 0u) << row->type << " lacks its cells from the registry";
    if (write)
      page.replace(row->begin, row->size, registryCells(example));
    else
      EXPECT_EQ(row->registry, registryCells(example))
          << row->type << ": write the page anew with MM_WRITE_DOCS=1";
  }
  if (write) std::ofstream(kPage) << page;
}

}  // namespace
}  // namespace mm
