// Plans: what is read can be written out move by move, and is then the same plan.
#include "session/plan.h"

#include "fuzz_support.h"
#include "plan_written_out.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const mm::Machine machine = mm::Machine::load("three_axis");
  const std::string text = mm::fuzz::textOf(data, size);
  mm::Plan plan;
  if (!mm::fuzz::takes([&] { plan = mm::Plan::parse(text, "plan.yaml", "config/plans", machine); })) return 0;
  constexpr std::size_t kMoves = 300;  // a longer one takes its time to be read again
  if (plan.moves.size() > kMoves) return 0;
  const std::string written = mm::planYaml(plan, machine);
  mm::Plan again;
  mm::fuzz::mustTake([&] { again = mm::Plan::parse(written, "written.yaml", ".", machine); },
                     written.c_str());
  if (again.moves.size() != plan.moves.size()) mm::fuzz::broken("a plan that was written has as many moves");
  return 0;
}
