// Which temperatures to measure, as typed: from a CSV, from a bag, with a picture; what is bad input.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <iomanip>
#include <random>
#include <sstream>

#include "run_mm.h"

namespace mm {
namespace {

/// `useful` makes the displacement with a second sensor, `copy` drifts together with it, `still` stands.
std::string seriesCsv() {
  std::ostringstream out;
  out << std::setprecision(9) << "time_s,useful,second,copy,other,still,nose_um\n";
  std::mt19937_64 generator(5);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 120; ++k) {
    const double a = 30.0 + 8.0 * std::sin(0.11 * k), b = 25.0 + 5.0 * std::cos(0.29 * k);
    out << 60 * k << ',' << a + 0.02 * normal(generator) << ',' << b + 0.02 * normal(generator) << ','
        << 1.1 * a - 2.0 + 0.022 * normal(generator) << ',' << 22.0 + normal(generator) << ",21,"
        << 3.0 * a + 1.5 * b + 0.1 * normal(generator) << '\n';
  }
  return out.str();
}

void expectRefusal(const Answer& answer, const std::string& part) {
  EXPECT_EQ(answer.status, 2);
  EXPECT_NE(answer.error.find(part), std::string::npos) << answer.error;
  std::istringstream lines(answer.error);
  std::string line;
  int errors = 0;
  while (std::getline(lines, line)) errors += line.find("error") != std::string::npos;
  EXPECT_EQ(errors, 1) << answer.error;
}

TEST(Sensors, PictureOfACsv) {
  const TestFolder folder;
  const std::string csv = folder.write("series.csv", seriesCsv());
  const Answer answer = mmRun(
      folder, "sensors " + csv + " --target nose_um --max 2 --picture " + folder / "bars.svg" + " --json");
  ASSERT_EQ(answer.status, 0) << answer.error;
  EXPECT_NE(answer.error.find("'still' does not vary"), std::string::npos) << answer.error;
  const nlohmann::json json = answer.json();
  ASSERT_EQ(json["recommended"].size(), 2u);
  const std::string one = json["recommended"][0], two = json["recommended"][1];
  EXPECT_TRUE(one == "second" || two == "second") << json["recommended"];
  // useful and copy know the same of it
  EXPECT_TRUE(one == "useful" || two == "useful" || one == "copy" || two == "copy") << json["recommended"];
  ASSERT_FALSE(json["equivalent"].empty());  // useful and copy drift together
  const std::string picture = textOf(folder / "bars.svg");
  EXPECT_EQ(picture.compare(0, 4, "<svg"), 0);
  EXPECT_NE(picture.find("</svg>"), std::string::npos);
  EXPECT_EQ(picture.find("href"), std::string::npos);  // complete in itself
  for (const char* name : {"useful", "second", "recommended", "held-out error"})
    EXPECT_NE(picture.find(name), std::string::npos) << name;
  EXPECT_NE(picture.find("held-out error, \u00b5m"), std::string::npos);
  char bits[32];  // each bar has its value
  for (const nlohmann::json& one : json["single"]) {
    std::snprintf(bits, sizeof(bits), ">%.2f</text>", one["mutual_information_nat"].get<double>());
    EXPECT_NE(picture.find(bits), std::string::npos) << one;
  }

  std::string places = "sensor,x_mm,y_mm,z_mm\nuseful,0,0,0\nsecond,100,0,50\ncopy,10,0,0\nother,200,80,0\n";
  const std::string file = folder.write("places.csv", places + "still,0,80,50\n");
  const std::string command =
      "sensors " + csv + " --target nose_um --max 2 --picture " + folder / "space.svg" + " --positions ";
  ASSERT_EQ(mmRun(folder, command + file).status, 0);
  EXPECT_NE(textOf(folder / "space.svg").find("<circle"), std::string::npos);
  expectRefusal(mmRun(folder, command + folder.write("few.csv", places)), "sensor 'still' has no position");
}

TEST(Sensors, FromABag) {
  const TestFolder folder;
  ASSERT_EQ(std::system(("'" POSITION_ERROR_PROGRAM "' simulate " + folder / "e").c_str()), 0);
  const Answer imported =
      mmRun(folder, "import " + folder / "e/training.csv" + " --machine three_axis -o " + folder / "s.bag");
  ASSERT_EQ(imported.status, 0) << imported.error;
  const Answer answer = mmRun(folder, "sensors " + folder / "s.bag" + " --target x --max 2 --json");
  ASSERT_EQ(answer.status, 0) << answer.error;
  EXPECT_EQ(answer.json()["single"].size(), 32u);
  EXPECT_LT(answer.json()["sets"][0]["cv_rms_um"].get<double>(), 3.0);
  expectRefusal(mmRun(folder, "sensors " + folder / "s.bag" + " --target w"),
                "'w' is not an axis of the machine");
}

/// What CalculiX prints of three nodes and of the growth of a nose that follows the second, in metres.
std::string calculixText(int steps) {
  std::ostringstream text;
  const auto set = [&](const std::string& what, int s) {
    text << "\n " << what << " and time  " << 72.0 * (s + 1) << "\n\n";
  };
  for (int s = 0; s < steps; ++s) {
    const double rise = 5.0 * std::sin(0.2 * s), other = std::cos(0.53 * s);
    set("temperatures for set CANDIDATES", s);
    text << "       126 " << 20.0 + other << "\n       207 " << 20.0 + rise << "\n       288 "
         << 20.0 + 0.3 * rise + other << '\n';
    set("displacements (vx,vy,vz) for set NOSE", s);
    text << "        21 " << -2e-6 * rise << " 0 0\n        22 " << -4e-6 * rise << " 1E-7 0\n";
  }
  return text.str();
}

TEST(Sensors, FromTheResultsOfACalculixRun) {
  const TestFolder folder;
  const std::string whole = folder.write("job.dat", calculixText(60));
  const Answer answer = mmRun(folder, "sensors " + whole + " --target NOSE_x_m --max 1 --json");
  ASSERT_EQ(answer.status, 0) << answer.error;
  EXPECT_EQ(answer.json()["sets"][0]["sensors"][0], "node_207");
  EXPECT_LT(answer.json()["sets"][0]["cv_rms_um"].get<double>(), 1e-3);
  expectRefusal(mmRun(folder, "sensors " + whole + " --target NOSE"), "NOSE_x_m, NOSE_x_mm, NOSE_y_m");
  const std::string text = calculixText(60);
  const std::string cut = folder.write("cut.dat", text.substr(0, text.rfind(" displacements")));
  expectRefusal(mmRun(folder, "sensors " + cut + " --target NOSE_x_m"), "60 of 60, is incomplete");
  const std::string diverged = folder.write("nan.dat", calculixText(3) + "  23 NaN 0 0\n");
  expectRefusal(mmRun(folder, "sensors " + diverged + " --target NOSE_x_m"), "'NaN' is not a finite number");
}

TEST(Sensors, BadInputIsOneClearLine) {
  const TestFolder folder;
  const std::string head = "time_s,a,b,nose_um\n";
  const auto refused = [&](const std::string& rows, const std::string& part) {
    expectRefusal(mmRun(folder, "sensors " + folder.write("bad.csv", head + rows) + " --target nose_um"),
                  part);
  };
  refused("0,20,21,1\n", "at least 4");
  refused("0,20,21,1\n1,20,21,2\n2,20,21,3\n3,20,21,4\n4,20,21,5\n", "none of the temperatures varies");
  refused("0,20,21,1\n1,20.5,21,2\n2,20,21\n", "bad.csv:4:");
  refused("0,20,21,1\n1,20.5,,2\n", "bad.csv:3:");
  expectRefusal(mmRun(folder, "sensors " + folder.write("s.csv", seriesCsv()) + " --target noze_um"),
                "there is no column 'noze_um'");
}

TEST(SpindleHousing, SaysThatCalculixIsMissingOrStopped) {
  const TestFolder folder;
  const auto run = [&](const std::string& ccx) {
    const int status = std::system(("CCX='" + ccx +
                                    "' MM='" MM_PROGRAM "' SPINDLE_HOUSING='" SPINDLE_HOUSING_PROGRAM
                                    "' sh examples/spindle_housing/run.sh " +
                                    folder / "h" + " >" + folder / "out" + " 2>" + folder / "err")
                                       .c_str());
    return Answer{WIFEXITED(status) ? WEXITSTATUS(status) : -1, textOf(folder / "out"),
                  textOf(folder / "err")};
  };
  expectRefusal(run(folder / "no_such_program"), "is not installed: apt install calculix-ccx");
  const std::string stopped = folder.write("stopped", "#!/bin/sh\necho ' *ERROR: diverged'; exit 201\n");
  std::filesystem::permissions(stopped, std::filesystem::perms::owner_all);
  expectRefusal(run(stopped), "ccx stopped with an error");
  const std::string empty = folder.write("empty", "#!/bin/sh\nexit 0\n");
  std::filesystem::permissions(empty, std::filesystem::perms::owner_all);
  expectRefusal(run(empty), "ccx wrote no results");
  const std::string early =
      folder.write("early", "#!/bin/sh\necho ' temperatures for set X and time 72' >housing.dat\n");
  std::filesystem::permissions(early, std::filesystem::perms::owner_all);
  expectRefusal(run(early), "housing.dat");
}

}  // namespace
}  // namespace mm
