#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "base/error.h"
#include "base/json_text.h"
#include "design/session_doubts.h"
#include "estimation/ball_centres.h"
#include "report/json.h"
#include "report/text.h"
#include "ros_bridge/bag_session.h"
#include "session/session_hash.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/output_files.h"
#include "tools/population_prior.h"
#include "tools/progress_bar.h"
#include "tools/session_input.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

struct CalibrateCommand {
  Bags bags;
  std::string model, output, method = "staged_mutation", curve, stages, prior, priorExcept;
  bool json = false, traditional = false, twoSteps = false;
  std::optional<std::size_t> population, generations;
  FitOptions fit;
  OutputFiles files;
};

/// "15:1,30:0.5": last generation and share of half the range. @throw InputError.
std::vector<MutationStage> stagesOf(const std::string& text) {
  std::vector<MutationStage> stages;
  std::istringstream list(text);
  for (std::string one; std::getline(list, one, ',');) {
    std::istringstream in(one);
    MutationStage stage;
    char colon = 0;
    if (!(in >> stage.lastGeneration >> colon >> stage.fraction) || colon != ':' || !(in >> std::ws).eof())
      throw InputError("--stages: '" + one +
                       "' is not <last generation>:<fraction of half the range>, e.g. 15:1,30:0.5,50:0.05");
    stages.push_back(stage);
  }
  return stages;
}

/// The published settings of both algorithms, as their structs hold them.
void declareGenetic(CLI::App& command, CalibrateCommand& c) {
  StagedMutationSettings& s = c.fit.calibrate.stagedMutation;
  NichingSettings& n = c.fit.calibrate.niching;
  const auto add = [&](const char* group, const char* name, auto& value, double lower, double upper,
                       const char* what) {
    standardOption(command, name, value, numberWithin(lower, upper), what)->group(group);
  };
  const char* const both = "Genetic algorithm";
  checkedOption(command, "--population", c.population, wholeNumberWithin(2, 10'000'000),
                "population size [staged_mutation 500, niching 200]")
      ->group(both);
  checkedOption(command, "--generations", c.generations, wholeNumberWithin(0, 1'000'000'000),
                "number of generations [staged_mutation 100, niching 500]")
      ->group(both);
  const char* const staged = "Genetic algorithm: staged_mutation";
  add(staged, "--father-share", s.fatherShare, 1e-6, 1.0,
      "fraction of the population, the best, selected as parents");
  command
      .add_option("--stages", c.stages,
                  "mutation range by generation: <last generation>:<fraction of half the range>, … "
                  "[15:1,30:0.5,50:0.05,75:0.005,100:0.0005]")
      ->group(staged);
  add(staged, "--survivor-share", s.survivorShare, 0.0, 1.0,
      "elite fraction: share of the population that is kept unchanged");
  add(staged, "--gene-share", s.geneShare, 0.0, 1.0, "mutation probability of each gene");
  add(staged, "--reach", s.reach, 1e-12, 1.0,
      "multiply each mutation range by reach^v, v uniform in 0 to 1; 1: uniform mutation as published");
  const char* const niching = "Genetic algorithm: niching";
  add(niching, "--crossover", n.crossover, 0.0, 1.0, "probability");
  add(niching, "--mutation", n.mutation, 0.0, 1.0, "mutation probability of each gene");
  add(niching, "--precision", n.precision, 1e-15, 0.1, "resolution of a gene, as a fraction of its range");
  add(niching, "--threshold", n.threshold, 0.0, 1.0,
      "niche radius: drop chromosomes closer than this fraction of the ranges' diagonal");
  add(niching, "--niching-reach", n.reach, 1e-15, 1.0,
      "multiply each mutation range by reach^v, v uniform in 0 to 1; 1: uniform mutation");
  command
      .add_flag(
          "--traditional", c.traditional,
          "do not drop close chromosomes: the traditional algorithm that the niching is compared with in Fei "
          "et al.")
      ->group(niching);
}

int runCalibrate(CalibrateCommand& c) {
  CalibrateOptions options = c.fit.checked();
  options.method = methodOf(c.method);
  if (!c.stages.empty()) options.stagedMutation.stages = stagesOf(c.stages);
  for (GeneticSettings* settings : {static_cast<GeneticSettings*>(&options.stagedMutation),
                                    static_cast<GeneticSettings*>(&options.niching)}) {
    if (c.population) settings->population = *c.population;
    if (c.generations) settings->generations = *c.generations;
  }
  options.niching.eliminate = !c.traditional;
  options.stagedMutation.validate();
  options.niching.validate();
  c.files.input(c.bags.paths);
  c.files.input(c.model);
  c.files.output("-o", c.output, FileKind::kCalibration);
  c.files.output("--curve", c.curve, FileKind::kCurve);
  c.files.check();
  PriorOfSisters prior(c.prior, c.priorExcept);
  const ModelSpec model = loadModelSpec(c.model);
  Session session = loadSession(c.bags.joined(), model, c.model, c.fit.space);
  const std::vector<Doubt> questions = askFirst(session);
  std::vector<std::string> hashes{sessionHash(session)};
  if (c.twoSteps) {
    session = centresByPosture(session, modelFor(session, model.effects));
    hashes.push_back(sessionHash(session));
  }
  c.files.checkSession(hashes, 1);

  Recalibration done = withBar("calibrating", options, [&] {
    return prior.join(recalibrate(session, model, options), session, options);
  });
  std::vector<std::string> doubts = postureDoubts(session);
  const bool asked =
      std::any_of(questions.begin(), questions.end(), [](const Doubt& d) { return std::isfinite(d.before); });
  if (!done.result.cancelled && !asked)
    for (const std::string& doubt : fitDoubts(done.result)) doubts.push_back(doubt);
  warn(doubts);
  const int status = verdictOf(done.result);
  done.calibration.sessionSpace = bagSpace(c.bags.joined(), c.fit.space);
  if (!c.output.empty()) c.files.write(c.output, done.calibration);
  const bool angular = !std::isfinite(done.result.figures.rms);
  if (!c.curve.empty())
    c.files.write(c.curve, curveCsv(done.result.genetic.value_or(GeneticSummary()), angular));
  if (c.json) {
    std::string json = calibrateJson(done.result, questions);
    if (prior.asked()) {
      Json more = Json::parse(json);
      more["prior"] = prior.json();
      json = jsonText(more);
    }
    std::cout << json << '\n';
  } else {
    std::cout << calibrateText(done.result) << '\n';
    if (!c.output.empty()) std::cout << "written to " << c.output << '\n';
    if (!done.result.cancelled) std::cout << nextText(done.result, c.bags.joined(), c.output);
  }
  return status;
}

}  // namespace

