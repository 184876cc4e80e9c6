#include "calibration_file/calibration_fit.h"

#include <gtest/gtest.h>

#include "calibration_file/calibration_yaml.h"
#include "example_calibration.h"

namespace mm {
namespace {

std::string urdf(const std::string& serial) {
  std::string text = Machine::load("three_axis").urdf();
  if (!serial.empty()) text.insert(text.find("</robot>"), "<serial>" + serial + "</serial>");
  return text;
}

Machine machineOf(const std::string& serial) { return Machine(urdf(serial), "robot_description"); }

Calibration calibrationOf(const std::string& serial, const std::string& space) {
  Calibration c = test::exampleCalibration();
  c.id = "c";
  c.urdf = urdf(serial);
  c.sessionSpace = space;
  return c;
}

TEST(CalibrationFit, theMachineOfOneUrdfAndNamespaceFits) {
  EXPECT_EQ(misfitOf(calibrationOf("", "/m1"), machineOf(""), "/m1"), "");
  EXPECT_EQ(misfitOf(calibrationOf("", ""), machineOf(""), "/m1"), "") << "imported: nobody knows";
  EXPECT_EQ(misfitOf(calibrationOf("", "/m1"), machineOf(""), ""), "") << "not asked by a node";
}

TEST(CalibrationFit, anotherUrdfSerialOrNamespaceIsRefusedWithTheReason) {
  Calibration shifted = calibrationOf("", "/");
  const std::string mount = "<child link=\"probe_tip\"/>";
  shifted.urdf.insert(shifted.urdf.find(mount) + mount.size(), "<origin xyz=\"0 0 0.01044\"/>");
  EXPECT_NE(misfitOf(shifted, machineOf(""), "/")
                .find("its probe's tip stands at (0, 0, 10.44) mm, here at (0, 0, 0)"),
            std::string::npos);
  EXPECT_NE(misfitOf(calibrationOf("A", "/"), machineOf("B"), "/").find("its serial is 'A', here 'B'"),
            std::string::npos);
  EXPECT_NE(misfitOf(calibrationOf("A", "/"), machineOf(""), "/").find("this machine states none"),
            std::string::npos);
  EXPECT_NE(misfitOf(calibrationOf("", "/m1"), machineOf(""), "/m2")
                .find("measured in the namespace /m1, this machine is in /m2"),
            std::string::npos);
}

TEST(CalibrationFit, ofASessionOrAnotherCalibrationTheSameCounts) {
  EXPECT_EQ(differenceOf(calibrationOf("", "/m1"), machineOf(""), "/m2", "in the session"),
            "it was measured in the namespace /m1, in the session that is /m2");
  EXPECT_EQ(differenceOf(calibrationOf("", "/m1"), machineOf(""), "", "in the session"), "") << "imported";
  EXPECT_EQ(differenceOf(calibrationOf("A", "/m1"), machineOf("A"), "/m2", "in the session"), "");
  EXPECT_NE(differenceOf(calibrationOf("A", ""), machineOf("B"), "", "in the session"), "");
}

TEST(CalibrationFit, oneSerialIsOneMachineWhateverItsNamespace) {
  EXPECT_EQ(misfitOf(calibrationOf("A", "/m1"), machineOf("A"), "/shop/m7"), "");
}

TEST(CalibrationFit, anOldFileIsReadAndSaysWhatCouldNotBeCompared) {
  Calibration old = calibrationOf("", "");
  old.toldSpace = false;
  completeCalibration(old);
  const Calibration read = parseCalibration(calibrationYaml(old), "old.yaml");
  EXPECT_FALSE(read.toldSpace);
  EXPECT_EQ(misfitOf(read, machineOf(""), "/m1"), "");
  EXPECT_NE(uncheckedFit(read, machineOf("")).find("does not name its machine"), std::string::npos);
  Calibration told = calibrationOf("", "/m1");
  completeCalibration(told);
  const Calibration again = parseCalibration(calibrationYaml(told), "new.yaml");
  EXPECT_TRUE(again.toldSpace);
  EXPECT_EQ(again.sessionSpace, "/m1");
  EXPECT_EQ(uncheckedFit(again, machineOf("")), "");
  EXPECT_NE(uncheckedFit(again, machineOf("A")).find("states no serial, this machine is 'A'"),
            std::string::npos);
}

TEST(CalibrationFit, everyMachineHasAFolderOfItsOwn) {
  EXPECT_EQ(folderOf(machineOf(""), "/"), "");
  EXPECT_EQ(folderOf(machineOf(""), ""), "");
  EXPECT_EQ(folderOf(machineOf(""), "/m1"), "m1");
  EXPECT_EQ(folderOf(machineOf(""), "/shop/m1"), "shop_m1");
  EXPECT_EQ(folderOf(machineOf("MM 7/2"), "/m1"), "MM_7_2");
  EXPECT_EQ(folderOf(machineOf(".."), "/m1"), "_.");
}

}  // namespace
}  // namespace mm
