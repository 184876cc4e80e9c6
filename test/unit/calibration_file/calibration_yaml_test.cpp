#include "calibration_file/calibration_yaml.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <fstream>

#include "base/checksum.h"
#include "base/error.h"
#include "base/number_text.h"
#include "calibration_file/atomic_file.h"
#include "example_calibration.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

bool sameBits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

template <typename Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}

/// The text with one thing changed and a checksum that fits it again.
std::string changed(std::string text, const std::string& from, const std::string& to) {
  text = text.substr(text.find('\n') + 1);
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("test: nothing to change: " + from);
  text.replace(at, from.size(), to);
  return "checksum: crc64-" + checksumOf(text) + "\n" + text;
}

fs::path freshFolder(const std::string& name) {
  const fs::path folder = fs::temp_directory_path() / ("mm_" + name + "_" + std::to_string(::getpid()));
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

TEST(Checksum, isCrc64Xz) {
  EXPECT_EQ(checksumOf("123456789"), "995dc9bbdf1939fa");  // check value of the CRC catalogue
  EXPECT_EQ(checksumOf(""), "0000000000000000");
}

TEST(NumberText, readsBackToTheBit) {
  for (const double v : {0.1, -0.0, 1.0 / 3.0, 5e-324, 1.7976931348623157e308, 123456789.0}) {
    double read = 7;
    ASSERT_TRUE(parseNumber(numberText(v), read));
    EXPECT_TRUE(sameBits(read, v)) << numberText(v);
  }
  double read = 0;
  EXPECT_TRUE(parseNumber(".nan", read) && read != read);
  for (const char* bad : {"", "1.0x", "nan", "inf", "1 2", "1e999", "0x10"})
    EXPECT_FALSE(parseNumber(bad, read)) << bad;
}

TEST(CalibrationYaml, roundTripsEveryFieldToTheBit) {
  Calibration c = test::exampleCalibration();
  completeCalibration(c);
  const std::string text = calibrationYaml(c);
  const Calibration r = parseCalibration(text, "c.yaml");
  EXPECT_EQ(calibrationYaml(r), text);
  EXPECT_EQ(r.id, c.id);
  EXPECT_EQ(r.urdf, c.urdf);
  EXPECT_EQ(r.effects, c.effects);
  EXPECT_EQ(r.domain.features, c.domain.features);
  EXPECT_EQ(r.domain.sensors, c.domain.sensors);
  ASSERT_EQ(r.networks.size(), 1u);
  EXPECT_EQ(r.networks[0].effect, c.networks[0].effect);
  EXPECT_EQ(r.networks[0].active, true);
  EXPECT_EQ(r.networks[0].sensors, c.networks[0].sensors);
  EXPECT_EQ(r.networks[0].positions, c.networks[0].positions);
  EXPECT_EQ(r.networks[0].numbers, c.networks[0].numbers);
  EXPECT_EQ(r.networks[0].summary, c.networks[0].summary);
  EXPECT_EQ(r.networks[0].heldOut, c.networks[0].heldOut);
  EXPECT_EQ(r.domain.positions, c.domain.positions);
  EXPECT_EQ(r.domain.featureRadius, c.domain.featureRadius);
  ASSERT_EQ(r.domain.velocityLower.size(), 3u);
  EXPECT_TRUE(std::isnan(r.domain.velocityLower[1]));
  EXPECT_EQ(r.domain.velocityLower[2], c.domain.velocityLower[2]);
  EXPECT_EQ(r.domain.velocityUpper[2], c.domain.velocityUpper[2]);
  EXPECT_EQ(r.domain.readingLower, c.domain.readingLower);
  EXPECT_EQ(r.domain.readingUpper, c.domain.readingUpper);
  EXPECT_EQ(r.domain.joints[1].upper, 0.035);
  EXPECT_EQ(r.domain.lower, c.domain.lower);
  EXPECT_EQ(r.domain.tipUpper, c.domain.tipUpper);
  EXPECT_TRUE(std::isnan(r.domain.sensorLower[1]));
  EXPECT_EQ(r.covariance, c.covariance);
  EXPECT_EQ(r.seed, c.seed);
  EXPECT_EQ(r.sessionEpoch, c.sessionEpoch);
  EXPECT_EQ(r.sessionOrigin, "simulated");
  ASSERT_EQ(r.values.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(sameBits(r.values[i].value, c.values[i].value));
    EXPECT_TRUE(sameBits(r.values[i].std, c.values[i].std));
    EXPECT_EQ(r.values[i].name, c.values[i].name);
    EXPECT_EQ(r.values[i].fixed, c.values[i].fixed);
  }
  EXPECT_TRUE(std::isnan(r.rmsAngular));
  EXPECT_EQ(r.degreesOfFreedom, c.degreesOfFreedom);
  ASSERT_TRUE(r.artifact.has_value());
  EXPECT_EQ(r.artifact->name, c.artifact->name);
  EXPECT_EQ(r.artifact->features, 9);
  EXPECT_FALSE(r.artifact->poseKnown);
  EXPECT_TRUE(sameBits(r.artifact->span, c.artifact->span));
  EXPECT_EQ(r.artifact->centreStd, c.artifact->centreStd);
  EXPECT_EQ(r.artifact->radiusStd, c.artifact->radiusStd);
  ASSERT_EQ(r.ledger.size(), 2u);
  EXPECT_EQ(r.ledger[1].effect, c.effects[1]);
  EXPECT_TRUE(r.ledger[0].effect.type.empty());
  EXPECT_EQ(r.ledger[1].calibration, c.ledger[1].calibration);
}

TEST(CalibrationYaml, keepsTheDriftsAndTheirKernel) {
  Calibration c = test::exampleCalibration();
  c.drift = {{"x", 0.4e-6, 1200.0, true}, {"z", 0.1e-6, 60.0}};
  completeCalibration(c);
  const Calibration r = parseCalibration(calibrationYaml(c), "c.yaml");
  ASSERT_EQ(r.drift.size(), 2u);
  EXPECT_EQ(r.drift[0].direction, "x");
  EXPECT_EQ(r.drift[0].std, 0.4e-6);
  EXPECT_EQ(r.drift[0].timeConstant, 1200.0);
  EXPECT_TRUE(r.drift[0].smooth);
  EXPECT_FALSE(r.drift[1].smooth);
}

TEST(CalibrationYaml, keepsWhatTheControllerCompensated) {
  Calibration c = test::exampleCalibration();
  const auto readBack = [&] { return parseCalibration(calibrationYaml(c), "c.yaml").compensation; };
  EXPECT_EQ(readBack().stated, ControllerCompensation::Stated::kNot);
  c.compensation.stated = ControllerCompensation::Stated::kNone;
  EXPECT_EQ(readBack(), c.compensation);
  c.compensation = {ControllerCompensation::Stated::kFiles,
                    "fanuc",
                    {{"parameters.txt", "%\r\nN01851 A1 P3\n\t: # no comment\n%"}, {"kept/µ.txt", ""}}};
  EXPECT_EQ(readBack(), c.compensation);
  EXPECT_EQ(readBack().files.at(0).text, c.compensation.files[0].text);
  std::string text = calibrationYaml(c);
  text.replace(text.find("A1 P3"), 5, "A1 P4");
  const std::string body = text.substr(text.find('\n') + 1);
  try {
    parseCalibration("checksum: crc64-" + checksumOf(body) + "\n" + body, "c.yaml");
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("'checksum' is not that of the files"), std::string::npos)
        << e.what();
  }
}

