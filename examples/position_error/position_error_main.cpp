// The experiment of DFNN: writes its measurements, and prints its table and that over many machines.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>

#include "base/error.h"
#include "experiment.h"

namespace mm {
namespace {

const std::vector<std::pair<std::string, std::string>> kMethods = {
    {"dfnn", "DFNN"},
    {"dfnn_published", "DFNN, 9 rules as printed"},
    {"rbf", "exact RBF"},
    {"ridge", "ridge-linear"},
    {"none", "none"}};
const std::map<std::string, ThermalLaw> kLaws = {{"linear", ThermalLaw::kLinear},
                                                 {"saturating", ThermalLaw::kSaturating},
                                                 {"bending", ThermalLaw::kBending}};

double rms(const Eigen::MatrixXd& m) { return m.norm() / std::sqrt(static_cast<double>(m.size())); }

void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  out.close();
  if (!out)
    throw InputError(file.string() + ": cannot be written; check the folder and the space on the disk");
}

void simulate(const std::string& folder, std::uint64_t seed, ThermalLaw law, int days) {
  const Experiment e(seed, law, days);
  std::filesystem::create_directories(folder);
  write(std::filesystem::path(folder) / "training.csv", importCsv(e, true));
  write(std::filesystem::path(folder) / "test.csv", importCsv(e, false));
}

/// DFNN, Table 2: what is left of the test's deviations.
void table(std::uint64_t seed, ThermalLaw law, int days) {
  const Experiment e(seed, law, days);
  std::printf("inputs, by grey relational grade:");
  for (const int i : e.inputs) std::printf(" %s", sensorNames()[static_cast<std::size_t>(i)].c_str());
  std::printf("\n\n%-26s", "left, RMS / largest, um");
  for (const double minutes : e.testMinutes) std::printf("  %7.0f min     ", minutes);
  std::printf("\n");
  for (const auto& [method, name] : kMethods) {
    const Eigen::MatrixXd left = leftBy(method, e);
    std::printf("%-26s", name.c_str());
    for (Eigen::Index k = 0; k < left.rows(); ++k)
      std::printf("  %6.2f / %6.2f", rms(left.row(k)), left.row(k).cwiseAbs().maxCoeff());
    std::printf("\n");
  }
}

/// Test RMSE over many machines; three warm-ups each.
void machines(int count) {
  std::printf("test RMSE over %d machines, median / 90 %%, um\n%-26s", count, "");
  for (const auto& [name, law] : kLaws) std::printf("  %15s", name.c_str());
  std::printf("\n");
  std::map<std::string, std::map<std::string, std::vector<double>>> errors;
  for (const auto& [lawName, law] : kLaws)
    for (int k = 0; k < count; ++k) {
      const Experiment e(100 + static_cast<std::uint64_t>(k), law, 3);
      for (const auto& method : kMethods)
        errors[method.first][lawName].push_back(rms(leftBy(method.first, e)));
    }
  for (const auto& [method, name] : kMethods) {
    std::printf("%-26s", name.c_str());
    for (const auto& law : kLaws) {
      std::vector<double>& all = errors[method][law.first];
      std::sort(all.begin(), all.end());
      std::printf("  %6.2f / %6.2f", all[all.size() / 2], all[std::min(all.size() - 1, all.size() * 9 / 10)]);
    }
    std::printf("\n");
  }
}

int run(int argc, char** argv) {
  CLI::App app(
      "The experiment of DFNN: a mill that warms up, measured at 11 positions, with 32 temperatures");
  app.require_subcommand(1);
  std::uint64_t seed = 1;
  std::string folder, law = "saturating";
  int count = 40, days = 1;
  const auto common = [&](CLI::App& command) {
    command.add_option("--seed", seed, "of the mill and its measurements")->capture_default_str();
    command.add_option("--days", days, "warm-ups to learn from; 1 as in the paper")
        ->capture_default_str()
        ->check(CLI::Range(1, 3));
    command.add_option("--law", law, "how the growth follows the temperatures")
        ->capture_default_str()
        ->check(CLI::IsMember(kLaws));
  };
  CLI::App* writes = app.add_subcommand("simulate", "training.csv and test.csv for mm import");
  writes->add_option("folder", folder, "where they go")->required();
  common(*writes);
  CLI::App* prints =
      app.add_subcommand("table", "what DFNN, RBF, ridge and nothing leave at 0, 60 and 120 min");
  common(*prints);
  CLI::App* many = app.add_subcommand("machines", "the same over many machines, for each law");
  many->add_option("count", count, "machines")->capture_default_str()->check(CLI::Range(1, 1000));
  CLI11_PARSE(app, argc, argv);
  if (*writes) simulate(folder, seed, kLaws.at(law), days);
  if (*prints) table(seed, kLaws.at(law), days);
  if (*many) machines(count);
  return 0;
}

}  // namespace
}  // namespace mm

int main(int argc, char** argv) {
  try {
    return mm::run(argc, argv);
  } catch (const std::exception& e) {
    std::cerr << "position_error: error: " << e.what() << '\n';
    return 2;
  }
}
