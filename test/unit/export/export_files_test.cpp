// Folders that are complete or absent; axes and their letters; the pages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/temporary_folder.h"
#include "compensation_support.h"
#include "export/export_folder.h"
#include "export/export_page.h"
#include "export/export_target.h"
#include "export/fitted_tables.h"

namespace mm {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ExportFolder : public testing::Test {
 protected:
  void put(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }
  std::string said(const fs::path& folder, const std::string& target, bool force = false) {
    try {
      checkExportFolder(folder, target, force);
    } catch (const InputError& e) {
      return e.what();
    }
    return {};
  }
  std::vector<ExportedFile> files(const std::string& target, const std::string& table) {
    return {{"a.txt", "a table", table},
            {"representability.json", "report",
             R"({"target": ")" + target +
                 R"(", "files": [{"path": "a.txt"}, {"path": "representability.json"}]})"}};
  }
  const TemporaryFolder own_;
  const fs::path folder_ = own_.path() / "out";
};

TEST_F(ExportFolder, IsWrittenWholeAndReplacedBySamePlace) {
  EXPECT_EQ(said(folder_, "csv"), "");
  writeExportFolder(folder_, files("csv", "one"));
  EXPECT_TRUE(fs::exists(folder_ / "a.txt"));
  EXPECT_EQ(said(folder_, "csv"), "");
  EXPECT_THAT(said(folder_, "marlin"), HasSubstr("--force"));
  EXPECT_EQ(said(folder_, "marlin", true), "");
  writeExportFolder(folder_ / "", files("marlin", "two"));
  std::ifstream in(folder_ / "a.txt");
  std::string text;
  in >> text;
  EXPECT_EQ(text, "two");
  EXPECT_EQ(std::distance(fs::directory_iterator(own_.path()), {}), 1) << "something is left beside it";
}

TEST_F(ExportFolder, NeverReplacesWhatItDidNotWrite) {
  writeExportFolder(folder_, files("csv", "one"));
  put(folder_ / "notes.md", "mine");
  EXPECT_THAT(said(folder_, "csv", true), HasSubstr("'notes.md'"));
  fs::create_directory(own_.path() / "photos");
  EXPECT_EQ(said(own_.path() / "photos", "csv"), "");
  put(own_.path() / "photos" / "1.png", "x");
  EXPECT_THAT(said(own_.path() / "photos", "csv", true), HasSubstr("'1.png'"));
  put(own_.path() / "file", "x");
  EXPECT_THAT(said(own_.path() / "file", "csv", true), HasSubstr("not a folder"));
  EXPECT_THAT(said(own_.path() / "none" / "out", "csv"), HasSubstr("does not exist"));
}

TEST_F(ExportFolder, IsAbsentWhereAFileCannotBeWritten) {
  std::vector<ExportedFile> bad = files("csv", "one");
  bad.push_back({"no/such/folder/b.txt", "", "x"});
  EXPECT_THROW(writeExportFolder(folder_, bad), InputError);
  EXPECT_FALSE(fs::exists(folder_));
  EXPECT_TRUE(fs::is_empty(own_.path()));
  writeExportFolder(folder_, files("csv", "one"));
  EXPECT_THROW(writeExportFolder(folder_, bad), InputError);
  EXPECT_TRUE(fs::exists(folder_ / "a.txt"));
  EXPECT_EQ(std::distance(fs::directory_iterator(own_.path()), {}), 1);
}

TEST(ExportTargets, AnUnknownOneIsRefusedWithTheList) {
  try {
    exportTarget("linuxcnd");
    FAIL();
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("did you mean 'linuxcnc'"));
    for (const std::string& name : exportTargetNames()) EXPECT_THAT(e.what(), HasSubstr(name));
  }
}

