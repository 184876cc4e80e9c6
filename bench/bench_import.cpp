// Import: rows a second of a CSV with one million contacts (three axes, their velocities, two temperatures),
// and of the bag made of it.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <random>

#include "ros_bridge/bag_session.h"
#include "session/artifact_file.h"
#include "session/contacts_csv.h"

namespace {

constexpr int kRows = 1000000;
constexpr int kBalls = 70;

/// The files of the benchmark, made once and removed at the end.
class Files {
 public:
  Files() : folder_(std::filesystem::temp_directory_path() / ("mm_bench_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    std::string yaml = "name: plate\nballs:\n";
    for (int b = 0; b < kBalls; ++b)
      yaml += "  - {name: b" + std::to_string(b) + ", centre_mm: [" + std::to_string(b) +
              ", 0, 0], radius_mm: 4}\n";
    artifact = mm::parseArtifact(yaml, "plate");
    std::FILE* out = std::fopen(csv().c_str(), "w");
    std::fputs(
        "time_s,x_mm,y_mm,z_mm,x_velocity_mm_s,y_velocity_mm_s,z_velocity_mm_s,feature,bed_degC,frame_degC\n",
        out);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> u(-20.0, 20.0);
    for (int i = 0; i < kRows; ++i)
      std::fprintf(out, "%.3f,%.6f,%.6f,%.6f,%.4f,%.4f,%.4f,b%d,%.3f,%.3f\n", 0.1 * i, u(random), u(random),
                   u(random), u(random), u(random), u(random), i % kBalls, u(random), u(random));
    std::fclose(out);
  }
  ~Files() { std::filesystem::remove_all(folder_); }
  std::filesystem::path csv() const { return folder_ / "contacts.csv"; }
  std::filesystem::path bag() const { return folder_ / "session.bag"; }
  mm::Artifact artifact;
  mm::Machine machine = mm::Machine::load("three_axis");

 private:
  std::filesystem::path folder_;
};

Files& files() {
  static Files once;
  return once;
}

mm::Session readCsv() {
  const mm::TextFile text(files().csv());
  const mm::Machine& machine = files().machine;
  return mm::readTable(text, mm::ownForm(text, machine), machine, &files().artifact).session;
}

void csvToSession(benchmark::State& state) {
  files();
  for (auto _ : state) benchmark::DoNotOptimize(readCsv());
  state.SetItemsProcessed(state.iterations() * kRows);
}
BENCHMARK(csvToSession)->Unit(benchmark::kMillisecond)->MinTime(3.0);

void sessionToBag(benchmark::State& state) {
  const mm::Session session = readCsv();
  for (auto _ : state) mm::writeSessionBag(session, files().bag());
  state.SetItemsProcessed(state.iterations() * kRows);
}
BENCHMARK(sessionToBag)->Unit(benchmark::kMillisecond)->Iterations(1);

void bagToSession(benchmark::State& state) {
  if (!std::filesystem::exists(files().bag())) mm::writeSessionBag(readCsv(), files().bag());
  for (auto _ : state) benchmark::DoNotOptimize(mm::readSessionBag(files().bag()));
  state.SetItemsProcessed(state.iterations() * kRows);
}
BENCHMARK(bagToSession)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace

BENCHMARK_MAIN();
