#include "uncertainty/length_tests.h"

#include <cmath>
#include <set>

#include "base/units.h"
#include "uncertainty/setup_rows.h"

namespace mm {
namespace {

constexpr int kFewestLengths = 5;  // ISO 10360-2
constexpr double kSameLength = 1.0 * kMillimetre;

struct FaceRow {
  int observation = 0;
  double distance = 0.0;  // m, nominal, from the instrument's point
};

/// Whether a joint of one row came from the other side than that of the other.
bool fromOppositeSides(const Observation& a, const Observation& b) {
  for (std::size_t j = 0; j < a.travel.size(); ++j)
    if (a.travel[j] * b.travel[j] < 0.0) return true;
  return false;
}

LengthLineTest lengthsOf(const Session& session, const std::vector<FaceRow>& rows, const ResidualOf& left) {
  LengthLineTest test;
  std::set<long> lengths;
  for (std::size_t i = 0; i + 1 < rows.size(); i += 2) {
    const FaceRow &near = rows[i], &far = rows[i + 1];
    const Observation &a = session.observations[near.observation], &b = session.observations[far.observation];
    const double indicated = far.distance - near.distance;
    if (indicated < kSameLength || !fromOppositeSides(a, b)) return {};
    LengthError e;
    e.length = indicated / kMillimetre;
    e.error = (indicated - (b.length - a.length)) / kMicrometre;
    if (left) e.left = (left(near.observation, 0) - left(far.observation, 0)) / kMicrometre;
    test.largest = std::fmax(test.largest, std::abs(e.error));
    test.largestLeft = std::fmax(test.largestLeft, std::abs(e.left));
    lengths.insert(std::lround(indicated / kSameLength));
    test.errors.push_back(e);
  }
  test.lengths = lengths.size();
  return rows.size() % 2 == 0 ? test : LengthLineTest{};
}

}  // namespace

std::vector<LengthLineTest> lengthTests(const Session& session, const ResidualOf& left) {
  std::vector<LengthLineTest> tests;
  for (const SetupRows& line : lengthsBySetup(session)) {
    std::vector<FaceRow> rows;
    for (const int i : line.observations) {
      const double distance = wayOfLength(session, session.observations[i]).norm();
      if (std::isfinite(distance)) rows.push_back({i, distance});
    }
    LengthLineTest test = lengthsOf(session, rows, left);
    if (test.lengths < kFewestLengths) continue;
    test.name = session.artifact.features[line.feature].name;
    test.setup = line.setup;
    tests.push_back(std::move(test));
  }
  return tests;
}

std::string inWords(const LengthLineTest& test) {
  return "ISO 10360-2, line " + test.name + ": " + std::to_string(test.errors.size()) + " errors of " +
         std::to_string(test.lengths) + " lengths";
}

}  // namespace mm