TEST(CalibrationYaml, readsFilesThatDoNotTellArtifactAndDegreesOfFreedom) {
  Calibration c = test::exampleCalibration();
  c.artifact.reset();
  c.degreesOfFreedom = 0;
  const std::string text = calibrationYaml(c);
  EXPECT_EQ(text.find("artifact:"), std::string::npos);
  EXPECT_EQ(text.find("degrees_of_freedom"), std::string::npos);
  const Calibration r = parseCalibration(text, "c.yaml");
  EXPECT_FALSE(r.artifact.has_value());
  EXPECT_EQ(r.degreesOfFreedom, 0.0);
}

TEST(CalibrationYaml, readsAnEffectByItsOlderName) {
  Calibration c = test::exampleCalibration();
  c.effects[0] = EffectSpec("cross_talk").set("axis", "x").set("of", "y");
  const Calibration r = parseCalibration(calibrationYaml(c), "c.yaml");
  EXPECT_EQ(r.effects[0].yaml(), "{type: squareness, axis: x, of: y}");
}

TEST(CalibrationYaml, keepsACovarianceThatIsNotSymmetricAndAnUrdfOfAnyText) {
  Calibration c = test::exampleCalibration();
  c.covariance(0, 2) = 0.25;
  const std::string urdf = c.urdf;
  for (const char* tail : {"", "\n\n", "<!--\r\n\t x-->", "<!-- \xc3\xa9: 'a' # -->\n", "  "}) {
    c.urdf = urdf + tail;
    const Calibration r = parseCalibration(calibrationYaml(c), "c.yaml");
    EXPECT_EQ(r.urdf, c.urdf);
    EXPECT_EQ(r.covariance, c.covariance);
  }
}

