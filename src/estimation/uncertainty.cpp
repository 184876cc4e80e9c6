// The stages of a calibration after the fit: uncertainty, repeatability, figures.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "estimation/ball_columns.h"
#include "estimation/calibration_stages.h"
#include "estimation/folds.h"
#include "estimation/noise_rows.h"
#include "estimation/thin_qr.h"
#include "estimation/whitened.h"
#include "thermal/thermal_network.h"

namespace mm {
namespace {

constexpr double kFewestFreedoms = 40;  // fewer residuals beyond the unknowns do not tell a memory
// Rows and columns from which the memory is found: variances are known to a tenth from as many, and the time
// goes with rows times columns squared.
constexpr int kMostRows = 1500, kMostColumns = 40;
/// Log evidence that a drift must earn: coverage under drift is what it should be with it, and too small with
/// 5.
constexpr double kDriftPrice = 3.0;

/// How the covariance of the unknowns is larger where the noise has memory, and what that memory is; and
/// where the balls lie beside the places in their file.
struct Memory {
  NoiseFitResult fit;
  LinearisedRows rows;
  RowMatrix centres, radii;                 // see BallColumns: used rows, in units of sigma
  double centresStd = 0.0, radiiStd = 0.0;  // in units of sigma
};

/// Rows of a column that are used, as they count.
RowMatrix usedOf(const Eigen::MatrixXd& columns, const std::vector<int>& used, const Fit& fit) {
  RowMatrix out(columns.cols() > 0 ? static_cast<Eigen::Index>(used.size()) : 0, columns.cols());
  for (Eigen::Index i = 0; i < out.rows(); ++i) {
    const int row = used[static_cast<std::size_t>(i)];
    out.row(i) = std::sqrt(fit.weight[row]) * columns.row(row);
  }
  return out;
}

/// The noise taken for a contact, m.
double contactSigma(const Problem& problem, const Fit& fit) {
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < problem.rowCount(); ++i)
    if (fit.weight[i] > 0.0 &&
        problem.session().observations[problem.rows()[i].observation].kind == ObservationKind::kContact)
      sum += fit.sigma[i], ++count;
  return count > 0 ? sum / count : 0.0;
}

/// The noise of what a fit has left. @param q orthonormal columns of the fit, the last `shared` of which are
/// those of unknowns that all rows share.
Memory memoryOf(const Linearisation& at, const Fit& fit, const WhitenedSystem& system,
                const Eigen::MatrixXd& q, int shared) {
  std::vector<int> used;
  for (int i = 0; i < at.problem().rowCount(); ++i)
    if (fit.weight[i] > 0.0) used.push_back(i);
  const int n = static_cast<int>(used.size()), columns = std::min(shared, kMostColumns);
  RowMatrix base = q(used, Eigen::lastN(columns));
  Eigen::VectorXd target = system.residuals(used);
  Memory memory;
  memory.rows = noiseRows(at, used, fit.sigma, std::move(target), std::move(base));
  NoiseModel white;
  white.variance = Eigen::VectorXd::Ones(n);
  NoiseFitOptions options;
  options.driftPrice = kDriftPrice;
  const BallColumns balls = ballColumns(at, used);
  memory.centres = usedOf(balls.centres, used, fit);
  memory.radii = usedOf(balls.radii, used, fit);
  std::vector<RandomBlock> blocks;
  for (const RowMatrix* columns : {&memory.centres, &memory.radii})
    if (columns->cols() > 0) blocks.push_back({*columns, 0.0, kDriftPrice, false});
  memory.fit = fitNoise(memory.rows.rows, std::move(blocks), white, options, kMostRows);
  std::size_t block = 0;
  if (memory.centres.cols() > 0) memory.centresStd = memory.fit.ratios[block++];
  if (memory.radii.cols() > 0) memory.radiiStd = memory.fit.ratios[block];
  return memory;
}

/// Covariance of least squares under noise V: R^-1 Q' V Q R^-T. @param priors rows of q after the data.
Eigen::MatrixXd covarianceUnder(const Memory& memory, const Fit& fit, const Eigen::MatrixXd& q,
                                const Eigen::MatrixXd& inverseR) {
  const Eigen::Index data = fit.weight.size();
  RowMatrix all(static_cast<Eigen::Index>(memory.rows.rows.time.size()), q.cols());
  for (Eigen::Index i = 0, k = 0; i < data; ++i)
    if (fit.weight[i] > 0.0) all.row(k++) = q.row(i);
  const TimeWhitener whitener =
      whitenerOf(memory.rows.rows, memory.fit.noise.variance, memory.fit.noise.drift);
  Eigen::MatrixXd middle = Eigen::MatrixXd(all.transpose() * whitener.covarianceTimes(all));
  const auto priors = q.bottomRows(q.rows() - data);
  middle += priors.transpose() * priors;
  const auto addScatter = [&](const RowMatrix& columns, double ratio) {
    if (!(ratio > 0.0)) return;
    const Eigen::MatrixXd seen = ratio * (all.transpose() * columns);
    middle += seen * seen.transpose();
  };
  addScatter(memory.centres, memory.centresStd);
  addScatter(memory.radii, memory.radiiStd);
  middle *= memory.fit.white * memory.fit.white;
  return inverseR * middle * inverseR.transpose();
}

}  // namespace

