#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "estimation/calibrate.h"
#include "model/model_spec.h"
#include "session/session.h"

namespace mm {

/// What a calibration found and the file that keeps it. `result` refers to the session, which must outlive
/// it.
struct Recalibration {
  CalibrationResult result;
  Calibration calibration;
};

/// What is doubtful about a result although there is one: it did not converge, or the session does not
/// determine a parameter; empty: nothing.
std::vector<std::string> doubtsOf(const CalibrationResult& result);

/// Calibrates a session from nothing but a model. The ledger gets its first line.
/// @throw InputError: unknown effect, missing input; NumericalError: too few residuals. As `calibrate`.
Recalibration recalibrate(const Session& session, const ModelSpec& model, const CalibrateOptions& options);

/// Adds one effect and refits everything by least squares from the calibration's values; a line of the ledger
/// tells what it did to the error. Taking it out again (`removeEffect`) restores the figures.
/// @param options method and genetic settings are not used. @throw InputError: the effect is in the model
/// already.
Recalibration addEffect(const Session& session, const Calibration& calibration, const EffectSpec& effect,
                        const CalibrateOptions& options);

/// Takes one effect out and refits. @throw InputError: the effect is not in the model.
Recalibration removeEffect(const Session& session, const Calibration& calibration, const EffectSpec& effect,
                           const CalibrateOptions& options);

/// Teaches the calibration's networks a new session beside what they learned; all else stays. A line of the
/// ledger tells what it did to the error on the new session: RMS as the old networks and as the new ones
/// leave it, held out by blocks. @throw InputError: as updateNetworks(const CalibrationResult&).
Recalibration updateNetworks(const Session& session, const Calibration& calibration,
                             CalibrateOptions options);

/// The calibration as it is, against a session: the effects' parameters are held at the calibration's values;
/// only what belongs to the session (pose of the artifact, free positions, zeros of setups) is fitted.
CalibrationResult compareCalibration(const Session& session, const Calibration& calibration,
                                     CalibrateOptions options);

/// Least squares, with the noise that was declared for the calibration, unless another is stated.
CalibrateOptions refitting(CalibrateOptions options, const Calibration& calibration);

/// The model that a calibration holds, in the calibration's own domain (as it was calibrated).
/// @throw InputError when it cannot be made (an effect of a plugin that is not loaded).
Model modelOf(const Calibration& calibration);
/// Its values (SI), in the order of the model's parameters.
Eigen::VectorXd valuesOf(const Calibration& calibration);
/// The effects of a calibration as a model for `session`: its ranges, its sensors.
Model modelFor(const Session& session, const std::vector<EffectSpec>& effects);
/// Values of `calibration` for the parameters of `model`, by effect and name; the effects' own start
/// elsewhere.
Eigen::VectorXd startFrom(const Calibration& calibration, const Model& model);

/// The file of a result; ledger and provenance of the model are the caller's.
Calibration toCalibration(const CalibrationResult& result, const std::string& machineName);

/// Whether two specs name the same effect: order of keys and spelling of numbers aside, defaults filled in.
bool sameEffect(const EffectSpec& a, const EffectSpec& b, const Domain& domain);

/// @throw InputError when the session was measured on another machine than the one that was calibrated: what
/// differs (joints, their order and kind, where they stand and how they move, where the tip stands) is named.
void checkMachine(const Calibration& calibration, const Session& session);

/// Machine of a model file when it names one. @throw InputError when the joints are not those of the session.
void checkMachine(const ModelSpec& model, const std::filesystem::path& folder, const Session& session);

}  // namespace mm
