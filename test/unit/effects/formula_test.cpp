// The user's own physics: names, units, errors, derivatives; and the NIST regressions, whose certified values
// they must reach.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <regex>
#include <sstream>
#include <thread>

#include "base/error.h"
#include "base/units.h"
#include "effects/numeric_derivative.h"
#include "effects_support.h"

namespace mm {
namespace {

class FormulaTest : public ::testing::Test {
 protected:
  FormulaTest()
      : machine(Machine::load("five_axis")), domain(domainOf(machine, false)), layout(machine.layout()) {
    std::mt19937_64 random(9);
    state = randomState(machine, domain, random);
  }
  EffectPtr make(const std::string& direction, const std::string& formula,
                 std::vector<std::string> start = {}) {
    EffectSpec spec("formula");
    spec.set("direction", direction).set("formula", formula);
    if (!start.empty()) spec.setList("start", std::move(start));
    return createEffect(spec, domain);
  }
  double value(const std::string& direction, const std::string& formula, const std::vector<double>& p,
               int slot) {
    return evaluate(*make(direction, formula), domain, state, p).values[slot];
  }
  std::string refusal(const std::string& formula, std::vector<std::string> start = {}) {
    try {
      make("x", formula, std::move(start));
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return error.what();
    }
    return "accepted";
  }
  int joint(const char* name) const { return machine.findJoint(name); }