void Uncertainty::takeFreedoms(int taken) {
  if (taken <= 0 || dof <= 0.0) return;
  const double left = std::max(1.0, dof - taken);
  covariance *= dof / left;
  dof = left;
}

Uncertainty uncertaintyOf(const Problem& problem, const Fit& fit, const std::vector<char>& fixed,
                          bool whiteNoise) {
  Uncertainty u;
  const Linearisation at = linearise(problem, fit.x);
  const WhitenedSystem system(at, inverseOf(fit.sigma, fit.weight), fixed);
  const int columns = static_cast<int>(system.free.size()), rows = static_cast<int>(system.jacobian.rows());
  const int data = problem.rowCount();
  for (int i = data; i < rows; ++i) u.priorChi2 += system.residuals[i] * system.residuals[i];
  u.dof = static_cast<double>((fit.weight.array() > 0.0).count()) + (rows - data) - columns;
  u.covariance.setZero(problem.unknownCount(), problem.unknownCount());
  Eigen::MatrixXd q(rows, 0);
  if (columns > 0 && rows >= columns) {
    const std::vector<LocalBlock> blocks = localBlocks(problem, system.jacobian, system.free);
    ThinQr qr = thinQr(system.jacobian, blocks, true);
    q = std::move(qr.q);
    Eigen::MatrixXd inverseR(columns, columns);  // its rows in the order of the unknowns
    const Eigen::MatrixXd inverse =
        qr.r.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(columns, columns));
    inverseR(qr.order, Eigen::all) = inverse;
    const double variance = u.dof > 0 ? system.residuals.squaredNorm() / u.dof : 1.0;
    Eigen::MatrixXd c = variance * inverseR * inverseR.transpose();
    if (!whiteNoise && u.dof >= kFewestFreedoms) {
      int local = 0;
      for (const LocalBlock& b : blocks) local += static_cast<int>(b.columns.size());
      const Memory memory = memoryOf(at, fit, system, q, columns - local);
      if (!memory.fit.noise.drift.empty() || memory.centresStd > 0.0 || memory.radiiStd > 0.0)
        c = covarianceUnder(memory, fit, q, inverseR);
      const double sigma = memory.fit.white * contactSigma(problem, fit);
      u.centresStd = memory.centresStd * sigma;
      u.radiiStd = memory.radiiStd * sigma;
      for (const DriftTerm& t : memory.fit.noise.drift)
        u.drift.push_back({memory.rows.directions[t.direction],
                           t.ratio * memory.fit.white * memory.rows.directionScale[t.direction], t.tau,
                           t.smooth});
    }
    u.covariance(system.free, system.free) = system.scale.asDiagonal() * c * system.scale.asDiagonal();
  }
  u.heldOut = heldOutResiduals(q, system.residuals, makeFolds(problem));
  for (int i = 0; i < data; ++i) u.heldOut[i] *= fit.sigma[i];
  return u;
}

int networkUnknowns(const Model& model) {
  int count = 0;
  for (const LearnedNetwork& network : model.networks())
    if (network.active) count += networkFromNumbers(network.numbers)->unknowns();
  return count;
}

