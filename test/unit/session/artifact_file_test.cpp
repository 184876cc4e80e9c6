#include "session/artifact_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "session_files.h"

namespace mm {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(ArtifactFile, ReadsEveryKeyInItsUnit) {
  const Artifact a = parseArtifact(R"(name: nine_ball_plate
pose: free
probe: {tip_radius_mm: 1.0, repeatability_um: 0.3}
expansion_per_K: 11.5e-6
temperature_sensor: bed
balls:
  - {name: b0, centre_mm: [-16.0, -11.0, -5.1], radius_mm: 3.9685, radius_std_um: 0.1, centre_std_um: 0.2}
  - {name: b1, centre_mm: [1, 2, 3], centre: free, radius_mm: 4}
points:
  - {name: target, position_mm: [20.4, 252.6, 154.7], position: free}
)",
                                   "a.yaml");
  EXPECT_EQ(a.name, "nine_ball_plate");
  EXPECT_FALSE(a.poseKnown);
  EXPECT_DOUBLE_EQ(a.tipRadius, 1e-3);
  EXPECT_DOUBLE_EQ(a.repeatability, 0.3e-6);
  EXPECT_DOUBLE_EQ(a.expansion, 11.5e-6);
  EXPECT_EQ(a.temperatureSensor, "bed");
  ASSERT_EQ(a.features.size(), 3u);
  EXPECT_TRUE(a.features[0].known);
  EXPECT_DOUBLE_EQ(a.features[0].position.x(), -16e-3);
  EXPECT_DOUBLE_EQ(a.features[0].radius, 3.9685e-3);
  EXPECT_DOUBLE_EQ(a.features[0].radiusStd, 0.1e-6);
  EXPECT_DOUBLE_EQ(a.features[0].positionStd, 0.2e-6);
  EXPECT_FALSE(a.features[1].known);
  EXPECT_EQ(a.features[2].kind, FeatureKind::kPoint);
  EXPECT_FALSE(a.features[2].known);
  EXPECT_EQ(a.findFeature("target"), 2);
  EXPECT_EQ(a.findFeature("b2"), -1);
}

TEST(ArtifactFile, DefaultsAreAKnownPoseAndKnownPlaces) {
  const Artifact a = parseArtifact("name: p\npoints: [{name: t, position_mm: [1, 2, 3]}]\n", "a.yaml");
  EXPECT_TRUE(a.poseKnown);
  EXPECT_TRUE(a.features[0].known);
  EXPECT_TRUE(std::isnan(a.repeatability));
}

struct BadArtifact {
  const char* what;
  const char* yaml;
  const char* where;
  const char* says;
};
void PrintTo(const BadArtifact& bad, std::ostream* out) { *out << bad.what; }

class BadArtifactFile : public ::testing::TestWithParam<BadArtifact> {};

