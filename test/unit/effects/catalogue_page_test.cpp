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
constexpr const char* kBegin = "<!-- registry -->\n";
constexpr const char* kEnd = "<!-- end -->\n";

struct PageExample {
  EffectPtr effect;
  std::string symbol;  // of ISO 230-1; empty: it has none
};

/// One member of each type, on a machine that can have it.
PageExample exampleOf(const std::string& type) {
  for (const int which : {0, 1}) {
    const MachineRig rig = rigOf(which);
    for (const EffectSpec& spec : everySpec(rig.domain, which))
      if (spec.type == type)
        return {createEffect(spec, rig.domain, networksOf(rig.domain)), ErrorSymbols(rig.machine).of(spec)};
  }
  return {};
}

/// Its example with its symbol, its parameters (unit, plausible up to) and its cause.
std::string registryPart(const PageExample& example) {
  const Effect& effect = *example.effect;
  constexpr std::size_t kMost = 7;
  std::string text =
      "`" + effect.spec().yaml() + "`" + (example.symbol.empty() ? "" : " (" + example.symbol + ")") + ": ";
  const auto& parameters = effect.parameters();
  for (std::size_t i = 0; i < std::min(kMost, parameters.size()); ++i)
    text += (i == 0 ? "" : ", ") + parameters[i].name + " (" + parameters[i].unit +
            format(", %.4g)", parameters[i].bound * parameters[i].toUnit);
  if (parameters.size() > kMost) text += format(" … %zu in all", parameters.size());
  text += effect.nature().composite ? ". Never a candidate of a diagnosis.\n" : ".\n";
  return text + "\n" + effect.cause() + "\n";
}

struct Section {
  std::string type, written, registry;  // written: by people, between the title and the registry's part
  std::size_t begin = 0, size = 0;      // of the registry's part in the page
};

std::vector<Section> sectionsOf(const std::string& page) {
  const std::string title = "\n## `";
  std::vector<Section> sections;
  for (std::size_t at = page.find(title); at != std::string::npos;) {
    const std::size_t name = at + title.size(), next = page.find(title, name);
    Section s;
    s.type = page.substr(name, page.find('`', name) - name);
    const std::size_t begin = page.find(kBegin, name), end = page.find(kEnd, name);
    if (begin < next && end < next && begin < end) {
      s.written = page.substr(name, begin - name);
      s.begin = begin + std::string(kBegin).size();
      s.size = end - s.begin;
      s.registry = page.substr(s.begin, s.size);
    }
    sections.push_back(s);
    at = next;
  }
  return sections;
}

std::string readPage() {
  std::ifstream in(kPage);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

TEST(CataloguePage, hasASectionForEachTypeInTheOrderOfTheRegistry) {
  std::vector<std::string> wanted, there;
  for (const EffectType& type : effectRegistry()) wanted.push_back(type.type);
  for (const Section& section : sectionsOf(readPage())) there.push_back(section.type);
  EXPECT_EQ(there, wanted);
}

TEST(CataloguePage, namesEveryKey) {
  const std::vector<Section> sections = sectionsOf(readPage());
  ASSERT_EQ(sections.size(), effectRegistry().size());
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const EffectType& type = effectRegistry()[i];
    for (const std::string& key : type.keys)
      EXPECT_NE(sections[i].written.find("`" + key + "`"), std::string::npos) << type.type << ": " << key;
  }
}

TEST(CataloguePage, saysWhatTheRegistrySays) {
  std::string page = readPage();
  std::vector<Section> sections = sectionsOf(page);
  const bool write = std::getenv("MM_WRITE_DOCS") != nullptr;
  for (auto section = sections.rbegin(); section != sections.rend(); ++section) {
    const PageExample example = exampleOf(section->type);
    ASSERT_NE(example.effect, nullptr) << section->type;
    ASSERT_GT(section->begin, 0u) << section->type << " lacks its part from the registry";
    if (write)
      page.replace(section->begin, section->size, registryPart(example));
    else
      EXPECT_EQ(section->registry, registryPart(example))
          << section->type << ": write the page anew with MM_WRITE_DOCS=1";
  }
  if (write) std::ofstream(kPage) << page;
}

}  // namespace
}  // namespace mm
