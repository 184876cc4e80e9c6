#pragma once
#include "diagnosis/diagnose.h"

namespace mm {

/// How causes are found: by a search that changes one explanation as long as that helps, or by drawing from
/// the posterior over all sets of causes, of which every answer is a marginal.
enum class DiagnosisMethod { kSearch, kPosterior };

/// As `diagnose`, by a method.
Diagnosis diagnoseBy(DiagnosisMethod method, const Session& session, const Model& model,
                     const DiagnoseOptions& options, const Eigen::VectorXd& start = {});

}  // namespace mm
