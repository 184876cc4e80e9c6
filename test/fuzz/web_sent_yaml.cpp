// Models, plans and effects as a page of the workbench sends them: none may lead to a file.
#include <filesystem>

#include "fuzz_support.h"
#include "model/model_spec.h"
#include "session/plan.h"
#include "workbench/sent_yaml.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string folder = "/a folder that is not there";
  static const mm::Machine machine = mm::Machine::load("three_axis");
  const std::string text = mm::fuzz::textOf(data, size);
  if (text.find(folder.substr(1)) != std::string::npos) return 0;  // it would be said of any key, too
  mm::fuzz::takes([&] {
    const mm::ModelSpec model = mm::sentModel(text);
    if (model.machine.find('/') != std::string::npos || std::filesystem::exists(model.machine + ".urdf"))
      mm::fuzz::broken("a model names no file");
  });
  mm::fuzz::takes([&] { mm::parseEffectSpec(text, "effect"); });
  mm::fuzz::takes([&] {
    const std::string plan = mm::sentPlan(text);
    try {
      mm::Plan::parse(plan, "plan", folder, machine);
    } catch (const mm::Error& e) {
      if (std::string(e.what()).find(folder) != std::string::npos)
        mm::fuzz::broken(std::string("a plan names no file: ") + e.what());
      throw;
    }
  });
  return 0;
}
