#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>

#include "machine/error.h"
#include "model/model_spec.h"
#include "tools/benchmark_session.h"
#include "tools/benchmark_trial.h"
#include "tools/commands.h"
#include "tools/progress_bar.h"

namespace mm {
namespace {

/// Wilson's 95 % interval of a share, in percent.
std::string wilson(int right, int count) {
  if (count == 0) return "-";
  const double z = 1.959964, n = count, p = right / n;
  const double centre = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double half = z / (1 + z * z / n) * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  char text[80];
  std::snprintf(text, sizeof text, "%5.1f %% (%.1f-%.1f %%) %d/%d", 100 * p,
                100 * std::max(0.0, centre - half), 100 * std::min(1.0, centre + half), right, count);
  return text;
}

struct Options {
  std::string machine = "three_axis", plan, model;
  int trials = 50, effects = 1;
  double size = 1.0;
  std::uint64_t seed = 1;
  bool verbose = false, uncatalogued = false;
  std::vector<std::string> only;
  SessionVariant variant;
};

/// What is counted of effects outside the catalogue, together and by kind.
struct UnknownCounts {
  struct Count {
    int all = 0, verdict = 0, variables = 0, direction = 0, heldOut = 0, everything = 0, byCatalogue = 0;
  };
  Count sum;
  std::map<std::string, Count> byKind;