TEST(ExportAxes, GoByNameThenByDirection) {
  const Machine five = Machine::load("five_axis");
  const std::vector<double> lower(5, -0.1), upper(5, 0.1);
  std::string letters;
  for (const ExportAxis& axis : exportAxes(five, {}, lower, upper)) letters += axis.letter;
  EXPECT_EQ(letters, "yxzba");  // the order of the chain
  EXPECT_EQ(exportAxes(five, {{"x", "y"}, {"y", "x"}}, lower, upper)[0].letter, "x");
  EXPECT_THROW(exportAxes(five, {{"x", "y"}}, lower, upper), InputError);
  EXPECT_THROW(exportAxes(five, {{"q", "y"}}, lower, upper), InputError);
  EXPECT_THROW(exportAxes(five, {{"x", "spindle"}}, lower, upper), InputError);
}

TEST(ExportAxes, AMachineWithoutLinearAxesIsRefused) {
  const Machine mount(R"(<robot name="mount"><link name="workpiece"/><link name="f"/><link name="probe_tip"/>
    <joint name="b" type="revolute"><parent link="workpiece"/><child link="f"/><axis xyz="0 0 1"/>
      <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
    <joint name="m" type="fixed"><parent link="f"/><child link="probe_tip"/></joint></robot>)",
                      "mount");
  try {
    exportAxes(mount, {}, {-1}, {1});
    FAIL();
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("no linear axis"));
  }
}

TEST(LineTables, AreZeroAtTheReferenceAndCoverTheRange) {
  Calibration c = test::calibrationOf(Machine::load("three_axis"), {EffectSpec("scale").set("axis", "x"),
                                                                    EffectSpec("backlash").set("axis", "x")});
  test::value(c, "scale") = 1e-4;
  test::value(c, "gap") = 4e-6;
  const NeededCorrection needed(c, {});
  const LineTable table = lineTable(needed, 0, 256);
  EXPECT_LE(table.at.front(), -0.020);
  EXPECT_GE(table.at.back(), 0.020);
  // Corrected = nominal + scale * x - gap / 2 * travel: the motors go the other way.
  EXPECT_NEAR(table.value(0, 0.010, 1.0), -1e-6 + 2e-6, 1e-9);
  EXPECT_NEAR(table.value(0, 0.010, -1.0), -1e-6 - 2e-6, 1e-9);
  EXPECT_NEAR(table.value(0, 0.0, 0.0), 0.0, 1e-12);
  EXPECT_NEAR(table.value(1, 0.010, 1.0), 0.0, 1e-12);
}

TEST(ExportPages, SayWhatToLoadAndHowToCheckTheSign) {
  Calibration c = test::calibrationOf(Machine::load("three_axis"), {EffectSpec("scale").set("axis", "x")});
  test::value(c, "scale") = 1e-4;
  const NeededCorrection needed(c, {});
  for (const ExportTarget& target : exportTargets()) {
    const Exported exported = exportedFor(target, needed, {});
    Representability judged = representability(c, target, {}, needed, exported);
    const std::vector<ExportedFile> files = exportFolderOf(c, target, needed, exported, judged);
    std::string page, json;
    for (const ExportedFile& file : files) {
      EXPECT_FALSE(file.text.empty()) << target.name << " " << file.path;
      EXPECT_FALSE(file.what.empty()) << target.name << " " << file.path;
      if (file.path == "README.md") page = file.text;
      if (file.path == "representability.json") json = file.text;
    }
    for (const char* part :
         {"## Install", "ASSUMED, because it was not stated", "## Reference point", "## Check the sign",
          "## What is carried", "## Numerical compensation, by ISO/TR 16907", "Kinematic chain: w-b-X-Y-Z-t",
          "Before and after: RMS", "## What was checked", "Not on this machine", "1. "})
      EXPECT_THAT(page, HasSubstr(part)) << target.name;
    EXPECT_EQ(page.find("By calculation: the files were read back") == std::string::npos,
              judged.carriesNothing())
        << target.name;
    const auto read = nlohmann::json::parse(json);
    EXPECT_EQ(read.at("target"), target.name);
    EXPECT_EQ(read.at("files").size(), files.size());
    EXPECT_EQ(read.at("effects").at(0).at("effect").at("type"), "scale");
    EXPECT_EQ(read.at("effects").at(0).at("iso230"), "EXX");
    EXPECT_TRUE(read.at("rms_um").contains("uncorrected"));
  }
}

}  // namespace
}  // namespace mm
