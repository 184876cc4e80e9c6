#include "diagnosis/diagnose.h"

#include <Eigen/Dense>

#include "diagnosis/structure.h"
#include "machine/cancel_scope.h"
#include "machine/error.h"

namespace mm {

Diagnosis diagnose(const Session& session, const Model& model, const DiagnoseOptions& options,
                   const Eigen::VectorXd& start) {
  Diagnosis out;
  const CancelScope scope(options.cancelled);
  try {
    CalibrateOptions fit = options.calibrate;
    fit.method = Method::kLeastSquares;
    fit.progress = {};
    fit.cancelled = options.cancelled;
    out.base = calibrate(session, model, fit, start);
    out.where = whereItFails(out.base);
    out.verdict = Verdict::kScatter;
  } catch (const NumericalError& error) {
    out.verdict = Verdict::kInsufficientData;
    out.sentence = std::string("The model cannot be fitted to this session: ") + error.what();
  }
  return out;
}

std::vector<WhereItFails> whereItFails(const CalibrationResult& fitted) {
  fitted.problem->linearise(fitted.x);
  const ResidualSpace space(fitted);
  return explainedByVariable(space, space.target(), Eigen::MatrixXd(space.length(), 0));
}

}  // namespace mm