  void add(const Trial& r) {
    const bool verdict = r.verdict == Verdict::kUnknownEffect;
    for (Count* c : {&sum, &byKind[r.hidden.empty() ? "" : r.hidden[0].type]}) {
      ++c->all;
      c->verdict += verdict;
      c->variables += r.unknown.justTheVariables;
      c->direction += r.unknown.justTheVariables && r.unknown.rightDirection;
      c->heldOut += r.unknown.explained;
      c->everything += good(r);
      c->byCatalogue += r.unknown.byCatalogue;
    }
  }
  static bool good(const Trial& r) {
    return r.verdict == Verdict::kUnknownEffect && r.unknown.justTheVariables && r.unknown.explained;
  }
  void print() const {
    std::printf("verdict unknown_effect                      %s\n", wilson(sum.verdict, sum.all).c_str());
    std::printf("first formula over just the right variables %s\n", wilson(sum.variables, sum.all).c_str());
    std::printf("  and in the right direction                %s\n", wilson(sum.direction, sum.all).c_str());
    std::printf("held-out RMS within 20 %% of the noise       %s\n", wilson(sum.heldOut, sum.all).c_str());
    std::printf("verdict, variables and held-out RMS         %s\n", wilson(sum.everything, sum.all).c_str());
    std::printf("explained by effects of the catalogue       %s\n", wilson(sum.byCatalogue, sum.all).c_str());
    std::printf(
        "by kind (all three | verdict, variables, direction too, held-out, by the catalogue of trials):\n");
    for (const auto& [kind, c] : byKind)
      std::printf("  %-36s %s | %d %d %d %d %d of %d\n", kind.c_str(), wilson(c.everything, c.all).c_str(),
                  c.verdict, c.variables, c.direction, c.heldOut, c.byCatalogue, c.all);
  }
};

void printUnknown(const Trial& r) {
  std::printf(" | true: %s over", r.unknown.truth.direction.c_str());
  for (std::size_t i = 0; i < r.unknown.truth.variables.size(); ++i)
    std::printf("%s %s", i > 0 ? "," : "", r.unknown.truth.variables[i].c_str());
  std::printf(" | variables %s", r.unknown.justTheVariables ? "right" : "wrong");
}

void run(const Options& o) {
  const Machine machine = Machine::load(o.machine);
  TrialOptions trial;
  std::ifstream in(o.plan);
  if (!in) throw InputError(o.plan + ": cannot be read; give a plan with --plan (see config/plans)");
  std::ostringstream text;
  text << in.rdbuf();
  trial.planYaml = varied(text.str(), o.plan, o.variant);
  trial.planSource = o.plan;
  trial.effects = o.effects;
  trial.size = o.size;
  trial.only = o.only;
  trial.uncatalogued = o.uncatalogued;
  if (!o.model.empty()) trial.base = loadModelSpec(o.model).effects;
  if (o.uncatalogued && o.effects != 1)
    throw InputError("--uncatalogued hides one effect a session; leave out --effects");
  if (o.uncatalogued && o.only.empty())  // one kind after the other, so that all are tried alike
    for (const UncataloguedKind& kind : uncataloguedKinds()) trial.only.push_back(kind.type);
  for (const std::string& name : o.only)
    if (o.uncatalogued != isUncatalogued(name))
      throw InputError("--only: '" + name + "' is " + (o.uncatalogued ? "not " : "") +
                       "outside the catalogue; give such names with --uncatalogued, and no others");
  int all = 0, exactly = 0, first = 0, clean = 0, byHand = 0, atNoise = 0, confused = 0, missed = 0,
      falseClaims = 0;
  int notShown = 0;
  double seconds = 0.0;
  UnknownCounts unknown;
  std::map<std::string, std::pair<int, int>> byType;
  ProgressBar bar("benchmark");
  for (int t = 0; t < o.trials; ++t) {
    bar.show(static_cast<double>(t) / o.trials);
    const Trial r = runTrial(machine, trial, o.seed + static_cast<std::uint64_t>(t));
    if (r.notShown) {
      ++notShown;
      continue;
    }
    ++all;
    const int hidden = static_cast<int>(r.hidden.size());
    const bool exact = r.right == hidden && r.falseClaims == 0 && r.verdict != Verdict::kUnknownEffect;
    exactly += exact;
    first += r.firstRight;
    clean += r.falseClaims == 0 && (hidden > 0 || r.verdict == Verdict::kExplained);
    byHand += hidden > 0 && r.rightByCorrelation == hidden;
    atNoise += r.heldOutEnd < 1.05;
    confused += r.right - r.exact;
    missed += hidden - r.right;
    falseClaims += r.falseClaims;
    seconds = std::max(seconds, r.seconds);
    for (const EffectSpec& h : r.hidden) {
      ++byType[h.type].second;
      byType[h.type].first += exact;
    }
    if (o.uncatalogued) unknown.add(r);
    const bool bad = o.uncatalogued ? !UnknownCounts::good(r) : !exact && hidden > 0;
    if (o.verbose || bad || (hidden == 0 && r.verdict != Verdict::kExplained)) {
      std::printf("seed %llu: hidden", static_cast<unsigned long long>(r.seed));
      for (const std::string& h : r.hiddenText) std::printf(" %s", h.c_str());
      std::printf(" | %s:", nameOf(r.verdict).c_str());
      for (const std::string& f : r.found) std::printf(" %s", f.c_str());
      if (o.uncatalogued) printUnknown(r);
      std::printf(" | held-out %.3f noise, %.2f s\n", r.heldOutEnd, r.seconds);
      std::fflush(stdout);
    }
  }
  if (notShown > 0) std::printf("not counted: %d sessions, which show nothing of what was drawn\n", notShown);
  if (o.uncatalogued) {
    unknown.print();
    std::printf("longest diagnosis %.2f s\n", seconds);
    return;
  }
  if (o.effects > 0) {
    std::printf("first named is one that was hidden   %s\n", wilson(first, all).c_str());
    std::printf("exactly the hidden ones              %s\n", wilson(exactly, all).c_str());
    std::printf("same by ranking correlations         %s\n", wilson(byHand, all).c_str());
    std::printf("no false claim                       %s\n", wilson(clean, all).c_str());
    std::printf("named as confusable %d, missed %d, falsely claimed %d (of %d hidden)\n", confused, missed,
                falseClaims, all * o.effects);
  } else {
    std::printf("nothing claimed                      %s\n", wilson(clean, all).c_str());
  }
  std::printf("held-out RMS within 5 %% of the noise %s\n", wilson(atNoise, all).c_str());
  std::printf("longest diagnosis %.2f s\n", seconds);
  if (o.effects > 0) {
    std::printf("by effect:\n");
    for (const auto& [type, share] : byType)
      std::printf("  %-26s %s\n", type.c_str(), wilson(share.first, share.second).c_str());
  }
}

}  // namespace

void addBenchmarkCommand(CLI::App& app, int&) {
  auto o = std::make_shared<Options>();
  CLI::App* c = app.add_subcommand(
      "benchmark", "hides effects at random in simulated sessions and counts what the diagnosis finds");
  c->add_option("--machine", o->machine, "three_axis, five_axis or the path of a URDF")
      ->capture_default_str();
  c->add_option("--plan", o->plan, "measurement plan (YAML)")->required();
  c->add_option("--model", o->model, "model file: what the diagnosis starts from; nothing if left out");
  c->add_option("--trials", o->trials, "simulated sessions")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  c->add_option("--effects", o->effects, "effects hidden in each; 0: none")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  c->add_option("--size", o->size, "RMS of what refit leaves of each, over the noise")->capture_default_str();
  c->add_option("--only", o->only, "kinds to draw from (see mm simulate --help)");
  c->add_flag(
      "--uncatalogued", o->uncatalogued,
      "hide effects outside the catalogue: unknown_effect and a formula over the right variables are wanted");
  c->add_option("--contacts", o->variant.contacts,
                "contacts of a session, e.g. 160 or 5000; as in the plan if left out")
      ->check(CLI::PositiveNumber);
  c->add_flag("--one-sided", o->variant.oneSided, "every contact from one side of x, of y and of z");
  c->add_flag("--free-centres", o->variant.freeCentres, "the balls' centres are not known");
  c->add_flag("--outliers", o->variant.outliers, "3 % of the contacts are wrong by 20 um");
  c->add_flag("--heavy-tails", o->variant.heavyTails, "noise of Student's t with three degrees of freedom");
  c->add_flag("--time-temperature", o->variant.timeTemperature,
              "the room only warms up: temperatures go with time");
  c->add_option("--stated-noise", o->variant.statedNoise,
                "the artifact states the noise times this factor, e.g. 0.5 or 2; none: it states nothing");
  c->add_option("--seed", o->seed, "first seed")->capture_default_str();
  c->add_flag("--verbose", o->verbose, "a line for each session, not only for those that went wrong");
  c->footer(
      "Example: mm benchmark --plan config/plans/nine_ball_plate.yaml --trials 100 --effects 2 --size 1");
  c->callback([o] { run(*o); });
}

}  // namespace mm
