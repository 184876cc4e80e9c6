// A controller that can carry a part of the calibration alone.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/format.h"
#include "compensation_support.h"
#include "exported_controller.h"
#include "read_contacts.h"
#include "report/verify_json.h"
#include "verdict_tally.h"

namespace mm {
namespace {

using namespace test;  // NOLINT: helpers of this test alone

using Added = ExportedController::Added;

TEST(VerifyExport, whatNoTableCarriesIsNoDrift) {
  for (std::uint64_t run = 0; run < 2; ++run) {
    const std::uint64_t seed = 6000 + 10 * run;
    const std::string rough = roughOf(run);
    const LoadedController controller(seed, rough);
    const ExportedController exported(controller, "linuxcnc", true);
    const Session session = controller.measure(
        seed + 1, exported.loading([&](const CommandedState& c) { return exported.tables(c); }), rough);
    const Verification v = exported.judge(session);
    EXPECT_EQ(v.verdict, VerifyVerdict::kHelped) << v.inWords;
    EXPECT_FALSE(v.offsets) << v.inWords;
    // Both squarenesses, 250 and 150 urad, at these points.
    EXPECT_GT(v.notCarried, 0.5e-6) << v.inWords;
    EXPECT_NE(v.inWords.find("do not carry"), std::string::npos) << v.inWords;
    for (const RemainingOfEffect& effect : v.effects) {
      const bool carried = effect.effect.type != "squareness";
      EXPECT_NEAR(effect.notCarried, carried ? 0.0 : 1.0, 0.1) << effect.effect.yaml();
      // A machine that wanders does so by a share of an effect.
      if (!carried || (effect.std < 0.2 && rough.empty())) {
        EXPECT_EQ(effect.inWords, carried ? "corrected" : "not in any table") << effect.effect.yaml();
      }
    }
    // Without the export nobody can know.
    const Verification blind = exported.judge(session, false);
    EXPECT_TRUE(blind.drifted) << blind.inWords;
    EXPECT_NE(blind.inWords.find("name them with --export"), std::string::npos) << blind.inWords;
  }
}

/// 500 um/m of scale and 100 um/m/K of x, read by an instrument at 18 to 26 degC of the bed.
/// @param adds to x, m.
Session warmAxis(const std::function<double(const CommandedState&)>& adds) {
  std::string text = "time_s,x_mm,x_velocity_mm_s,deviation_x_um,bed_degC\n";
  for (int i = 0; i < 120; ++i) {
    const double bed = 22.0 + 4.0 * std::sin(0.05 * i), phase = 0.13 * i;
    const double x = 18.0 * std::sin(phase), velocity = std::cos(phase) > 0.0 ? 1.0 : -1.0;
    CommandedState command{{{"x", x * 1e-3}, {"y", 0.0}, {"z", 0.0}},
                           {{"x", static_cast<int>(velocity)}, {"y", 1}, {"z", 1}},
                           {}};
    const double deviation = 0.5 * x + 0.1 * x * (bed - 20.0) + 1e6 * adds(command) + 0.1 * std::sin(7.0 * i);
    text += format("%d,%.6f,%g,%.6f,%.4f\n", i, x, velocity, deviation, bed);
  }
  const Folder folder;
  return readContactsCsv(folder.write("warm.csv", text), Machine::load("three_axis"), nullptr);
}

// A table of positions has the expansion at one temperature, in the shape of the scale; the rest of it in
// none.
TEST(VerifyExport, everyRowSaysWhatTheVerdictSays) {
  LoadedController controller(6700);
  Calibration c = calibrationOf(Machine::load("three_axis"),
                                {EffectSpec("scale").set("axis", "x"),
                                 EffectSpec("thermal_expansion").set("axis", "x").set("sensor", "bed")});
  c.domain.sensors = {"bed"};
  c.domain.sensorLower = {18};
  c.domain.sensorUpper = {26};
  c.values[0].value = 500e-6;
  c.values[1].value = 100e-6;
  c.repeatability = 0.1e-6;
  c.heldOutRms = 0.1e-6;
  controller.calibration = c;
  const ExportedController exported(controller, "linuxcnc", true);
  const struct {
    double times;
    const char *finding, *words;
  } kLoaded[] = {{1.0, "corrected", "corrected"},
                 {0.0, "not_corrected", "not corrected"},
                 {-1.0, "wrong_sign", "wrong sign"},
                 {2.0, "corrected_twice", "corrected twice"}};
  for (const auto& loaded : kLoaded) {
    const Verification v = exported.judge(warmAxis(
        [&](const CommandedState& command) { return loaded.times * exported.tables(command).at("x"); }));
    EXPECT_EQ(v.finding, loaded.finding) << v.inWords;
    ASSERT_EQ(v.axes.size(), 1u);
    ASSERT_EQ(v.effects.size(), 2u);
    EXPECT_EQ(v.axes[0].inWords, loaded.words) << v.inWords;
    EXPECT_EQ(v.effects[0].inWords, loaded.words) << v.effects[0].remaining;
    EXPECT_LT(v.effects[0].notCarried, -0.2);
    EXPECT_EQ(v.effects[1].inWords, "not in any table") << v.effects[1].notCarried;
  }
}

/// What each controller is asked, and which of its corrections can be at the wrong place.
struct Target {
  std::string name;
  bool offsets = false;            // beside the tables
  std::string wrong;               // the axis whose sign is wrong; empty: one axis alone is corrected
  bool tables = true;              // exchanged tables are entered by the other axis; else one is added there
  std::string exchanged;           // in words
  std::uint64_t firstSeed = 6000;  // of the everyday runs
};

Added exchangedOf(const ExportedController& exported, const Target& target, const CommandedState& command) {
  CommandedState other = command;
  if (target.tables) {
    std::swap(other.position.at("x"), other.position.at("y"));
    std::swap(other.direction.at("x"), other.direction.at("y"));
  }
  const Added own = exported.tables(command);
  const Added there = exported.tables(other);
  return {{"x", there.at("y")}, {"y", there.at("x")}, {"z", own.at("z")}};
}

class ExportTable {
 public:
  explicit ExportTable(const Target& target) : target_(target) {
    for (const char* what : {"helped", "not loaded", "wrong sign", "one axis of the wrong sign",
                             "x and y exchanged", "drifted since", "tables loaded, offsets not",
                             "offsets loaded, tables not", "offsets of the wrong sign"})
      tallies_.push_back(std::make_unique<VerdictTally>(
          target.name + (target.offsets ? " and external offsets, " : ", ") + what));
  }

