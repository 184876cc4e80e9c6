#include "tools/change_command.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "calibration_file/calibration_yaml.h"
#include "report/json.h"
#include "report/text.h"
#include "session/session_hash.h"
#include "tools/output_files.h"
#include "tools/progress_bar.h"
#include "tools/session_input.h"

namespace mm {
namespace {

struct ChangeOptions {
  std::string bag, effect, calibration, output;
  bool json = false;
  FitOptions fit;
  OutputFiles files;
};

int runChange(ChangeOptions &c, ModelChange change) {
  c.files.input(c.bag);
  c.files.calibration(c.calibration);
  c.files.output("-o", c.output, FileKind::kCalibration);
  c.files.check();
  CalibrateOptions options = c.fit.checked();
  const EffectSpec effect = parseEffectSpec(c.effect, "effect");
  const Calibration before = loadCalibration(c.calibration);
  const Session session = loadSession(c.bag, before, c.fit.space);
  c.files.checkSession({sessionHash(session)});
  std::optional<Recalibration> done;
  {
    ProgressBar bar("refitting");
    options.progress = [&](const std::string &stage, double share) {
      bar.show(share, stage);
    };
    done = change(session, before, effect, options);
  }
  const int status = verdictOf(done->result);
  if (!c.output.empty())
    c.files.write(c.output, done->calibration);
  if (c.json) {
    std::cout << changeJson(done->result, done->calibration.ledger) << '\n';
    return status;
  }
  std::cout << ledgerText(done->calibration.ledger,
                          !std::isfinite(done->result.figures.rms))
            << '\n'
            << calibrateText(done->result);
  if (!c.output.empty())
    std::cout << "\nwritten to " << c.output << '\n';
  return status;
}

} // namespace

void declareChange(CLI::App &command, ModelChange change,
                   const std::string &example, int &exitStatus) {
  auto c = std::make_shared<ChangeOptions>();
  command.add_option("bag", c->bag, "the session")->required();
  command.add_option("effect", c->effect, "YAML: {type: backlash, axis: x}")
      ->required();
  command.add_option("--calibration", c->calibration, "the calibration file")
      ->required();
  command.add_option("-o,--output", c->output, "the new calibration file");
  command.add_flag("--json", c->json, "the result as JSON on standard output");
  c->files.declare(command);
  c->fit.declare(command, false);
  command.footer("Example:\n  " + example);
  command.callback(
      [c, change, &exitStatus] { exitStatus = runChange(*c, change); });
}

} // namespace mm
