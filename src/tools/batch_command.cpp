#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "tools/batch_result.h"
#include "tools/batch_run.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/exit_status.h"
#include "tools/interrupt.h"
#include "tools/json_output.h"
#include "tools/one_line.h"

namespace mm {
namespace {

struct BatchCommand {
  std::string manifest, output;
  EngineOptions engine;
  bool again = false, json = false, result = false;
};

constexpr std::size_t kWhysPrinted = 20;

void print(const BatchSummary& s, const BatchCommand& c) {
  for (std::size_t i = 0; i < std::min(s.whys.size(), kWhysPrinted); ++i) say("failed: " + s.whys[i]);
  if (s.whys.size() > kWhysPrinted)
    say("failed: " + std::to_string(s.whys.size() - kWhysPrinted) + " more; mm fleet " + c.output +
        " lists them");
  if (!s.complaint.empty()) warn("snakemake: " + s.complaint);
  if (s.left > 0 && !s.stopped)
    say(std::to_string(s.left) + " jobs were not done; " + c.output +
        "/batch.log says why; run the same command again");
  if (c.json) {
    printJson(std::cout, {{"folder", c.output},
                          {"jobs", s.jobs},
                          {"done_before", s.before},
                          {"done", s.done},
                          {"failed", s.failed},
                          {"left", s.left},
                          {"stopped", s.stopped},
                          {"seconds", s.seconds},
                          {"why", s.whys}});
    return;
  }
  std::cout << s.jobs << " jobs: " << s.before << " finished before, " << s.done << " done";
  if (s.failed > 0) std::cout << ", " << s.failed << " failed";
  if (s.left > 0) std::cout << ", " << s.left << " left";
  std::cout << "; " << std::max<std::size_t>(1, static_cast<std::size_t>(s.seconds + 0.5)) << " s\nmm fleet "
            << c.output << " summarises them\n";
}

int run(const BatchCommand& c) {
  if (c.result) return writeBatchResult();
  if (c.manifest.empty() || c.output.empty())
    throw InputError("a manifest and -o are required; see mm batch --help");
  const Manifest manifest = loadManifest(c.manifest);
  warn(manifest.remarks);
  const BatchSummary s = runBatch(manifest, ResultsFolder(c.output), c.engine, c.again);
  print(s, c);
  if (s.stopped) {
    say("stopped by Ctrl-C; finished jobs are kept, run the same command to continue");
    return kStopped;
  }
  return s.whys.empty() && s.left == 0 ? kDone : kAnswerIsNo;
}

}  // namespace

void addBatchCommand(CLI::App& app, int& exitStatus) {
  auto c = std::make_shared<BatchCommand>();
  CLI::App* command = app.add_subcommand("batch", "Process many sessions: run each job of a manifest once");
  command->add_option("manifest", c->manifest, "YAML: sessions, models, steps");
  command->add_option("-o,--output", c->output, "the folder of results; finished jobs in it are kept");
  command->add_option("--engine", c->engine.engine, "where jobs run: local (this computer) or slurm")
      ->capture_default_str()
      ->check(CLI::IsMember({"local", "slurm"}));
  command
      ->add_option("--profile", c->engine.profile, "Snakemake profile, for another cluster or other options")
      ->excludes(command->get_option("--engine"));
  command
      ->add_option("--jobs", c->engine.jobs,
                   "jobs at a time; 0: one per core of this computer, 100 with Slurm, or the number in the "
                   "profile")
      ->capture_default_str()
      ->check(wholeNumberWithin(0, 100'000));
  command->add_option("--limit", c->engine.limit, "time limit of one step, s")
      ->capture_default_str()
      ->check(wholeNumberWithin(1, 10'000'000));
  command->add_flag("--again", c->again, "run failed jobs again");
  command->add_flag("--json", c->json, "print the counts as JSON on standard output");
  command->add_flag("--result", c->result, "ends a job in the current folder: for Snakemake")->group("");
  command->footer(
      "A finished job is never run again, even if the batch is interrupted. A failed job does not stop the "
      "others\n"
      "and reports its reason. Exit status 1: a job failed.\n"
      "Examples:\n"
      "  mm batch manifest.yaml -o results\n"
      "  mm batch manifest.yaml -o results --engine slurm --jobs 64");
  command->callback([c, &exitStatus] { exitStatus = run(*c); });
}

}  // namespace mm
