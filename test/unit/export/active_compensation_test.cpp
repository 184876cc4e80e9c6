// What is compensated already is never undone: a machine that is plain arithmetic is measured with tables
// active, and the tables that are exported then must correct what it really is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/temporary_folder.h"
#include "base/units.h"
#include "compensation_support.h"
#include "export/export_folder.h"
#include "folder_without_figures.h"

namespace mm {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// The machine without any compensation, as nobody knows it: where the probe is when the motors stand at m.
struct Truth {
  double scale = 0.0, gap = 0.0, slope = 0.0;  // x by x, reversal of x (m), x by y
  double gapY = 0.0;                           // m

  double x(double mx, double my, double way) const { return mx + scale * mx + slope * my - 0.5 * gap * way; }
  double y(double my, double way) const { return my - 0.5 * gapY * way; }
};

/// A calibration that holds exactly this.
Calibration found(const Truth& remains) {
  Calibration c = test::calibrationOf(
      Machine::load("three_axis"),
      {EffectSpec("scale").set("axis", "x"), EffectSpec("backlash").set("axis", "x"),
       EffectSpec("squareness").set("axis", "x").set("of", "y"), EffectSpec("backlash").set("axis", "y")});
  c.values[0].value = remains.scale;
  c.values[1].value = remains.gap;
  c.values[2].value = remains.slope;
  c.values[3].value = remains.gapY;
  c.rms = c.heldOutRms = 0.3e-6;
  return c;
}

ExportOptions fineUnits() {
  ExportOptions options;
  options.detectionUnit = 1e-7;
  return options;
}

std::vector<ExportedFile> folderOf(const Calibration& calibration, const std::string& target) {
  const ExportTarget& to = exportTarget(target);
  const NeededCorrection needed(calibration, {});
  return test::folderWithoutFigures(calibration, to, needed, exportedFor(to, needed, fineUnits()));
}

class Folder {
 public:
  explicit Folder(const std::vector<ExportedFile>& files) {
    for (const ExportedFile& file : files) folder_.write(file.path, file.text);
  }
  std::string path() const { return folder_.path().string(); }
  std::string text(const std::string& file) const {
    std::ifstream in(folder_.path() / file);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  nlohmann::json report() const { return nlohmann::json::parse(text("representability.json")); }

 private:
  TemporaryFolder folder_;
};

CommandedState commandTo(double x, double y, double wayX, double wayY) {
  CommandedState command;
  command.position = {{"x", x}, {"y", y}, {"z", 0.003}};
  command.direction = {{"x", wayX > 0 ? 1 : -1}, {"y", wayY > 0 ? 1 : -1}, {"z", 1}};
  return command;
}

/// Calls with every combination of some places and directions of travel.
void everywhere(const std::function<void(double x, double y, double wayX, double wayY)>& call) {
  for (const double x : {-0.0187, -0.0112, -0.0041, 0.0023, 0.0118, 0.0193})
    for (const double y : {-0.0171, -0.0032, 0.0146})
      for (const double wayX : {-1.0, 1.0})
        for (const double wayY : {-1.0, 1.0}) call(x, y, wayX, wayY);
}

/// The largest error of x and of y that tables leave of the machine, both without their means: a table does
/// not know where the workpiece lies. m.
struct Left {
  double x = 0.0, y = 0.0;
};
Left leftOf(const Truth& truth, const LoadedCompensation& tables) {
  std::vector<double> x, y;
  everywhere([&](double cx, double cy, double wayX, double wayY) {
    const CommandedState command = commandTo(cx, cy, wayX, wayY);
    const std::map<std::string, double> added = tables.adds(command);
    const double mx = cx + added.at("x"), my = cy + added.at("y");
    x.push_back(truth.x(mx, my, wayX) - cx);
    y.push_back(truth.y(my, wayY) - cy);
  });
  const auto most = [](const std::vector<double>& errors) {
    double mean = 0.0, most = 0.0;
    for (const double e : errors) mean += e / static_cast<double>(errors.size());
    for (const double e : errors) most = std::max(most, std::abs(e - mean));
    return most;
  };
  return {most(x), most(y)};
}

struct Target {
  std::string name;
  Truth machine, first;     // what the machine is, and what was found of it before anything was active
  double tolerance = 2e-9;  // m, of x
  bool leavesY = true;      // its files for x say nothing of y
};

/// Of x a part is found in the first round, of y all; the second round finds the rest of x and nothing of y.
std::vector<Target> targets() {
  const Truth pitch{2e-4, 4e-6, 0.0, 3e-6}, halfPitch{1.5e-4, 3e-6, 0.0, 3e-6};
  const Truth angle{0.0, 4e-6, 2e-4, 3e-6}, halfAngle{0.0, 3e-6, 1.5e-4, 3e-6};
  const Truth gap{0.0, 4e-6, 0.0, 3e-6}, halfGap{0.0, 3e-6, 0.0, 3e-6};
  const Truth skew{0.0, 0.0, 2e-4, 0.0}, halfSkew{0.0, 0.0, 1.5e-4, 0.0};
  const Truth plain{2e-4, 0.0, 2e-4, 0.0}, halfPlain{1.5e-4, 0.0, 1.5e-4, 0.0};
  return {{"linuxcnc", pitch, halfPitch},
          {"siemens", pitch, halfPitch},
          {"heidenhain", pitch, halfPitch, 2e-9, false},
          {"fanuc", pitch, halfPitch, 2e-7},
          {"beckhoff", pitch, halfPitch, 2e-7},
          {"isg", plain, halfPlain, 2e-9, false},
          {"csv", pitch, halfPitch, 2e-9, false},
          {"marlin", angle, halfAngle, 2e-9, false},
          {"reprapfirmware", angle, halfAngle},
          {"grblhal", gap, halfGap, 1.1e-7},
          {"klipper", skew, halfSkew}};
}

class ActiveCompensation : public testing::TestWithParam<Target> {};

TEST_P(ActiveCompensation, IsInTheNewTablesAndStaysWhereNothingWasFound) {
  const Target& t = GetParam();
  const Folder first(folderOf(found(t.first), t.name));
  const LoadedCompensation loaded(t.name, first.path());
  ASSERT_GT(leftOf(t.machine, loaded).x, 4e-7) << "the first round left something to find";
  // What an instrument shows while these are active: exactly what a machine of these sizes has left.
  const double share = (1.0 + t.machine.scale) / (1.0 + t.first.scale);
  const Truth remains{share - 1.0, t.machine.gap - share * t.first.gap,
                      t.machine.slope - share * t.first.slope, t.machine.gapY - t.first.gapY};
  Calibration second = found(remains);
  second.compensation = statedCompensation("--compensation", first.path());
  ASSERT_EQ(second.compensation.target, t.name);
  const Folder next(folderOf(second, t.name));
  const LoadedCompensation now(t.name, next.path());
  const Left left = leftOf(t.machine, now);
  EXPECT_LT(left.x, t.tolerance);
  // Of y nothing was found: its motor stands where it stood.
  double moved = 0.0, before = leftOf(t.machine, loaded).y;
  everywhere([&](double x, double y, double wayX, double wayY) {
    const CommandedState command = commandTo(x, y, wayX, wayY);
    moved = std::max(moved, std::abs(now.adds(command).at("y") - loaded.adds(command).at("y")));
  });
  EXPECT_LT(moved, 1e-9);
  EXPECT_NEAR(left.y, before, 1e-9);
  if (t.leavesY) {
    EXPECT_EQ(next.report().at("touched"), nlohmann::json::array({"x"}));
  }
  EXPECT_THAT(next.text("README.md"), AllOf(HasSubstr("While measuring, tables of " + t.name),
                                            HasSubstr("were active"), Not(HasSubstr("ASSUMED"))));
  // And once more, with the second active: there is nothing left to find.
  Calibration third = found(Truth{1e-5, 0.0, 0.0, 0.0});
  third.compensation = statedCompensation("--compensation", next.path());
  const NeededCorrection needed(third, {});
  State state = needed.states(1, 5)[0];
  state.position = {0.0118, -0.0032, 0.003};
  state.travel = {1.0, 1.0, 1.0};
  EXPECT_NEAR(needed.activeAt(state)[0], now.adds(needed.commandOf(state)).at("x"), 1e-15);
}

INSTANTIATE_TEST_SUITE_P(Targets, ActiveCompensation, testing::ValuesIn(targets()),
                         [](const auto& info) { return info.param.name; });

std::string fileOrNothing(const Exported& exported, const std::string& path) {
  for (const ExportedFile& file : exported.files)
    if (file.path == path) return file.text;
  return {};
}

std::string everyText(const Exported& exported) {
  std::string text;
  for (const ExportedFile& file : exported.files) text += file.path + "\n" + file.text;
  return text;
}

TEST(OnlyAxesThatWereFound, NothingIsWrittenForTheOthers) {
  const Calibration onlyX = found({2e-4, 4e-6, 0.0, 0.0});
  const NeededCorrection needed(onlyX, {});
  for (const ExportTarget& target : exportTargets()) {
    const Exported exported = exportedFor(target, needed, fineUnits());
    if (target.name == "csv" || target.name == "klipper")
      continue;  // csv tells of all; klipper holds neither
    EXPECT_EQ(exported.axes, std::set<std::string>{"x"}) << target.name;
  }
  const auto of = [&](const char* target) { return exportedFor(exportTarget(target), needed, fineUnits()); };
  EXPECT_THAT(fileOrNothing(of("fanuc"), "parameters.txt"),
              AllOf(HasSubstr("N01851 A1 P40\n"), Not(HasSubstr(" A2 "))));
  EXPECT_THAT(fileOrNothing(of("linuxcnc"), "machine.ini"),
              AllOf(HasSubstr("joint0.comp"), Not(HasSubstr("joint1.comp"))));
  EXPECT_THAT(everyText(of("siemens")), AllOf(Not(HasSubstr("$MA_BACKLASH[")), Not(HasSubstr("Y1"))));
  EXPECT_THAT(fileOrNothing(of("marlin"), "compensation.gcode"),
              AllOf(HasSubstr("M425 F1 X0.003999\n"), Not(HasSubstr("\nM852"))));
  EXPECT_EQ(fileOrNothing(of("beckhoff"), "y.lis"), "");
}

TEST(OnlyAxesThatWereFound, APitchAloneSaysNothingOfTheReversal) {
  const Calibration pitch = found({2e-4, 0.0, 0.0, 0.0});
  const Exported exported = exportedFor(exportTarget("fanuc"), NeededCorrection(pitch, {}), fineUnits());
  EXPECT_THAT(fileOrNothing(exported, "parameters.txt"),
              AllOf(HasSubstr("N03620 A1"), Not(HasSubstr("N01851"))));
}

/// A folder that a builder made by hand.
Calibration activeByHand(Calibration c, const std::string& told, const TemporaryFolder& folder) {
  c.compensation = statedCompensation("--compensation", told + folder.path().string());
  return c;
}

TEST(TablesByHand, FanucKeepsItsNumbersAndItsInterval) {
  TemporaryFolder folder;  // 10 mm sections, x rises by 1 um in each; reversals of x and y
  folder.write(
      "parameters.txt",
      "%\nN01851 A1 P3 A2 P5\nN03620 A1 P2 A2 P102\nN03621 A1 P1 A2 P101\nN03622 A1 P4 A2 P104\nN03623 A1 "
      "P1 A2 P1\nN03624 A1 P10.0 A2 P10.0\nN10001 P1\nN10002 P1\nN10003 P1\nN10004 P1\nN10101 "
      "P2\nN10102 P2\nN10103 P2\nN10104 P2\n%\n");
  folder.write("compare.txt", "%\nN01020 A1 P88 A2 P89\n%\n");
  ExportOptions options;  // units of 1 um
  const Calibration c = activeByHand(found({0.0, 2e-6, 0.0, 0.0}), "fanuc:", folder);
  const Exported exported = exportedFor(exportTarget("fanuc"), NeededCorrection(c, {}), options);
  const std::string text = fileOrNothing(exported, "parameters.txt");
  EXPECT_THAT(text,
              AllOf(HasSubstr("N01851 A1 P5\n"), HasSubstr("N03624 A1 P10.0000\n"), Not(HasSubstr("A2"))));
  const auto tried = triedExport("fanuc", exported);
  for (const double x : {-0.018, -0.012, -0.004, 0.004, 0.012, 0.018}) {
    const auto before = NeededCorrection(c, {}).active()->adds(commandTo(x, 0.01, 1, 1));
    const auto after = tried->adds(commandTo(x, 0.01, 1, 1));
    EXPECT_NEAR(after.at("x"), before.at("x"), 1e-12) << x;
    EXPECT_NEAR(after.at("y"), before.at("y"), 1e-15) << x;
    EXPECT_NEAR(tried->adds(commandTo(x, 0.01, -1, 1)).at("x"), before.at("x") - 5e-6, 1e-12) << x;
  }
}

TEST(TablesByHand, SiemensKeepsTheNumbersOfOtherAxesAndStopsWhatItReplaces) {
  const auto table = [](int n, const std::string& axis, double perPoint) {
    const std::string i = std::to_string(n);
    std::string text;
    for (int k = 0; k < 5; ++k)
      text += "$AN_CEC[" + i + "," + std::to_string(k) + "]=" + fixed(perPoint * (k - 2), 6) + "\n";
    return text + "$AN_CEC_INPUT_AXIS[" + i + "]=(" + axis + ")\n$AN_CEC_OUTPUT_AXIS[" + i + "]=(" + axis +
           ")\n$AN_CEC_STEP[" + i + "]=10.0\n$AN_CEC_MIN[" + i + "]=-20.0\n$AN_CEC_MAX[" + i +
           "]=20.0\n$AN_CEC_DIRECTION[" + i + "]=0\n$SN_CEC_TABLE_ENABLE[" + i + "]=1\n";
  };
  TemporaryFolder folder;
  folder.write("cec.mpf", table(0, "Y1", 0.002) + table(3, "X1", 0.001) +
                              "$MA_BACKLASH[0,X1]=0.003\n$MA_BACKLASH[0,Y1]=0.005\nM17\n");
  const Calibration c = activeByHand(found({1e-4, 0.0, 0.0, 0.0}), "siemens:", folder);
  const NeededCorrection needed(c, {});
  const Exported exported = exportedFor(exportTarget("siemens"), needed, {});
  const std::string text = everyText(exported);
  EXPECT_THAT(fileOrNothing(exported, "cec_2_tables.mpf"), Not(HasSubstr("$AN_CEC[0,")));
  EXPECT_THAT(fileOrNothing(exported, "cec_3_enable.mpf"), HasSubstr("$SN_CEC_TABLE_ENABLE[3]=0"));
  const auto tried = triedExport("siemens", exported);
  const auto at = [&](double x, double way) { return tried->adds(commandTo(x, 0.007, way, 1)); };
  const auto was = [&](double x, double way) { return needed.active()->adds(commandTo(x, 0.007, way, 1)); };
  for (const double way : {-1.0, 1.0}) {
    EXPECT_NEAR(at(0.013, way).at("x") - at(-0.015, way).at("x"),
                was(0.013, way).at("x") - was(-0.015, way).at("x") - 1e-4 * 0.028, 2e-9);
    EXPECT_NEAR(at(0.013, way).at("y"), was(0.013, way).at("y"), 1e-15);
  }
  EXPECT_NEAR(at(0.013, 1).at("x") - at(0.013, -1).at("x"), 3e-6, 1e-9);
}

TEST(TablesByHand, LinuxcncKeepsATableThatReachesFartherThanTheSession) {
  TemporaryFolder folder;
  folder.write(
      "machine.ini",
      "[TRAJ]\nCOORDINATES = XYZ\nLINEAR_UNITS = mm\n[JOINT_0]\nTYPE = LINEAR\nCOMP_FILE = "
      "x.comp\nCOMP_FILE_TYPE = 1\n[JOINT_1]\nTYPE = LINEAR\nBACKLASH = 0.006\n[JOINT_2]\nTYPE = LINEAR\n");
  folder.write("x.comp", "-50 0.010 0.006\n-25 0.004 0\n0 0.002 -0.002\n25 0.003 -0.001\n50 -0.001 -0.005\n");
  const Calibration c = activeByHand(found({1e-4, 2e-6, 0.0, 0.0}), "linuxcnc:", folder);
  const NeededCorrection needed(c, {});
  const auto tried = triedExport("linuxcnc", exportedFor(exportTarget("linuxcnc"), needed, {}));
  const auto at = [&](double x, double way) { return tried->adds(commandTo(x, 0.0, way, 1)).at("x"); };
  const auto was = [&](double x, double way) {
    return needed.active()->adds(commandTo(x, 0.0, way, 1)).at("x");
  };
  for (const double x : {-0.050, -0.033, -0.012, 0.009, 0.025, 0.041})
    for (const double way : {-1.0, 1.0}) {
      const double scale = -1e-4 * std::clamp(x, -0.020, 0.020);  // the session knew no more
      EXPECT_NEAR(at(x, way), was(x, way) + scale + 1e-6 * way, 5e-8) << x << " " << way;
    }
  EXPECT_NEAR(tried->adds(commandTo(0.0, 0.0, 1, 1)).at("y"), 3e-6, 1e-12);
}

std::string refused(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

TEST(StatedCompensation, BadOnesAreOneClearLine) {
  const auto told = [](const std::string& value) {
    return refused([&] { statedCompensation("--compensation", value); });
  };
  EXPECT_EQ(statedCompensation("--compensation", "").stated, ControllerCompensation::Stated::kNot);
  EXPECT_EQ(statedCompensation("--compensation", "none").stated, ControllerCompensation::Stated::kNone);
  EXPECT_THAT(told("nowhere"), HasSubstr("--compensation nowhere: is neither 'none' nor a folder"));
  TemporaryFolder empty, broken;
  EXPECT_THAT(told(empty.path().string()), HasSubstr("no controller's interpreter reads what is there"));
  broken.write("settings.txt", "$160=many\n");
  EXPECT_THAT(told("grblhal:" + broken.path().string()),
              AllOf(HasSubstr("settings.txt:1"), HasSubstr("many")));
  TemporaryFolder ini;  // which Siemens' rules read, too, and find nothing in
  ini.write("machine.ini", "[TRAJ]\nCOORDINATES = XYZ\n[JOINT_0]\nTYPE = LINEAR\nBACKLASH = 0.006\n");
  EXPECT_EQ(statedCompensation("--compensation", ini.path().string()).target, "linuxcnc");
  const Folder linuxcnc(folderOf(found({2e-4, 0, 0, 0}), "linuxcnc"));
  EXPECT_THAT(told("siemens:" + linuxcnc.path()), HasSubstr("is for linuxcnc, not for siemens"));
  Calibration c = found({2e-4, 0, 0, 0});
  c.compensation = statedCompensation("--compensation", linuxcnc.path());
  EXPECT_THAT(refused([&] { exportedFor(exportTarget("fanuc"), NeededCorrection(c, {}), {}); }),
              AllOf(HasSubstr("--to fanuc: tables of linuxcnc"), HasSubstr("were active while measuring")));
  TemporaryFolder other;
  other.write("settings.txt", "$163=0.01\n");
  EXPECT_THAT(
      refused([&] { NeededCorrection(activeByHand(found({}), "grblhal:", other), {}); }),
      AllOf(HasSubstr("is for axis a, and the machine's axes are x, y, z"), HasSubstr("--axis JOINT=a")));
}

TEST(StatedCompensation, IsTheSameOnceReadBack) {
  const Folder folder(folderOf(found({2e-4, 4e-6, 0, 0}), "linuxcnc"));
  const ControllerCompensation stated = statedCompensation("--compensation", folder.path());
  EXPECT_EQ(parseCompensation(compensationJson(stated), "topic"), stated);
  std::string changed = compensationJson(stated);
  changed.replace(changed.find("COMP_FILE_TYPE = 1"), 18, "COMP_FILE_TYPE = 0");
  EXPECT_THAT(refused([&] { parseCompensation(changed, "topic"); }), HasSubstr("they were changed"));
  EXPECT_THAT(refused([&] { parseCompensation("{\"stated\": \"some\"}", "topic"); }), HasSubstr("'some'"));
  ControllerCompensation outside = stated;
  outside.files[0].path = "../outside";
  EXPECT_THAT(refused([&] { loadedCompensation(outside); }), HasSubstr("'../outside' is not a file name"));
}

TEST(StatedCompensation, IsSaidInTheFilesAndOnThePage) {
  Calibration c = found({2e-4, 4e-6, 0, 0});
  const auto ini = [&] {
    return fileOrNothing(exportedFor(exportTarget("linuxcnc"), NeededCorrection(c, {}), {}), "machine.ini");
  };
  EXPECT_THAT(ini(), HasSubstr("# ASSUMED, because it was not stated: no compensation was active"));
  c.compensation.stated = ControllerCompensation::Stated::kNone;
  EXPECT_THAT(ini(), AllOf(HasSubstr("# As stated, no compensation was active while measuring"),
                           Not(HasSubstr("ASSUMED"))));
}

}  // namespace
}  // namespace mm
