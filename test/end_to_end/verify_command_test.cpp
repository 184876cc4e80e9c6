// mm verify against a store and against the tables of an export.
#include <gtest/gtest.h>

#include <filesystem>

#include "run_mm.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

/// Three sessions and two calibrations, made once; each test has a copy of its own of the folder that keeps
/// them.
class VerifyCommandTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TestFolder;
    bag_ = *folder_ / "s.bag";
    fresh_ = *folder_ / "fresh.bag";
    worn_ = *folder_ / "worn.bag";
    store_ = *folder_ / "kept";
    const std::string plan = "simulate --machine three_axis --plan config/demo_plan.yaml ";
    run(plan + "--seed 1 -o " + bag_);
    run(plan + "--seed 2 -o " + fresh_);
    run(plan + "--seed 3 --hide scale:x=-0.002 -o " + worn_);  // x errs to the other side by now
    calibrate("one", "{type: scale, axis: x}");
    calibrate("two",
              "{type: scale, axis: x}, {type: scale, axis: y}, {type: scale, axis: z}, "
              "{type: squareness, axis: x, of: y}, {type: backlash, axis: x}");
    fs::rename(store_, store_ + ".made");
  }
  static void TearDownTestSuite() { delete folder_; }
  void SetUp() override {
    fs::copy(store_ + ".made", store_, fs::copy_options::recursive | fs::copy_options::copy_symlinks);
  }
  void TearDown() override { fs::remove_all(store_); }
  static Answer typed(const std::string& arguments) { return mmRun(*folder_, arguments); }
  static void run(const std::string& arguments) {
    const Answer answer = typed(arguments);
    ASSERT_EQ(answer.status, 0) << arguments << ": " << answer.error;
  }
  static void calibrate(const std::string& name, const std::string& effects) {
    const std::string model =
        folder_->write(name + "_model.yaml", "machine: three_axis\neffects: [" + effects + "]\n");
    run("calibrate " + bag_ + " --model " + model + " --method least_squares -o " +
        *folder_ / (name + ".yaml"));
    run("promote " + *folder_ / (name + ".yaml") + " --store " + store_);
  }
  static std::string active() { return fs::read_symlink(store_ + "/active").filename().string(); }

  static inline TestFolder* folder_ = nullptr;
  static inline std::string bag_, fresh_, worn_, store_;
};

TEST_F(VerifyCommandTest, takesBackWhatDoesNotHelp) {
  const std::string two = active(),
                    how = " --calibration " + *folder_ / "two.yaml" + " --roll-back --store " + store_;
  const Answer helps = typed("verify " + fresh_ + how);
  EXPECT_EQ(helps.status, 0) << helps.out << helps.error;
  EXPECT_EQ(active(), two);
  const Answer worse = typed("verify " + worn_ + how);
  EXPECT_EQ(worse.status, 1);
  EXPECT_NE(worse.error.find("rolled back: "), std::string::npos) << worse.error;
  EXPECT_NE(active(), two);
  const std::string one = active();
  const Answer again = typed("verify " + worn_ + how);
  EXPECT_EQ(again.status, 1);
  EXPECT_NE(again.error.find("nothing is rolled back"), std::string::npos) << again.error;
  EXPECT_EQ(active(), one);
}

TEST_F(VerifyCommandTest, theAnswerIsKeptWithTheCalibrationAndStandsOnItsCertificate) {
  const std::string id = fs::path(active()).stem().string();
  run("verify " + fresh_ + " --calibration " + *folder_ / "two.yaml" + " --store " + store_);
  const std::string noted = textOf(store_ + "/verifications");
  EXPECT_NE(noted.find(" " + id + " helped "), std::string::npos) << noted;
  run("certificate " + *folder_ / "two.yaml" + " --store " + store_ +
      " --task position:0,0,0 --trials 200 -o " + *folder_ / "c.html");
  const std::string page = textOf(*folder_ / "c.html");
  for (const char* part :
       {"History of use", "<b>active</b>", "made active", "compared with fresh points: helped, "})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  // A folder that cannot be written keeps nothing and spoils no answer.
  const Answer elsewhere =
      typed("verify " + fresh_ + " --calibration " + *folder_ / "two.yaml" + " --store /proc/none");
  EXPECT_EQ(elsewhere.status, 0) << elsewhere.error;
}