void addCalibrateCommand(CLI::App& app, int& exitStatus) {
  auto [c, command] = addCommand<CalibrateCommand>(app, exitStatus, runCalibrate, "calibrate",
                                                   "Estimate the parameters of a model from a session");
  c.bags.declare(command);
  command.add_option("--model", c.model, "YAML file with the machine and its effects")->required();
  command.add_option("-o,--output", c.output, "the calibration file");
  command
      .add_option("--method", c.method,
                  "least_squares: no search, sufficient if all parameters are linear; staged_mutation or "
                  "niching: genetic search (seconds) for models with several minima, refined by least "
                  "squares")
      ->capture_default_str();
  command.add_flag("--json", c.json, "print the result as JSON on standard output");
  command.add_flag(
      "--two-steps", c.twoSteps,
      "fit in two steps as in Fei et al.: first the ball centre in each posture, then the model to the "
      "centres (default: fit all contacts and parameters together)");
  command.add_option(
      "--prior", c.prior,
      "folder of machines of the same type (results of mm batch, or calibrations): use their parameters as a "
      "prior, unless the session contradicts it (default: no prior)");
  command.add_option("--prior-except", c.priorExcept, "machine of that folder to exclude from the prior");
  command.add_option("--curve", c.curve, "write the best RMS of each generation as CSV");
  c.files.declare(command);
  c.fit.declare(command, true);
  declareGenetic(command, c);
  command.footer(
      "Exit status 1: the fit did not converge, or the session does not determine a parameter that no "
      "convention\n"
      "fixes; the file is still written.\n"
      "Example:\n"
      "  mm calibrate plate.bag --model model.yaml -o plate.yaml\n"
      "  mm calibrate monday.bag tuesday.bag --model model.yaml -o both.yaml");
}

}  // namespace mm