void addNetworkShift(const Problem& problem, const Eigen::VectorXd& x, const Eigen::MatrixXd& shift,
                     Eigen::VectorXd& heldOut) {
  const Linearisation at = linearise(problem, x);
  const Model& model = problem.model();
  Eigen::VectorXd gain = Eigen::VectorXd::Zero(shift.cols());
  for (std::size_t e = 0; e < model.effects().size(); ++e)
    if (model.effects()[e]->nature().learned && model.effects()[e]->parameterCount() == 1)
      gain[model.domain().findJoint(model.effects()[e]->spec().text("axis"))] =
          x[model.offset(static_cast<int>(e))];
  const ErrorLayout layout = model.machine().layout();
  for (int i = 0; i < problem.rowCount(); ++i)
    for (int j = 0; j < static_cast<int>(shift.cols()); ++j)
      heldOut[i] += at.slotGradients()(i, layout.axis(j)) * gain[j] * shift(problem.rows()[i].observation, j);
}

namespace {

/// Root mean square of what the used rows of one kind state of themselves; 0 where one of them states
/// nothing.
double statedByRows(const Problem& problem, const Eigen::VectorXd& weight, bool angular) {
  double sum = 0.0;
  int n = 0;
  for (int i = 0; i < weight.size(); ++i) {
    const ResidualRow& row = problem.rows()[i];
    if (weight[i] == 0.0 || row.angular != angular) continue;
    if (!(row.statedSigma > 0.0)) return 0.0;
    sum += row.statedSigma * row.statedSigma;
    ++n;
  }
  return n > 0 ? std::sqrt(sum / n) : 0.0;
}

}  // namespace

RepeatabilityUsed repeatabilityOf(const Problem& problem, const Fit& fit, double dof) {
  const bool angularOnly = !has(problem, false);
  RepeatabilityUsed used;
  used.noise = fit.noise;
  used.value = angularOnly ? fit.noise.angular : fit.noise.linear;
  used.from = fit.noise.from;
  if (used.from != "estimated") {
    if (const double stated = statedByRows(problem, fit.weight, angularOnly); stated > 0.0)
      used.value = stated;
    return used;
  }
  used.repeated = repeatedMeasurements(problem, fit.residuals, angularOnly);
  if (used.repeated.dof > 0.0) {
    used.from = "repeated";
    used.value = used.repeated.value;
  } else {
    const double rms = rmsOf(problem, fit.residuals, fit.weight, angularOnly);
    const double rows = (fit.weight.array() > 0.0).count();
    used.value = rms * std::sqrt(rows / std::max(1.0, dof));
  }
  const double factor = used.value / (angularOnly ? fit.noise.angular : fit.noise.linear);
  used.noise.linear *= factor;
  used.noise.angular *= factor;
  return used;
}

ResidualFigures figuresOf(const Problem& problem, const Fit& fit, const Uncertainty& uncertainty,
                          const Eigen::VectorXd& sigma) {
  const Eigen::VectorXd& r = fit.residuals;
  ResidualFigures f;
  f.rms = rmsOf(problem, r, fit.weight, false);
  f.rmsAngular = rmsOf(problem, r, fit.weight, true);
  f.heldOutRms = rmsOf(problem, uncertainty.heldOut, fit.weight, false);
  f.heldOutRmsAngular = rmsOf(problem, uncertainty.heldOut, fit.weight, true);
  double chi2 = uncertainty.priorChi2;
  for (int i = 0; i < r.size(); ++i)
    if (fit.weight[i] > 0.0) chi2 += fit.weight[i] * r[i] * r[i] / (sigma[i] * sigma[i]);
  f.degreesOfFreedom = std::max(0, static_cast<int>(uncertainty.dof));
  f.chi2PerDof = uncertainty.dof > 0 ? chi2 / uncertainty.dof : 0.0;
  return f;
}

ResidualFigures nominalFigures(const Session& session, const Model& model, const CalibrateOptions& options,
                               const Fit& fit) {
  const Problem nominal(session, Model(model.machine(), model.domain(), std::vector<EffectPtr>{}));
  CalibrateOptions plain = options;
  plain.rejectOutliers = false;
  plain.progress = {};
  const Identifiability gauge = identify(nominal, nominal.start(), inverseOf(fit.sigma, fit.weight), false);
  const FitTask task{nominal, gauge.fixed, plain};
  Fit before = fitFrom(task, nominal.start(), fit.noise);
  before.weight = fit.weight;
  before = refined(task, std::move(before));
  Uncertainty uncertainty = uncertaintyOf(nominal, before, gauge.fixed, true);
  uncertainty.priorChi2 = 0.0;
  return figuresOf(nominal, before, uncertainty, fit.sigma);
}

}  // namespace mm