  void run(std::uint64_t seed, const std::string& rough, const LoadedController& controller) {
    const ExportedController exported(controller, target_.name,
                                      target_.name == "linuxcnc" && !target_.offsets);
    std::uint64_t next = seed;
    const auto judged = [&](const std::function<Added(const CommandedState&)>& adds,
                            const std::vector<std::string>& errors = loadedErrors()) {
      ++next;
      return exported.judge(
          controller.measure(next, adds ? exported.loading(adds) : ControllerAdds(), rough, errors));
    };
    const auto whole = [&](const CommandedState& c) { return sum(exported.tables(c), exported.offsets(c)); };
    const auto both = [&](const char* words) { return std::string(target_.offsets ? words : ""); };
    using V = VerifyVerdict;
    of(0).add(seed, judged(whole), {V::kHelped}, "corrected", false,
              both("the tables and the external offsets are loaded"));
    const Verification none = judged({});
    of(1).add(seed, none, {V::kNoChange}, "not_corrected", false, "is it loaded?");
    of(2).add(seed, judged([&](const CommandedState& c) { return times(-1.0, whole(c)); }), {V::kWorse},
              "wrong_sign", false, "sign is wrong");
    if (!target_.wrong.empty()) {
      const Verification one = judged([&](const CommandedState& c) {
        return sum(times(-1.0, exported.tables(c), target_.wrong), exported.offsets(c));
      });
      of(3).add(seed, one, rightFor(one.after, none.after), "partly", false,
                target_.wrong + " has the wrong sign");
    }
    const Verification swapped = judged(
        [&](const CommandedState& c) { return sum(exchangedOf(exported, target_, c), exported.offsets(c)); });
    of(4).add(seed, swapped, rightFor(swapped.after, none.after), "exchanged", false, target_.exchanged);
    const Verification later = judged(whole, loadedErrors(5.0, 80.0));
    of(5).add(seed, later, {V::kMixed}, "corrected", true, "changed since the calibration");
    if (!target_.offsets) return;
    const Verification alone = judged([&](const CommandedState& c) { return exported.tables(c); });
    of(6).add(seed, alone, rightFor(alone.after, none.after), "partly", false,
              "the tables are loaded, the external offsets are not");
    const Verification without = judged([&](const CommandedState& c) { return exported.offsets(c); });
    of(7).add(seed, without, rightFor(without.after, none.after), "partly", false,
              "the external offsets are loaded, the tables are not");
    const Verification sign = judged(
        [&](const CommandedState& c) { return sum(exported.tables(c), times(-1.0, exported.offsets(c))); });
    of(8).add(seed, sign, rightFor(sign.after, none.after), "partly", false,
              "the tables are loaded, the external offsets have the wrong sign");
  }

