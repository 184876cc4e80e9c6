// Single sessions of scripts/judge_sessions, whose physics are not the package's, that once were told
// wrongly.
#include <gtest/gtest.h>

#include <filesystem>

#include "run_mm.h"

namespace mm {
namespace {

/// The diagnosis of one session. @param number of those that its seed gives.
nlohmann::json diagnosisOf(int seed, int number) {
  const TestFolder work;
  const std::string make = "/usr/bin/python3 scripts/judge_sessions --count 1 --first " +
                           std::to_string(number) + " --seed " + std::to_string(seed) + " --out " +
                           work / "made" + " > /dev/null";
  EXPECT_EQ(std::system(make.c_str()), 0) << make;
  for (const auto& session : std::filesystem::directory_iterator(work / "made")) {
    for (const auto& file : std::filesystem::directory_iterator(session))
      std::filesystem::copy(file.path(), work / file.path().filename().string());
  }
  std::istringstream commands(textOf(work / "command"));
  for (std::string command; std::getline(commands, command);) {
    const std::string line = "cd '" + work / "." + "' && " + programAnd(command) + " > answer.json";
    EXPECT_EQ(std::system(line.c_str()), 0) << line;
  }
  return nlohmann::json::parse(textOf(work / "answer.json"));
}

// Readings of 3 um make stairs of a scale: a curve says as much and predicts nothing beside it, which says
// nothing against the scale. It was named, at odds of 1 to 30.
TEST(Judged, AScaleThatIsReadInStepsKeepsItsOdds) {
  const nlohmann::json d = diagnosisOf(20261129, 48);
  ASSERT_FALSE(d["missing"].empty()) << d["sentence"];
  EXPECT_EQ(d["missing"][0]["effect"]["type"], "scale") << d["sentence"];
  EXPECT_GT(d["missing"][0]["odds"].get<double>(), 0.4) << d["sentence"];
}

}  // namespace
}  // namespace mm
