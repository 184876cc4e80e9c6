// Nothing of value is overwritten: what every command does with an output that is there already.
#include <filesystem>

#include "long_tests.h"
#include "session_folder.h"

namespace mm {
namespace {

using Outputs = SessionFolder;

/// Each command that writes, with the place of its output left open.
const std::vector<std::string>& writers() {
  static const std::vector<std::string> commands{
      "import s.csv --machine three_axis --artifact artifact.yaml -o ",
      "simulate --machine three_axis --plan plan.yaml -o ",
      "simulate --machine three_axis --plan plan.yaml -o new.bag --csv ",
      "simulate --machine three_axis --plan plan.yaml -o new.bag --truth ",
      "calibrate s.bag --model m.yaml --method least_squares -o ",
      "calibrate s.bag --model m.yaml --method least_squares -o new.yaml --curve ",
      "diagnose s.bag --calibration c.yaml --moves ",
      "add s.bag --calibration c.yaml '{type: backlash, axis: x}' -o ",
      "remove s.bag --calibration c.yaml '{type: scale, axis: x}' -o ",
      "update s.bag --calibration c.yaml -o ",
      "report s.bag --calibration c.yaml --plotly plan.yaml -o ",
      "apply states.csv --calibration c.yaml -o ",
      "sensors series.csv --target nose_um --picture "};
  return commands;
}

/// The first word of a command line that names a file which the command reads.
std::string inputOf(const std::string& command) {
  for (const char* input : {"s.csv", "plan.yaml", "s.bag", "states.csv", "series.csv"})
    if (command.find(std::string(" ") + input) != std::string::npos) return input;
  return {};
}

TEST_F(Outputs, NoOutputReplacesAnInputHoweverItIsNamed) {
  namespace fs = std::filesystem;
  fs::create_directory(*folder_ / "sub");
  for (const std::string& command : writers()) {
    const std::string input = inputOf(command);
    ASSERT_FALSE(input.empty()) << command;
    const std::string soft = "soft-" + input, hard = "hard-" + input;
    fs::remove(*folder_ / soft);
    fs::remove(*folder_ / hard);
    fs::create_symlink(input, *folder_ / soft);
    fs::create_hard_link(*folder_ / input, *folder_ / hard);
    std::vector<std::string> names = {input, "sub/../" + input, hard};
    if (mm_test::thoroughTests()) names.insert(names.end(), {"./" + input, *folder_ / input, soft});
    for (const std::string& name : names) {
      expectRefused(command + name + " --force", {name, "another file"});
      if (name == input || mm_test::thoroughTests()) expectRefused(command + name, {name, "another file"});
    }
    fs::remove(*folder_ / soft);
    fs::remove(*folder_ / hard);
  }
}

TEST_F(Outputs, ModelsArtifactsAndMachinesAreInputsToo) {
  const std::string import = "import s.csv --machine three_axis --artifact artifact.yaml --force -o ";
  expectRefused(import + "artifact.yaml", {"artifact.yaml", "inputs are never overwritten"});
  expectRefused("calibrate s.bag --model m.yaml --force -o m.yaml", {"m.yaml"});
  expectRefused("calibrate s.bag --model m.yaml --force -o new.yaml --curve m.yaml", {"--curve m.yaml"});
  std::filesystem::copy_file("urdf/three_axis.urdf", *folder_ / "own.urdf",
                             std::filesystem::copy_options::overwrite_existing);
  expectRefused("simulate --machine own.urdf --plan plan.yaml --force -o new.bag --truth own.urdf",
                {"own.urdf"});
}

TEST_F(Outputs, AFileOfAnotherKindIsNotReplaced) {
  folder_->write("notes.txt", "what nobody can write again\n");
  for (const std::string& command : writers()) {
    expectRefused(command + "notes.txt", {"notes.txt", "another kind", "--force"});
    if (command.find("import") != 0 &&
        command.find("simulate --machine three_axis --plan plan.yaml -o t") != 0)
      expectRefused(command + "t.bag", {"t.bag"});
    if (inputOf(command) != "s.csv") expectRefused(command + "t.csv", {"t.csv"});
  }
}

TEST_F(Outputs, AnotherSessionsCalibrationIsNotReplaced) {
  const std::string why = "another session";
  expectRefused("calibrate s.bag --model m.yaml --method least_squares -o t.yaml", {why, "t.bag", "--force"});
  expectRefused("add s.bag --calibration c.yaml '{type: backlash, axis: x}' -o t.yaml", {why, "t.bag"});
  expectRefused("remove s.bag --calibration c.yaml '{type: scale, axis: x}' -o t.yaml", {why, "t.bag"});
  expectRefused("update s.bag --calibration c.yaml -o t.yaml", {why, "t.bag"});
  std::string damaged = textOf(*folder_ / "t.yaml");
  damaged[damaged.find("value_si: ") + 10] ^= 1;
  folder_->write("damaged.yaml", damaged);
  expectRefused("calibrate s.bag --model m.yaml --method least_squares -o damaged.yaml", {"damaged"});
}

TEST_F(Outputs, AFinishedCalibrationKeepsItsLedger) {
  run("add s.bag --calibration c.yaml '{type: backlash, axis: x}' -o finished.yaml");
  run("add s.bag --calibration c.yaml '{type: backlash, axis: x}' -o finished.yaml");  // as many steps
  expectRefused("calibrate s.bag --model m.yaml --method least_squares -o finished.yaml",
                {"finished.yaml", "2 steps in its ledger", "1 would be left", "--force"});
  run("calibrate s.bag --model m.yaml --method least_squares --force -o finished.yaml");
  EXPECT_EQ(textOf(*folder_ / "finished.yaml").find("backlash"), std::string::npos);
}

TEST_F(Outputs, ABagOfAnotherOriginIsNotReplaced) {
  expectRefused("simulate --machine three_axis --plan plan.yaml -o s.bag",
                {"imported from s.csv", "simulated"});
  expectRefused("import s.csv --machine three_axis -o five.bag", {"simulated", "imported from s.csv"});
  expectRefused("import s.csv --machine three_axis -o t.bag", {"imported from t.csv"});
}

TEST_F(Outputs, TwoOutputsAreNotOneFile) {
  expectRefused("simulate --machine three_axis --plan plan.yaml -o new.bag --truth ./new.bag",
                {"-o", "--truth", "same file"});
  expectRefused("calibrate s.bag --model m.yaml -o new.yaml --curve new.yaml",
                {"-o", "--curve", "same file"});
}

TEST_F(Outputs, WhatAFolderOfCalibrationsKeepsIsNotReplaced) {
  run("promote c.yaml --store kept");
  for (const char* name : {"kept/active", "kept/new.yaml"})
    expectRefused(std::string("calibrate s.bag --model m.yaml --method least_squares --force -o ") + name,
                  {"folder of calibrations"});
  std::filesystem::remove_all(*folder_ / "kept");
}

TEST_F(Outputs, PlacesWhereNothingCanBeWritten) {
  for (const std::string& command : writers()) {
    expectRefused(command + "nowhere/new", {"nowhere", "does not exist"});
    expectRefused(command + ".", {"is a folder"});
  }
  for (const char* command :
       {"import s.csv --machine three_axis -o ", "simulate --machine three_axis --plan plan.yaml -o "})
    expectRefused(std::string(command) + "/dev/null", {"/dev/null", "regular file"});
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST_F(Outputs, ARepeatedCommandMayReplaceWhatItWrote) {
  for (const char* command :
       {"import s.csv --machine three_axis -o s.bag",
        "calibrate s.bag --model m.yaml --method least_squares -o c.yaml",
        "simulate --machine three_axis --plan plan.yaml --seed 2 --truth truth.yaml -o again.bag",
        "simulate --machine three_axis --plan plan.yaml --seed 3 --truth truth.yaml -o again.bag",
        "apply states.csv --calibration c.yaml -o corrected.csv",
        "apply states.csv --calibration c.yaml -o corrected.csv",
        "calibrate s.bag --model m.yaml --generations 3 --population 20 --curve curve.csv",
        "calibrate s.bag --model m.yaml --generations 3 --population 20 --curve curve.csv",
        "sensors series.csv --target nose_um --picture picture.svg",
        "sensors series.csv --target nose_um --picture picture.svg"})
    run(command);
}

TEST_F(Outputs, ForceReplacesWhatWasRefused) {
  std::filesystem::copy_file(*folder_ / "t.yaml", *folder_ / "other.yaml");
  run("calibrate s.bag --model m.yaml --method least_squares --force -o other.yaml");
  EXPECT_NE(textOf(*folder_ / "other.yaml"), textOf(*folder_ / "t.yaml"));
  expectRefused("add s.bag --calibration other.yaml '{type: backlash, axis: x}' -o other.yaml", {"--force"});
  run("add s.bag --calibration other.yaml '{type: backlash, axis: x}' --force -o other.yaml");
  EXPECT_NE(textOf(*folder_ / "other.yaml").find("backlash"), std::string::npos);
}

TEST_F(Outputs, ALinkKeepsItsPlace) {
  namespace fs = std::filesystem;
  run("simulate --machine three_axis --plan plan.yaml -o real.bag");
  fs::create_symlink("real.bag", *folder_ / "link.bag");
  const std::string before = textOf(*folder_ / "real.bag");
  run("simulate --machine three_axis --plan plan.yaml --seed 9 -o link.bag");
  EXPECT_TRUE(fs::is_symlink(*folder_ / "link.bag"));
  EXPECT_NE(textOf(*folder_ / "real.bag"), before);
}

/// One place opens outputs: no command writes past it.
TEST(OutputFilesRule, NoCommandWritesByItself) {
  for (const auto& entry : std::filesystem::directory_iterator("src/tools")) {
    const std::string name = entry.path().filename().string(), text = textOf(entry.path().string());
    if (name == "output_files.cpp") continue;
    if (name == "batch_result.cpp")
      continue;  // a job's own files, in a folder that gets its name when it is whole
    for (const char* writer :
         {"ofstream", "writeFileAtomically", "saveCalibration", "writeSessionBag", "fopen"})
      EXPECT_EQ(text.find(writer), std::string::npos)
          << name << " uses " << writer << "; write through OutputFiles";
  }
}

}  // namespace
}  // namespace mm