  Machine machine;
  Domain domain;
  ErrorLayout layout;
  State state;
};

TEST_F(FormulaTest, variablesAreInTheUnitsOfPeople) {
  const int x = layout.axis(joint("x"));
  EXPECT_NEAR(value("x", "k1*x", {2.0}, x), 2.0 * state.position[joint("x")] * 1e3 * 1e-6, 1e-18);
  EXPECT_NEAR(value("x", "k1*b", {2.0}, x), 2.0 * state.position[joint("b")] * 1e-6, 1e-18);
  EXPECT_EQ(value("x", "k1*x_travel", {2.0}, x), 2e-6 * state.travel[joint("x")]);
  EXPECT_NEAR(value("x", "k1*x_velocity", {2.0}, x), 2.0 * state.velocity[joint("x")] * 1e3 * 1e-6, 1e-18);
  EXPECT_NEAR(value("x", "k1*b_velocity", {2.0}, x), 2.0 * state.velocity[joint("b")] * 1e-6, 1e-18);
  EXPECT_NEAR(value("x", "k1*t", {2.0}, x), 2.0 * state.time * 1e-6, 1e-15);
  EXPECT_NEAR(value("x", "k1*bed", {2.0}, x), 2.0 * state.temperature[0] * 1e-6, 1e-18);
  EXPECT_NEAR(value("x", "k1*humidity", {2.0}, x), 2.0 * state.covariate[0] * 1e-6, 1e-18);
  EXPECT_NEAR(value("x", "k1*pi*e", {1.0}, x), kPi * std::exp(1.0) * 1e-6, 1e-18);
}

TEST_F(FormulaTest, valueIsInMicrometresOrArcseconds) {
  EXPECT_NEAR(value("b", "k1", {3.0}, layout.axis(joint("b"))), 3.0 * kArcsecond, 1e-18);
  const auto error = evaluate(*make("approach", "k1"), domain, state, {3.0}).values;
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(error[layout.volume(k)], 3e-6 * state.approach[k], 1e-18);
  state.approach.setZero();
  EXPECT_TRUE(std::isnan(evaluate(*make("approach", "k1"), domain, state, {3.0}).values[layout.volume(0)]));
  state.feature = -1;
  EXPECT_EQ(evaluate(*make("approach", "k1"), domain, state, {3.0}).values[layout.volume(0)], 0.0);
}

TEST_F(FormulaTest, missingInputsGiveNanEvenInABranchNotTaken) {
  state.velocity.assign(5, kNan);
  EXPECT_TRUE(std::isnan(value("x", "x_velocity > 0 ? k1 : -k1", {1.0}, layout.axis(joint("x")))));
  EXPECT_FALSE(std::isnan(value("x", "x > 0 ? k1 : -k1", {1.0}, layout.axis(joint("x")))));
}

TEST_F(FormulaTest, linearityIsFoundHonestly) {
  for (const char* text : {"k1*x*y", "k1*x + k2*sin(2*pi*y/3)", "k1*(x>0) - k2*(x_velocity<0)", "(k1+k2*x)^1",
                           "k1*exp(-t/600)", "k1*sqrt(abs(x))", "k1*(bed-20)+k2*(frame-20)", "-k1/(1+x^2)"})
    EXPECT_TRUE(make("x", text)->linear()) << text;
  for (const char* text :
       {"k1*x + 3", "k1*k2*x", "k1*x^k2", "abs(k1)*x", "k1^2*x", "max(k1,0)*x", "sin(k1*x)",
        "k1*x + k2*k2*1e-6", "x > 100 ? k1*k1 : k1", "k1 > 0 ? k1*x : 2*k1*x"})
    EXPECT_FALSE(make("x", text)->linear()) << text;
  EXPECT_EQ(make("x", "k1*exp(-k2*t) + k3*x")->nature().nonlinear, (std::vector<int>{1}));
  EXPECT_EQ(make("x", "k1*k2*x")->nature().nonlinear, (std::vector<int>{1}));
}

TEST_F(FormulaTest, startIsOneOrZeroOrWhatIsGiven) {
  EXPECT_EQ(make("x", "k1*x^k2")->parameters()[1].start, 1.0);
  EXPECT_EQ(make("x", "k1*x")->parameters()[0].start, 0.0);
  EXPECT_EQ(make("x", "k10*x + k2*y^k3", {"1.5", "-2", "3e-3"})->parameters()[2].start, 3e-3);
  EXPECT_EQ(make("x", "k10*x + k2*y")->parameters()[1].name, "k10");
  EXPECT_EQ(make("x", "k10*x + k2*y")->parameters()[0].name, "k2");
}

TEST_F(FormulaTest, mistakesAreNamed) {
  const auto expect = [&](const std::string& text, const std::vector<std::string>& parts,
                          std::vector<std::string> start = {}) {
    const std::string message = refusal(text, std::move(start));
    for (const auto& part : parts)
      EXPECT_NE(message.find(part), std::string::npos) << message << "\n lacks: " << part;
  };
  expect("k1*q", {"unknown variable 'q'", "known: ", "x_velocity", "humidity"});
  expect("k1*humidty", {"did you mean 'humidity'"});
  expect("k0*x", {"unknown variable 'k0'"});
  expect("k1*x+", {"syntax", "position 5"});
  expect("k1*(x", {"syntax", "position"});
  expect("k1**x", {"syntax", "powers are written ^"});
  expect("x*y", {"nothing to estimate"});
  expect("k1=x", {"'=' at position 3"});
  expect("k1,x", {"one expression"});
  expect("", {"'formula'"});
  expect("k1*foo(x)", {"syntax"});
  expect("k1*x", {"start must hold 1"}, {"1", "2"});
  expect("k1*x", {"'start'", "finite number"}, {"one"});
}

TEST_F(FormulaTest, namesThatMeanTwoThingsAreRefusedAndOwnNamesWinOverConstants) {
  domain.sensors[2] = "e";
  EXPECT_NEAR(value("x", "k1*e", {1.0}, layout.axis(joint("x"))), state.temperature[2] * 1e-6, 1e-18);
  EXPECT_NEAR(value("x", "k1*pi*e", {1.0}, layout.axis(joint("x"))), kPi * state.temperature[2] * 1e-6,
              1e-18);
  domain.sensors[2] = "x";
  EXPECT_NE(refusal("k1*x").find("two things"), std::string::npos);
  EXPECT_EQ(refusal("k1*y"), "accepted");
  domain.sensors[2] = "k1";
  EXPECT_NE(refusal("k1*y").find("two things"), std::string::npos);
  domain.sensors[2] = "bed-left";
  EXPECT_EQ(refusal("k1*bed_left"), "accepted");
  domain.sensors[2] = "sin";
  EXPECT_EQ(refusal("k1*sin(x)"), "accepted");
}

TEST_F(FormulaTest, severalThreadsSeeTheSameValues) {
  const EffectPtr effect = make("x", "k1*exp(-t/k2)*x + k3*sin(y)", {"1", "500", "2"});
  std::vector<State> states;
  std::mt19937_64 random(1);
  for (int i = 0; i < 2000; ++i) states.push_back(randomState(machine, domain, random));
  const auto run = [&](std::vector<double>* out) {
    for (const State& s : states) {
      const Collector sink = evaluate(*effect, domain, s, {1.1, 450.0, 2.0});
      out->push_back(sink.values[layout.axis(joint("x"))]);
      out->push_back(sink.slopes[layout.axis(joint("x"))][1]);
    }
  };
  std::vector<double> alone, first, second;
  run(&alone);
  std::thread a(run, &first), b(run, &second);
  a.join();
  b.join();
  EXPECT_EQ(first, alone);
  EXPECT_EQ(second, alone);
}

TEST(NumericDerivative, isGoodToTwelveDigits) {
  const auto check = [](const std::function<double(double)>& f, double x, double typical, double exact,
                        double tolerance) {
    EXPECT_NEAR(numericDerivative(f, x, typical), exact, tolerance * std::abs(exact));
  };
  for (const double x : {1e-3, 0.3, 2.0, 40.0}) {
    check([](double v) { return std::exp(-v); }, x, 1.0, -std::exp(-x), x > 10 ? 1e-10 : 1e-12);
    check([](double v) { return std::pow(v, -1.07); }, x, 1.0, -1.07 * std::pow(x, -2.07), 1e-12);
    check([](double v) { return std::sin(12.0 * v); }, x, 1.0, 12.0 * std::cos(12.0 * x),
          x > 10 ? 1e-10 : 1e-11);  // the phase itself is rounded
    check([](double v) { return std::log(v); }, x, 1.0, 1.0 / x, 1e-12);
  }
  check([](double v) { return std::exp(-0.5 * (v - 450.0) * (v - 450.0) / 16.0); }, 452.0, 1.0,
        -2.0 / 16.0 * std::exp(-0.125), 1e-12);
  // periods that simple steps would meet
  for (const double n : {1.0, 8.0, 64.0})
    check([n](double v) { return std::sin(2 * kPi * n * v); }, 0.25 + 1.0 / 64, 1.0,
          2 * kPi * n * std::cos(2 * kPi * n * (0.25 + 1.0 / 64)), 1e-10);
}

TEST(NumericDerivative, comesThroughAtAnEdge) {
  EXPECT_NEAR(numericDerivative([](double v) { return std::sqrt(v * v * v); }, 1e-6, 1.0), 1.5e-3, 1e-12);
  EXPECT_NEAR(numericDerivative([](double v) { return v < 1.0 ? kNan : v * v; }, 1.0, 1.0), 2.0, 1e-6);
  EXPECT_NEAR(numericDerivative([](double v) { return v > 1.0 ? kNan : v * v; }, 1.0, 1.0), 2.0, 1e-6);
  EXPECT_TRUE(std::isnan(numericDerivative([](double v) { return v == 1.0 ? 1.0 : kNan; }, 1.0, 1.0)));
}

// ---------------------------------------------------------------------------------------------------------------
// NIST StRD: at the certified parameters the gradient of the sum of squares vanishes, and the covariance is
// certified.

struct Nist {
  std::string name, formula;
  std::vector<double> second, certified, deviation, x, x2, y;
  bool logY = false;
};

Nist readNist(const std::filesystem::path& file) {
  Nist nist;
  nist.name = file.stem().string();
  std::ifstream in(file);
  std::string line, model;
  bool data = false, modelLines = false;
  const std::regex parameter(R"(^\s*b\d+\s*=\s*(\S+)\s+(\S+)\s+(\S+)\s+(\S+)\s*$)");
  std::smatch m;
  while (std::getline(in, line)) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (std::regex_match(line, m, parameter)) {
      nist.second.push_back(std::stod(m[2]));
      nist.certified.push_back(std::stod(m[3]));
      nist.deviation.push_back(std::stod(m[4]));
    } else if (std::regex_search(line, std::regex(R"(^Data:\s+y\s)"))) {
      data = true;
    } else if (line.rfind("Model:", 0) == 0) {
      modelLines = true;
    } else if (line.find("Starting") != std::string::npos) {
      modelLines = false;
    } else if (modelLines) {
      model += line;
    } else if (data && !line.empty()) {
      std::istringstream row(line);
      double y = 0.0, x = 0.0, x2 = 0.0;
      row >> y >> x;
      if (row >> x2) nist.x2.push_back(x2);
      nist.y.push_back(y);
      nist.x.push_back(x);
    }
  }
  const auto equals = model.rfind('=');
  std::string f = model.substr(equals + 1);
  nist.logY = model.find("log[y]") != std::string::npos;
  f = f.substr(0, f.rfind("+  e") != std::string::npos ? f.rfind("+  e") : f.rfind("+ e"));
  const auto replace = [&](const std::string& from, const std::string& to) {
    f = std::regex_replace(f, std::regex(from), to);
  };
  replace(R"(\*\*)", "^");
  replace(R"(\[)", "(");
  replace(R"(\])", ")");
  replace("arctan", "atan");
  replace(R"(\bb(\d+))", "k$1");
  replace(R"(\bx1\b)", "humidity");
  replace(R"(\bx2\b)", "load");
  replace(R"(\bx\b)", "humidity");
  nist.formula = f;
  return nist;
}

TEST(Nist, derivativesReproduceTheCertifiedStandardDeviations) {
  const std::filesystem::path folder = "../shared/data/nist_strd";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << folder << " is not here";
  const Machine machine = Machine::load("three_axis");
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".dat") continue;
    const Nist nist = readNist(entry.path());
    SCOPED_TRACE(nist.name + ": " + nist.formula);
    Domain domain = domainOf(machine, false);
    ASSERT_FALSE(nist.y.empty());
    domain.covariateLower = {*std::min_element(nist.x.begin(), nist.x.end()), 0.0};
    domain.covariateUpper = {*std::max_element(nist.x.begin(), nist.x.end()), 1.0};
    EffectSpec spec("formula");
    std::vector<std::string> start;
    for (const double s : nist.second) start.push_back(EffectSpec().set("s", s).text("s"));
    spec.set("direction", "x").set("formula", nist.formula).setList("start", start);
    const EffectPtr effect = createEffect(spec, domain);
    const int n = effect->parameterCount(), rows = static_cast<int>(nist.y.size());
    ASSERT_EQ(n, static_cast<int>(nist.certified.size()));
    std::mt19937_64 random(1);
    State state = randomState(machine, domain, random);
    Eigen::MatrixXd jacobian(rows, n);
    Eigen::VectorXd residual(rows);
    for (int i = 0; i < rows; ++i) {
      state.covariate = {nist.x[i], i < static_cast<int>(nist.x2.size()) ? nist.x2[i] : 0.0};
      const Collector sink = evaluate(*effect, domain, state, nist.certified);
      residual[i] = (nist.logY ? std::log(nist.y[i]) : nist.y[i]) - sink.values[0] * 1e6;
      for (int p = 0; p < n; ++p) jacobian(i, p) = sink.slopes[0][p] * 1e6;
    }
    const Eigen::VectorXd scale = jacobian.colwise().norm();
    const Eigen::MatrixXd scaled = jacobian * scale.cwiseInverse().asDiagonal();
    const Eigen::MatrixXd r =
        Eigen::HouseholderQR<Eigen::MatrixXd>(scaled).matrixQR().topRows(n).triangularView<Eigen::Upper>();
    const Eigen::MatrixXd inverse = r.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(n, n));
    const double sigma = residual.norm() / std::sqrt(static_cast<double>(rows - n));
    // Lanczos1's data are exact to 13 digits: its residuals are the rounding of the certified parameters.
    if (nist.name != "Lanczos1") {
      for (int p = 0; p < n; ++p)
        EXPECT_NEAR(sigma * inverse.row(p).norm() / scale[p] / nist.deviation[p], 1.0, 1e-4) << "k" << p + 1;
    }
    // the Gauss-Newton step from the certified parameters is nothing beside their certified digits
    const Eigen::VectorXd step = scaled.colPivHouseholderQr().solve(residual).cwiseQuotient(scale);
    for (int p = 0; p < n; ++p) EXPECT_LT(std::abs(step[p] / nist.certified[p]), 1e-7) << "k" << p + 1;
    ++count;
  }
  EXPECT_EQ(count, 27);
}

}  // namespace
}  // namespace mm