TEST(CalibrationYaml, saysValuesInTheUnitOfPeople) {
  EXPECT_NE(calibrationYaml(test::exampleCalibration()).find("# -123.457 +- 0.3 um/m"), std::string::npos);
}

TEST(CalibrationYaml, findsEveryChangedByteAndEveryCut) {
  Calibration c = test::exampleCalibration();
  completeCalibration(c);
  const std::string text = calibrationYaml(c);
  for (std::size_t i = 0; i < text.size(); i += 7) {
    std::string damaged = text;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x04);
    EXPECT_NE(refusal([&] { parseCalibration(damaged, "c.yaml"); }).find("c.yaml"), std::string::npos)
        << "byte " << i;
    EXPECT_THROW(parseCalibration(text.substr(0, i), "c.yaml"), InputError) << "cut at " << i;
  }
  EXPECT_NE(refusal([&] { parseCalibration("", "c.yaml"); }).find("empty"), std::string::npos);
  EXPECT_NE(
      refusal([&] { parseCalibration("machine: three_axis\n", "m.yaml"); }).find("not a calibration file"),
      std::string::npos);
}

TEST(CalibrationYaml, refusesByName) {
  const std::string text = calibrationYaml(test::exampleCalibration());
  const auto says = [&](const std::string& from, const std::string& to) {
    const std::string bad = changed(text, from, to);
    return refusal([&] { parseCalibration(bad, "c.yaml"); });
  };
  EXPECT_NE(says("method: ", "metod: x\n  method: ").find("unknown key 'metod'"), std::string::npos);
  EXPECT_NE(says("  duration_s: 1234.5\n", "").find("'duration_s' is missing"), std::string::npos);
  EXPECT_NE(says("duration_s: 1234.5", "duration_s: long").find("'duration_s' must be a number"),
            std::string::npos);
  EXPECT_NE(says("schema: 1", "schema: 2").find("schema 2"), std::string::npos);
  EXPECT_NE(says("- name: y", "- name: w").find("joints of 'urdf'"), std::string::npos);
  EXPECT_NE(says("{effect: 1, name: k2", "{effect: 9, name: k2").find("k2"), std::string::npos);
  EXPECT_NE(says("laser: false", "laser: false\n  laser: true").find("'laser' is given twice"),
            std::string::npos);
  EXPECT_NE(says("seed: 18446744073709551615", "seed: -1").find("seed"), std::string::npos);
  EXPECT_NE(says("seed: ", "seed: [").find("c.yaml"), std::string::npos);
}

TEST(CalibrationYaml, doesNotWriteWhatContradictsItself) {
  Calibration c = test::exampleCalibration();
  c.values.pop_back();
  EXPECT_THROW(calibrationYaml(c), InputError);
}

TEST(SaveCalibration, writesOneFileAndNothingBeside) {
  const fs::path folder = freshFolder("save");
  Calibration c = test::exampleCalibration();
  saveCalibration(c, folder / "c.yaml");
  EXPECT_FALSE(c.id.empty());
  EXPECT_FALSE(c.software.empty());
  EXPECT_EQ(loadCalibration(folder / "c.yaml").id, c.id);
  saveCalibration(c, folder / "c.yaml");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
  const std::string nowhere = refusal([&] { saveCalibration(c, folder / "no" / "c.yaml"); });
  EXPECT_NE(nowhere.find("create the folder"), std::string::npos) << nowhere;
  EXPECT_NE(refusal([&] { saveCalibration(c, folder); }).find("is a folder"), std::string::npos);
  EXPECT_NE(refusal([&] { loadCalibration(folder / "absent.yaml"); }).find("absent.yaml"), std::string::npos);
  fs::remove_all(folder);
}

TEST(SaveCalibration, keepsTheOldFileWhenTheDiskIsFull) {
  const fs::path folder = freshFolder("full");
  Calibration c = test::exampleCalibration();
  saveCalibration(c, folder / "c.yaml");
  const std::string before = readFile(folder / "c.yaml");
  const pid_t child = ::fork();
  if (child == 0) {  // a limit of file sizes stands in for a full disk
    const rlimit small{1000, 1000};
    setrlimit(RLIMIT_FSIZE, &small);
    c.rms = 1.0;
    const std::string what = refusal([&] { saveCalibration(c, folder / "c.yaml"); });
    const bool clear = what.find("c.yaml") != std::string::npos && what.find("ulimit") != std::string::npos;
    _exit(clear ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_EQ(readFile(folder / "c.yaml"), before);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
  EXPECT_NE(refusal([&] { writeFileAtomically("/dev/full", "text"); }).find("free disk space"),
            std::string::npos);
  EXPECT_TRUE(fs::is_character_file("/dev/full")) << "it was replaced";
  fs::remove_all(folder);
}

}  // namespace
}  // namespace mm