  /// Where all is right.
  int qualified() const { return tallies_.front()->qualified(); }

 private:
  VerdictTally& of(std::size_t i) { return *tallies_[i]; }
  Target target_;
  std::vector<std::unique_ptr<VerdictTally>> tallies_;
};

const Target kTargets[] = {
    {"linuxcnc", true, "y", true, "x and y have each other's table"},
    {"linuxcnc", false, "y", true, "x and y have each other's table"},
    // The reversal alone, $100 and $101 exchanged.
    {"grblhal", false, "y", true, "x and y have each other's table"},
    // Of skew x alone is corrected.
    {"klipper", false, "", false, "y has the correction of x, and x has none"},
};

TEST(VerifyExport, saysRightlyWhatOfAnExportIsLoadedHow) {
  std::vector<std::unique_ptr<ExportTable>> tables;
  for (const Target& target : kTargets) tables.push_back(std::make_unique<ExportTable>(target));
  const std::uint64_t runs = mm_test::longTests() ? 100 : 2;
  for (std::uint64_t run = 0; run < runs; ++run) {
    const std::uint64_t seed = firstSeed(6000) + 20 * run;
    const LoadedController controller(seed, roughOf(run));
    for (const auto& table : tables) table->run(seed, roughOf(run), controller);
  }
  // One in a thousand by chance.
  for (const auto& table : tables) EXPECT_LE(table->qualified(), 1);
}

TEST(VerifyExport, jsonTellsTheExternalOffsets) {
  const LoadedController controller(6300);
  const ExportedController exported(controller, "linuxcnc");
  const auto json = [&](const std::function<Added(const CommandedState&)>& adds) {
    return nlohmann::json::parse(
        verifyJson(exported.judge(controller.measure(6301, exported.loading(adds)))));
  };
  const auto alone = json([&](const CommandedState& c) { return exported.tables(c); });
  EXPECT_EQ(alone.at("finding"), "partly");
  EXPECT_EQ(alone.at("external_offsets").at("state"), "not_loaded");
  EXPECT_NEAR(alone.at("external_offsets").at("remaining").get<double>(), 1.0, 0.1);
  for (const auto& axis : alone.at("axes")) EXPECT_EQ(axis.at("in_words"), "corrected") << axis;
  // Nothing that was exported is not carried.
  EXPECT_LT(alone.at("not_carried_um").get<double>(), 0.05);
  const auto both =
      json([&](const CommandedState& c) { return sum(exported.tables(c), exported.offsets(c)); });
  EXPECT_EQ(both.at("verdict"), "helped");
  EXPECT_EQ(both.at("external_offsets").at("state"), "loaded");
  EXPECT_NEAR(both.at("external_offsets").at("remaining").get<double>(), 0.0, 0.1);
}

TEST(VerifyExport, offsetsAloneAreJudgedWhereTheTablesHoldNothing) {
  // Of two squarenesses alone nothing goes into the table of an axis by its own position.
  const std::vector<std::string> errors = {"squareness:y/x=250urad", "squareness:x/z=150urad"};
  const LoadedController controller(6400, {},
                                    "effects: [{type: squareness, axis: y, of: x}, {type: squareness, axis: "
                                    "x, of: z}]",
                                    errors);
  const ExportedController exported(controller, "linuxcnc");
  const ControllerAdds adds = exported.loading([&](const CommandedState& c) { return exported.offsets(c); });
  const Verification without = exported.judge(controller.measure(6401, {}, {}, errors));
  EXPECT_EQ(without.verdict, VerifyVerdict::kNoChange) << without.inWords;
  EXPECT_EQ(without.finding, "not_corrected") << without.inWords;
  EXPECT_NE(without.inWords.find("external offsets alone"), std::string::npos) << without.inWords;
  const Verification with = exported.judge(controller.measure(6402, adds, {}, errors));
  EXPECT_NE(with.finding, "not_corrected") << with.inWords;
  EXPECT_EQ(with.hypothesis.offsets, AxisState::kCorrected) << with.inWords;
}

TEST(VerifyExport, takesWhatIsLoadedBeyondWhatWasActive) {
  // Calibrated with nothing loaded, exported; with that loaded and the machine changed, calibrated and
  // exported again: the second folder holds both, of which the second calibration knows one.
  const LoadedController first(6600);
  const ExportedController tables(first, "siemens");
  LoadedController second(6601, {}, {}, loadedErrors(1.0));
  second.calibration.compensation =
      statedCompensation("--compensation", "siemens:" + tables.folder().string());
  const ExportedController both(second, "siemens");
  const LoadedExport loaded(both.folder(), second.calibration);
  const LoadedController unstated(6601, {}, {}, loadedErrors(1.0));
  const ExportedController alone(unstated, "siemens");
  const CommandedState command{
      {{"x", 0.011}, {"y", -0.007}, {"z", 0.004}}, {{"x", 1}, {"y", -1}, {"z", 1}}, {}};
  State state;
  state.position = {0.011, -0.007, 0.004};
  state.travel = {1.0, -1.0, 1.0};
  state.temperature.assign(second.calibration.domain.sensors.size(), kNotMeasured);
  const std::map<std::string, double> expected = alone.tables(command);
  for (int j = 0; j < 3; ++j)
    EXPECT_NEAR(loaded.adds(state)[j], expected.at(std::string(1, "xyz"[j])), 5e-9) << j;

  Session fresh = second.measure(6602, {});
  fresh.compensation.stated = ControllerCompensation::Stated::kNone;
  VerifyOptions options;
  options.loaded = true;
  options.calibrate.threads = 1;
  const auto said = [&] {
    return messageOf<InputError>([&] { verify(fresh, second.calibration, options); });
  };
  EXPECT_NE(said().find("contradicts --loaded"), std::string::npos) << said();
  options.exported = std::make_shared<const LoadedExport>(both.folder(), second.calibration);
  EXPECT_NE(said().find("the folder of --export holds tables of siemens"), std::string::npos) << said();
  fresh.compensation = options.exported->statement();
  EXPECT_EQ(said(), "");
  options = {};
  options.calibrate.threads = 1;
  EXPECT_NE(said().find("the calibration was measured with: tables of siemens"), std::string::npos) << said();
}

TEST(VerifyExport, ofOtherFoldersIsRefused) {
  const LoadedController controller(6200);
  const ExportedController exported(controller, "linuxcnc");
  const Folder folder;
  const auto refusal = [&](const Calibration& calibration, const std::filesystem::path& of) {
    return messageOf<InputError>([&] { LoadedExport(of, calibration); });
  };
  EXPECT_NE(refusal(controller.calibration, folder.path("out")).find("holds no representability.json"),
            std::string::npos);
  EXPECT_EQ(refusal(controller.calibration, exported.folder()), "");
  Calibration other = controller.calibration;
  other.id = "other";
  EXPECT_NE(refusal(other, exported.folder()).find("was made of calibration 'test', not of 'other'"),
            std::string::npos);
  VerifyOptions options;
  options.exported = std::make_shared<const LoadedExport>(exported.folder(), controller.calibration);
  const Session session = controller.measure(6201, {});
  EXPECT_NE(messageOf<InputError>([&] { verify(session, controller.calibration, options); }).find("--loaded"),
            std::string::npos);
  std::filesystem::copy(exported.folder(), folder.path("out"));
  folder.write("out/external_offsets.json", "{\"format\": \"other\"}");
  EXPECT_NE(refusal(controller.calibration, folder.path("out")).find("is not a file of external offsets"),
            std::string::npos);
  folder.write("out/representability.json", "{");
  EXPECT_NE(refusal(controller.calibration, folder.path("out")).find("is not what mm export writes"),
            std::string::npos);
}

}  // namespace
}  // namespace mm