TEST_F(VerifyCommandTest, knowsWhatWasExported) {
  const std::string how = " --calibration " + *folder_ / "two.yaml", out = *folder_ / "linuxcnc";
  run("export " + *folder_ / "two.yaml" + " --to linuxcnc -o " + out);
  const Answer raw = typed("verify " + fresh_ + how + " --export " + out);
  EXPECT_EQ(raw.status, 2);
  EXPECT_NE(raw.error.find("--loaded"), std::string::npos) << raw.error;
  const Answer loaded = typed("verify " + fresh_ + how + " --loaded --json --export " + out);
  ASSERT_EQ(loaded.status, 1) << loaded.error;
  const nlohmann::json found = loaded.json();
  EXPECT_EQ(found["finding"], "not_corrected") << loaded.out;
  EXPECT_EQ(found["verdict"], "no_change");
  EXPECT_EQ(found["export"], "linuxcnc");
  EXPECT_EQ(found["external_offsets"]["state"], "not_loaded") << loaded.out;
  EXPECT_GT(found["external_offsets"]["size_um"].get<double>(), 1.0);  // the squareness, 500 urad
  EXPECT_LT(found["not_carried_um"].get<double>(), 0.1) << "the offsets carry what the tables do not";
  const std::string alone = *folder_ / "tables_alone";
  run("export " + *folder_ / "two.yaml" + " --to linuxcnc --tables-alone -o " + alone);
  EXPECT_FALSE(fs::exists(alone + "/external_offsets.json"));
  const Answer tables = typed("verify " + fresh_ + how + " --loaded --json --export " + alone);
  EXPECT_TRUE(tables.json()["external_offsets"].is_null()) << tables.out;
  EXPECT_GT(tables.json()["not_carried_um"].get<double>(), 1.0);
  const Answer none =
      typed("export " + *folder_ / "two.yaml" + " --to klipper --tables-alone -o " + *folder_ / "k");
  EXPECT_EQ(none.status, 2);
  EXPECT_NE(none.error.find("--tables-alone"), std::string::npos) << none.error;
  const Answer other =
      typed("verify " + fresh_ + " --calibration " + *folder_ / "one.yaml" + " --loaded --export " + out);
  EXPECT_EQ(other.status, 2);
  EXPECT_NE(other.error.find("was made of calibration"), std::string::npos) << other.error;
}

TEST_F(VerifyCommandTest, aBlindTrialIsPlannedMeasuredAndOpened) {
  const std::string two = " --calibration " + *folder_ / "two.yaml", trial = *folder_ / "trial",
                    key = trial + ".key.yaml", loaded = *folder_ / "loaded";
  run("plan verify config/demo_plan.yaml" + two +
      " --blind --blocks 6 --seed 5 --touches 4 --switch-on M1 --switch-off M2 -o " + trial + ".yaml");
  EXPECT_NE(textOf(trial + ".A.txt"), textOf(trial + ".B.txt"));
  EXPECT_EQ(textOf(trial + ".yaml").find("M1"), std::string::npos);
  const Answer again = typed("plan verify config/demo_plan.yaml" + two + " --blind -o " + trial + ".yaml");
  EXPECT_EQ(again.status, 2) << "the key of a trial that may have been measured";
  run("export " + *folder_ / "two.yaml" + " --to linuxcnc -o " + loaded);
  run("simulate --machine three_axis --plan " + trial + ".yaml --seed 6 --compensation " + loaded +
      " --key " + key + " -o " + trial + ".bag");
  const Answer helps =
      typed("verify " + trial + ".bag" + two + " --blind " + key + " --json -o " + trial + ".html");
  ASSERT_EQ(helps.status, 0) << helps.out << helps.error;
  EXPECT_EQ(helps.json()["verdict"], "helped");
  EXPECT_NEAR(helps.json()["gain"]["value"].get<double>(), 1.0, 0.1);
  EXPECT_EQ(helps.json()["blocks"].size(), 6U);
  EXPECT_NE(textOf(trial + ".html").find("It helped"), std::string::npos);
  const Answer fresh = typed("verify " + fresh_ + two + " --blind " + key);
  EXPECT_EQ(fresh.status, 2);
  EXPECT_NE(fresh.error.find("no block of a blind trial"), std::string::npos) << fresh.error;
  EXPECT_EQ(fresh.error.find("none of its points is fresh"), std::string::npos) << fresh.error;
  const Answer stale = typed("verify " + bag_ + two + " --blind " + key);
  EXPECT_NE(stale.error.find("none of its points is fresh"), std::string::npos) << stale.error;
}

}  // namespace
}  // namespace mm