TEST_P(BadArtifactFile, IsRefusedInOneLineThatNamesTheFault) {
  const std::string message = test::messageOf<InputError>([] { parseArtifact(GetParam().yaml, "a.yaml"); });
  EXPECT_THAT(message,
              AllOf(HasSubstr(std::string("a.yaml:") + GetParam().where), HasSubstr(GetParam().says)));
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Each, BadArtifactFile,
    ::testing::Values(
        BadArtifact{"unknown key", "name: a\npsoe: free\n", "2:", "unknown key 'psoe'; did you mean 'pose'"},
        BadArtifact{"unknown key of a ball",
                    "name: a\nballs:\n  - {name: b, centre_mm: [0, 0, 0], radius_mm: 1, colour: red}\n",
                    "3:", "unknown key 'colour'"},
        BadArtifact{"wrong unit", "name: a\nballs:\n  - {name: b, centre_mm: [0, 0, 0], radius_um: 1}\n",
                    "3:", "unknown key 'radius_um'; did you mean 'radius_mm'"},
        BadArtifact{"doubled key", "name: a\npose: free\npose: known\n", "3:", "'pose' is given twice"},
        BadArtifact{"duplicate ball",
                    "name: a\nballs:\n  - {name: b, centre_mm: [0, 0, 0], radius_mm: 1}\n"
                    "  - {name: b, centre_mm: [1, 0, 0], radius_mm: 1}\n",
                    "4:", "'b' is used by another ball or point"},
        BadArtifact{"ball and point of one name",
                    "name: a\nballs: [{name: b, centre_mm: [0, 0, 0], radius_mm: 1}]\npoints: [{name: b, "
                    "position_mm: [0, 0, 0]}]\n",
                    "3:", "'b' is used by another ball or point"},
        BadArtifact{"negative radius",
                    "name: a\nballs:\n  - {name: b, centre_mm: [0, 0, 0], radius_mm: -4}\n",
                    "3:", "'radius_mm' is -4, but must be above 0"},
        BadArtifact{"missing radius", "name: a\nballs:\n  - {name: b, centre_mm: [0, 0, 0]}\n",
                    "3:", "'radius_mm' is missing"},
        BadArtifact{"missing name", "name: a\nballs:\n  - {centre_mm: [0, 0, 0], radius_mm: 1}\n",
                    "3:", "'name' is missing"},
        BadArtifact{"no centre", "name: a\nballs:\n  - {name: b, radius_mm: 1}\n",
                    "3:", "'centre_mm' is missing"},
        BadArtifact{"NaN", "name: a\nballs:\n  - {name: b, centre_mm: [0, .nan, 0], radius_mm: 1}\n",
                    "3:", "finite number"},
        BadArtifact{"text", "name: a\nprobe: {tip_radius_mm: one}\n", "2:", "not 'one'"},
        BadArtifact{"two coordinates", "name: a\nballs:\n  - {name: b, centre_mm: [0, 0], radius_mm: 1}\n",
                    "3:", "three numbers"},
        BadArtifact{"negative tip", "name: a\nprobe: {tip_radius_mm: -1}\n", "2:", "at least 0"},
        BadArtifact{"half-known pose", "name: a\npose: maybe\n", "2:", "known or free"},
        BadArtifact{"not YAML", "name: [a\n", "2:", "not YAML"},
        BadArtifact{"a list", "- a\n", "1:", "mapping"}, BadArtifact{"empty", "", "1:", "mapping"}));

TEST(ArtifactFile, AMissingFileIsNamed) {
  EXPECT_THAT(test::messageOf<InputError>([] { loadArtifact("no.yaml"); }), HasSubstr("no.yaml"));
}

TEST(ArtifactFile, KnowsSeveralStyli) {
  const Artifact a = parseArtifact(
      "name: plate\nserial: P 7\nprobe: {styli: [{name: A, tip_radius_mm: 1}, {name: B, tip_radius_mm: 0.5, "
      "offset_mm: [0, 0, -20]}, {name: C, tip_radius_mm: 2}, {name: D, tip_radius_mm: 2, offset_mm: [1, 2, "
      "3], "
      "offset: free}]}\n",
      "a.yaml");
  EXPECT_EQ(a.serial, "P 7");
  EXPECT_EQ(a.tipRadiusOf(1), 0.5e-3);
  EXPECT_TRUE(a.styli[0].known && a.styli[0].offset.isZero(0.0)) << "where the machine says";
  EXPECT_TRUE(a.styli[1].known);
  EXPECT_FALSE(a.styli[2].known);
  EXPECT_TRUE(a.styli[2].offset.hasNaN());
  EXPECT_FALSE(a.styli[3].known);
  EXPECT_EQ(a.styli[3].offset.x(), 1e-3);
  const auto refusal = [](const std::string& probe) {
    return test::messageOf<InputError>([&] { parseArtifact("name: p\nprobe: " + probe + "\n", "a.yaml"); });
  };
  EXPECT_THAT(refusal("{tip_radius_mm: 1, styli: [{name: A, tip_radius_mm: 1}]}"),
              HasSubstr("exclude each other"));
  EXPECT_THAT(refusal("{styli: [{name: A, tip_radius_mm: 1}, {name: A, tip_radius_mm: 1}]}"),
              HasSubstr("'A' is used by another stylus"));
  EXPECT_THAT(refusal("{styli: []}"), HasSubstr("must be a list of one or more styli"));
}

}  // namespace
}  // namespace mm
