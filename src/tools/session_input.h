#pragma once
#include <string>

#include "calibration_file/calibration.h"
#include "estimation/calibrate.h"
#include "model/model_spec.h"
#include "session/sense_checks.h"
#include "session/session.h"
#include "tools/one_line.h"

namespace CLI {
class App;
}

namespace mm {

/// The sessions that a command is given: one bag, or several that are judged together.
struct Bags {
  std::vector<std::string> paths;

  /// Adds the positional option. @param session in words.
  void declare(CLI::App& command,
               const std::string& session = "the session, or several to evaluate together");
  std::string joined() const;  ///< "a.bag:b.bag", as services take them
};

/// Reads a session's bag, or several as "a.bag:b.bag", with a progress bar; what is wrong with it, and what
/// was set aside in it, is said on standard error.
/// @param fallback machine of a bag that does not bring its own; may be null. @param space of `--namespace`;
/// empty: the only one that there is. @throw InputError.
Session loadSession(const std::string& bag, const Machine* fallback, const std::string& space);
/// The same for a session that goes with a calibration: of the machine that was calibrated, which is also
/// that of a bag without one. @throw InputError: of another machine, naming what differs.
Session loadSession(const std::string& bag, const Calibration& calibration, const std::string& space);
/// The same for a session that a model is made for: of the machine that the model names, where it names one.
/// @param file of the model. @throw InputError: of another machine; an effect cannot be made for the session
/// (names file and line).
Session loadSession(const std::string& bag, const ModelSpec& model, const std::string& file,
                    const std::string& space);
/// What is likely mistaken in a session's units, signs and names: a line on standard error each, before
/// anything is computed from it.
std::vector<Doubt> askFirst(const Session& session);
/// The option --namespace.
void declareNamespace(CLI::App& command, std::string& space);

/// The options of a fit that several commands share: --namespace, --seed, --threads, --repeatability-um,
/// --keep-outliers.
struct FitOptions {
  CalibrateOptions calibrate;
  double repeatability = 0.0;  // um; 0: not stated
  bool keepOutliers = false;
  std::string space;  // of the session's topics

  /// Adds the options. @param genetic also seed and threads of the genetic algorithms.
  void declare(CLI::App& command, bool genetic);
  /// The options checked, with progress on `bar`'s terminal and Ctrl-C as cancel. @throw InputError.
  CalibrateOptions checked() const;
};

/// What commands are asked that judge a session by a calibration.
struct SessionAndCalibration {
  Bags bags;
  std::string calibration;
  bool json = false;
  FitOptions fit;

  /// Adds the session, --calibration and --json. @param session in words.
  void declare(CLI::App& command, const std::string& session);
};

/// Says what Ctrl-C and doubtful results mean: a line on standard error each. @return exit status: done, the
/// answer is no, or stopped.
int verdictOf(const CalibrationResult& result);

}  // namespace mm
