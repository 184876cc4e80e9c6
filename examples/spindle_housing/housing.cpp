#include "housing.h"

#include <algorithm>
#include <cmath>
#include <ostream>
#include <sstream>

#include "base/error.h"
#include "thermal/calculix_results.h"

namespace mm {
namespace {

constexpr double kLength = 0.400, kWidth = 0.160;          // m
constexpr double kFrontPower = 180.0, kRearPower = 110.0;  // W of the bearings at full speed
// W/(m^2 K): to the air, in the wind of the motor fan (right face), through the foot
constexpr double kFilm = 14.0, kFanFilm = 25.0, kFootFilm = 60.0;
constexpr double kAir = 20.0;  // degC

/// Share of the time from a to b (s) in which the spindle runs: the mean power of an implicit step.
double running(double a, double b) {
  const double runs[3][2] = {{0, 600}, {900, 2100}, {2400, 1e9}};
  double time = 0.0;
  for (const auto& run : runs) time += std::max(0.0, std::min(b, run[1]) - std::max(a, run[0]));
  return time / (b - a);
}

void writeSet(std::ostream& deck, const std::string& name, const std::vector<int>& nodes) {
  deck << "*NSET, NSET=" << name << '\n';
  for (int n : nodes) deck << n << ",\n";
}

}  // namespace

Housing::Housing() {
  const auto add = [&](const std::string& face, int j, int k) {
    for (int i = 1; i <= 18; ++i) {
      std::ostringstream name;
      name.precision(2);
      name << std::fixed << face << '_' << static_cast<double>(i - kFront) / (kRear - kFront) << 'L';
      candidates_.push_back({node(i, j, k), name.str()});
    }
  };
  add("top", kY / 2, kY);
  add("left", 0, kY / 2);
  add("right", kY, kY / 2);
}

std::vector<int> Housing::noseNodes() const {
  std::vector<int> nodes;  // the rim of the bore in the front face
  for (int j = kBore; j <= kY - kBore; ++j)
    for (int k = kBore; k <= kY - kBore; ++k)
      if (!insideBore(j, k)) nodes.push_back(node(0, j, k));
  return nodes;
}

void Housing::writeMesh(std::ostream& deck) const {
  deck << "*NODE, NSET=ALL\n";
  for (int i = 0; i <= kX; ++i)
    for (int j = 0; j <= kY; ++j)
      for (int k = 0; k <= kY; ++k)
        if (!insideBore(j, k))
          deck << node(i, j, k) << ", " << kLength * i / kX << ", " << kWidth * j / kY << ", "
               << kWidth * k / kY << '\n';
  deck << "*ELEMENT, TYPE=C3D8, ELSET=BLOCK\n";
  for (int i = 0; i < kX; ++i)
    for (int j = 0; j < kY; ++j)
      for (int k = 0; k < kY; ++k)
        if (!inBore(j, k))
          deck << node(i, j, k) << ", " << node(i, j, k) << ", " << node(i + 1, j, k) << ", "
               << node(i + 1, j + 1, k) << ", " << node(i, j + 1, k) << ", " << node(i, j, k + 1) << ", "
               << node(i + 1, j, k + 1) << ", " << node(i + 1, j + 1, k + 1) << ", " << node(i, j + 1, k + 1)
               << '\n';
}

void Housing::writeLoads(std::ostream& deck) const {
  std::ostringstream film, flux;
  const double cell = kWidth / kY,
               area = 4.0 * (kY - 2 * kBore) * cell * 2.0 * kLength / kX;  // of one seat, m^2
  const auto outer = [&](int i, int j, int k, int number, double coefficient) {
    film << node(i, j, k) << ", F" << number << ", " << kAir << ", " << coefficient << '\n';
  };
  const auto seats = [&](int i, int j, int k, int number) {
    for (const int seat : {kFront, kRear})
      if (i == seat - 1 || i == seat)
        flux << node(i, j, k) << ", S" << number << ", " << (seat == kFront ? kFrontPower : kRearPower) / area
             << '\n';
  };
  const auto bore = [](int j, int k) { return j >= 0 && j < kY && k >= 0 && k < kY && inBore(j, k); };
  for (int i = 0; i < kX; ++i)
    for (int j = 0; j < kY; ++j)
      for (int k = 0; k < kY; ++k) {
        if (inBore(j, k)) continue;
        if (k == 0) outer(i, j, k, 1, i > kX / 2 ? kFootFilm : kFilm);
        if (k == kY - 1) outer(i, j, k, 2, kFilm);
        if (j == 0) outer(i, j, k, 3, kFilm);
        if (i == kX - 1) outer(i, j, k, 4, kFilm);
        if (j == kY - 1) outer(i, j, k, 5, kFanFilm);
        if (i == 0) outer(i, j, k, 6, kFilm);
        if (bore(j, k - 1)) seats(i, j, k, 1);
        if (bore(j, k + 1)) seats(i, j, k, 2);
        if (bore(j - 1, k)) seats(i, j, k, 3);
        if (bore(j + 1, k)) seats(i, j, k, 5);
      }
  deck << "*FILM\n" << film.str() << "*DFLUX, AMPLITUDE=DUTY\n" << flux.str();
}

void Housing::writeDeck(std::ostream& deck) const {
  deck.precision(10);
  deck << "** Spindle housing: two bearing seats as heat sources, convection, duty of two hours. SI units.\n";
  writeMesh(deck);
  std::vector<int> foot, candidates;
  for (int i = kX / 2 + 1; i <= kX; ++i)
    for (int j = 0; j <= kY; ++j) foot.push_back(node(i, j, 0));
  for (const Candidate& candidate : candidates_) candidates.push_back(candidate.node);
  writeSet(deck, "CANDIDATES", candidates);
  writeSet(deck, "NOSE", noseNodes());
  writeSet(deck, "FOOT", {node(kX / 2 + 1, kY / 2, 0)});
  writeSet(deck, "SOLE", foot);
  deck << "*MATERIAL, NAME=IRON\n*ELASTIC\n1.1e11, 0.26\n*DENSITY\n7200.\n*EXPANSION, ZERO=" << kAir
       << "\n1.05e-5\n*CONDUCTIVITY\n48.\n*SPECIFIC HEAT\n500.\n"
       << "*SOLID SECTION, ELSET=BLOCK, MATERIAL=IRON\n"
       << "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, " << kAir << "\n*AMPLITUDE, NAME=DUTY\n";
  const double step = kDuration / kSamples;
  for (int s = 1; s <= kSamples; ++s) deck << step * s << ", " << running(step * (s - 1), step * s) << '\n';
  // The sole rests on the machine bed and may slide on it; its front end is pinned.
  deck << "*BOUNDARY\nSOLE, 3, 3\nFOOT, 1, 2\n" << node(kX, kY / 2, 0) << ", 2, 2\n";
  deck << "*STEP, INC=1000\n*UNCOUPLED TEMPERATURE-DISPLACEMENT, DIRECT\n"
       << step << ", " << kDuration << '\n';
  writeLoads(deck);
  deck << "*NODE PRINT, NSET=CANDIDATES\nNT\n*NODE PRINT, NSET=NOSE\nU\n*END STEP\n";
}

void Housing::writePositions(std::ostream& csv) const {
  csv << "sensor,x_mm,y_mm,z_mm\n";
  for (const Candidate& candidate : candidates_) {
    const int n = candidate.node - 1, side = kY + 1;  // as node() numbers them
    csv << candidate.name << ',' << 1e3 * kLength * (n / side / side) / kX << ','
        << 1e3 * kWidth * (n / side % side) / kY << ',' << 1e3 * kWidth * (n % side) / kY << '\n';
  }
}

void Housing::convert(const std::string& results, std::ostream& csv) const {
  const CalculixResults run = readCalculixResults(results);
  if (run.samples() != kSamples || run.sets != std::vector<std::string>{"NOSE"})
    throw InputError(results + ": " + std::to_string(run.samples()) + " of " + std::to_string(kSamples) +
                     " samples, " + std::to_string(run.sets.size()) +
                     " of 1 displaced set; ccx stopped early or diverged, see its log");
  csv << "time_s";
  std::vector<Eigen::Index> columns;
  for (const Candidate& candidate : candidates_) {
    csv << ',' << candidate.name;
    const auto found = std::find(run.nodes.begin(), run.nodes.end(), candidate.node);
    if (found == run.nodes.end())
      throw InputError(results + ": node " + std::to_string(candidate.node) + " (" + candidate.name +
                       ") is missing; it is not of this housing's deck");
    columns.push_back(found - run.nodes.begin());
  }
  csv << ",nose_um\n";
  csv.precision(9);
  for (Eigen::Index s = 0; s < kSamples; ++s) {
    csv << run.time[static_cast<std::size_t>(s)];
    for (const Eigen::Index column : columns) csv << ',' << run.temperatures(s, column);
    csv << ',' << -1e6 * run.mean[0](s, 0) << '\n';
  }
}

}  // namespace mm
