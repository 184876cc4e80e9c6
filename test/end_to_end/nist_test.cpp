// NIST's Statistical Reference Datasets as `formula` effects, through the library: y is the deviation of an
// axis, the predictors are covariates. What is certified comes from NIST's files.
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "base/units.h"
#include "estimation/calibrate.h"
#include "long_tests.h"
#include "model/observed_domain.h"
#include "nist_problem.h"
#include "shared_data.h"

namespace mm {
namespace {

struct Entry {
  const char *name, *formula;
  bool logarithm = false;  // the model is of log(y)
};

const char* const kLanczos = "k1*exp(-k2*u) + k3*exp(-k4*u) + k5*exp(-k6*u)";
const char* const kGauss = "k1*exp(-k2*u) + k3*exp(-(u-k4)^2/k5^2) + k6*exp(-(u-k7)^2/k8^2)";
const char* const kCubic = "(k1+k2*u+k3*u^2+k4*u^3)/(1+k5*u+k6*u^2+k7*u^3)";

const std::vector<Entry> kProblems = {
    {"Misra1a", "k1*(1-exp(-k2*u))"},
    {"Chwirut1", "exp(-k1*u)/(k2+k3*u)"},
    {"Chwirut2", "exp(-k1*u)/(k2+k3*u)"},
    {"Lanczos1", kLanczos},
    {"Lanczos2", kLanczos},
    {"Lanczos3", kLanczos},
    {"Gauss1", kGauss},
    {"Gauss2", kGauss},
    {"Gauss3", kGauss},
    {"DanWood", "k1*u^k2"},
    {"Misra1b", "k1*(1-(1+k2*u/2)^(-2))"},
    {"Kirby2", "(k1+k2*u+k3*u^2)/(1+k4*u+k5*u^2)"},
    {"Hahn1", kCubic},
    {"Nelson", "k1 - k2*u*exp(-k3*w)", true},
    {"MGH17", "k1 + k2*exp(-u*k4) + k3*exp(-u*k5)"},
    {"Misra1c", "k1*(1-(1+2*k2*u)^(-0.5))"},
    {"Misra1d", "k1*k2*u*((1+k2*u)^(-1))"},
    {"Roszman1", "k1 - k2*u - atan(k3/(u-k4))/pi"},
    {"ENSO",
     "k1 + k2*cos(2*pi*u/12) + k3*sin(2*pi*u/12) + k5*cos(2*pi*u/k4) + k6*sin(2*pi*u/k4) + k8*cos(2*pi*u/k7) "
     "+ "
     "k9*sin(2*pi*u/k7)"},
    {"MGH09", "k1*(u^2+u*k2)/(u^2+u*k3+k4)"},
    {"Thurber", kCubic},
    {"BoxBOD", "k1*(1-exp(-k2*u))"},
    {"Rat42", "k1/(1+exp(k2-k3*u))"},
    {"MGH10", "k1*exp(k2/(u+k3))"},
    {"Eckerle4", "(k1/k2)*exp(-0.5*((u-k3)/k2)^2)"},
    {"Rat43", "k1/((1+exp(k2-k3*u))^(1/k4))"},
    {"Bennett5", "k1*(k2+u)^(-1/k3)"},
};

Session sessionOf(const NistProblem& problem, const Entry& entry) {
  Session session(Machine::load("three_axis"));
  session.source = entry.name;
  const char* const names[] = {"u", "w"};
  for (std::size_t k = 0; k < problem.x.front().size(); ++k)
    session.covariates.push_back({names[k], "1", {}, {}});
  for (std::size_t i = 0; i < problem.y.size(); ++i) {
    Observation o;
    o.kind = ObservationKind::kDeviation;
    o.time = static_cast<double>(i);
    o.row = static_cast<std::int64_t>(i) + 2;
    o.position.assign(3, 0.0);
    o.velocity.assign(3, kNotMeasured);
    o.deviation = {(entry.logarithm ? std::log(problem.y[i]) : problem.y[i]) * kMicrometre, kNotMeasured,
                   kNotMeasured};
    o.deviationStd.assign(3, kNotMeasured);
    session.observations.push_back(o);
    for (std::size_t k = 0; k < problem.x[i].size(); ++k) {
      session.covariates[k].time.push_back(o.time);
      session.covariates[k].value.push_back(problem.x[i][k]);
    }
  }
  session.prepare();
  return session;
}

CalibrationResult solve(const Session& session, const Entry& entry, const std::vector<double>& start,
                        Method method) {
  EffectSpec spec("formula");
  std::vector<std::string> starts;
  for (const double s : start) starts.push_back(EffectSpec().set("s", s).text("s"));
  spec.set("direction", "x").set("formula", entry.formula).setList("start", starts);
  CalibrateOptions options;
  options.whiteNoise = true;  // what is certified
  options.method = method;
  return calibrate(session, Model(session.machine, observedDomain(session), {spec}), options);
}

double relative(double value, double certified) { return std::abs(value - certified) / std::abs(certified); }

/// Largest relative error of the parameters.
double worstParameter(const CalibrationResult& result, const NistProblem& problem) {
  double worst = 0.0;
  for (std::size_t k = 0; k < problem.certified.size(); ++k)
    worst = std::fmax(worst, relative(result.x[static_cast<Eigen::Index>(k)], problem.certified[k]));
  return worst;
}

TEST(Nist, CertifiedValuesFromStart2) {
  MM_NEEDS_SHARED_DATA(folder, "nist_strd");
  for (const Entry& entry : kProblems) {
    SCOPED_TRACE(entry.name);
    const NistProblem problem = readNist(folder / (std::string(entry.name) + ".dat"));
    const Session session = sessionOf(problem, entry);
    const CalibrationResult result = solve(session, entry, problem.start2, Method::kLeastSquares);
    EXPECT_TRUE(result.converged);
    EXPECT_TRUE(result.outliers.empty());
    EXPECT_LT(worstParameter(result, problem), 1e-6);
    if (std::string(entry.name) == "Lanczos1") continue;  // its residuals are below double precision
    for (std::size_t k = 0; k < problem.certified.size(); ++k)
      EXPECT_LT(relative(result.std(static_cast<int>(k)), problem.std[k]), 1e-4) << "b" << k + 1;
    EXPECT_LT(relative(result.residuals.squaredNorm() * 1e12, problem.residualSum), 1e-6);
  }
}

TEST(Nist, CertifiedValuesFromStart1) {
  MM_THOROUGH_ONLY("every day the nearer start stands for it");
  MM_NEEDS_SHARED_DATA(folder, "nist_strd");
  int found = 0;
  for (const Entry& entry : kProblems) {
    const NistProblem problem = readNist(folder / (std::string(entry.name) + ".dat"));
    const Session session = sessionOf(problem, entry);
    std::string how = "least squares";
    CalibrationResult result = solve(session, entry, problem.start1, Method::kLeastSquares);
    if (!(worstParameter(result, problem) < 1e-6)) {
      how = "genetic algorithm first";
      result = solve(session, entry, problem.start1, Method::kStagedMutation);
    }
    const double worst = worstParameter(result, problem);
    if (worst < 1e-6)
      ++found;
    else
      std::cout << entry.name << " from start 1: " << worst << " off\n";
    if (how != "least squares") std::cout << entry.name << ": " << how << '\n';
  }
  EXPECT_GE(found, 25);
}

}  // namespace
}  // namespace mm
