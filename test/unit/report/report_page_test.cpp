#include "report/report_page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "report_sessions.h"
#include "session_files.h"
#include "workflow/learning.h"

namespace mm {
namespace {

constexpr const char* kHostile = "</script><script>alert(1)</script><!--";

std::size_t countOf(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

class ReportPage : public ::testing::Test {
 protected:
  test::Folder folder_;
  std::filesystem::path plotly_ = folder_.write("plotly.min.js", "/* plotly */" + std::string(200000, ' '));

  ReportContents contents(const Session& session, const std::string& path,
                          const std::vector<EffectSpec>& effects = {}) {
    CalibrateOptions fit;
    fit.method = Method::kLeastSquares;
    ModelSpec model;
    model.effects = effects;
    ReportOptions options;
    options.sessionPath = path;
    options.calibrationPath = "c.yaml";
    options.created = "2026-01-02T03:04:05Z";
    return makeReport(session, recalibrate(session, model, fit).calibration, options);
  }
};

TEST_F(ReportPage, NamesOfUsersFilesAreNeverMarkup) {
  const Session session = test::ballSession(kHostile, 3e-6, 0.2e-6);
  const ReportContents report = contents(session, std::string("{{data}}") + kHostile + ".bag");
  const std::string page = reportPage(report, loadReportFiles(plotly_));
  EXPECT_EQ(page.find("alert(1)</script>"), std::string::npos);
  EXPECT_EQ(countOf(page, "</script"), 3u);  // data, library, page
  EXPECT_EQ(countOf(page, "<!--"), 0u);
  const nlohmann::json data = nlohmann::json::parse(reportJson(report));
  EXPECT_EQ(data["point_set"]["features"][0]["name"], kHostile);
}

TEST_F(ReportPage, WithoutACalibrationTheMachineAsItIs) {
  const Session session = test::interferometerSession(2e-6, 0.1e-6);
  ReportOptions options;
  options.sessionPath = "s.bag";
  const ReportContents report = makeReport(session, options);
  const nlohmann::json data = nlohmann::json::parse(reportJson(report));
  EXPECT_TRUE(data["calibration"].is_null());
  EXPECT_TRUE(data["command"].is_null());
  EXPECT_TRUE(data["diagnosis"]["verdict"].is_null());
  EXPECT_TRUE(data["diagnosis"]["missing"].empty());
  EXPECT_TRUE(data["parameters"].empty());
  ASSERT_EQ(data["figures"].size(), 1u);
  EXPECT_NEAR(data["figures"][0]["rms_um"].get<double>(), 2.0, 0.1);
  EXPECT_NEAR(data["positioning"][0]["measured"]["figures"]["B"].get<double>(), 4.0, 0.2);
  const std::string page = reportPage(report, loadReportFiles(plotly_));
  EXPECT_NE(page.find("The machine as it is, without a calibration"), std::string::npos);
}

TEST_F(ReportPage, SaysWhatTheDiagnosisSaysAndWhatToTypeNext) {
  const Session session = test::interferometerSession(2e-6, 0.1e-6);
  const ReportContents report = contents(session, "my session.bag", {EffectSpec("scale").set("axis", "x")});
  ASSERT_FALSE(report.diagnosis.missing.empty());
  const nlohmann::json data = nlohmann::json::parse(reportJson(report));
  // at one speed play and a late trigger are the same: either may be named, the other as its rival
  const nlohmann::json& first = data["diagnosis"]["missing"][0];
  const bool play = first["effect"]["type"] == "backlash";
  EXPECT_TRUE(play || first["effect"]["type"] == "speed_lag") << first.dump();
  ASSERT_FALSE(first["confusable_with"].empty());
  EXPECT_EQ(first["confusable_with"][0]["effect"]["type"], play ? "speed_lag" : "backlash");
  EXPECT_EQ(data["command"], std::string("mm add 'my session.bag' --calibration c.yaml ") +
                                 (play ? "'{type: backlash, axis: x}'" : "'{type: speed_lag}'") +
                                 " -o c2.yaml");
  EXPECT_EQ(data["same_session"], true);
  ASSERT_EQ(data["figures"].size(), 4u);
  EXPECT_NEAR(data["figures"][0]["rms_um"].get<double>(), 2.0, 0.1);
  EXPECT_NEAR(data["figures"][3]["rms_um"].get<double>(), 0.1, 0.03);
  EXPECT_EQ(data["positioning"][0]["axis"], "x");
  EXPECT_NEAR(data["positioning"][0]["measured"]["figures"]["B"].get<double>(), 4.0, 0.2);
  EXPECT_NEAR(data["parameters"][0]["values"][0]["nominal"].get<double>(), 0.0, 1e-12);
  EXPECT_TRUE(data["measured"].is_null());  // the session has no clock
  ASSERT_EQ(data["added"].size(), 1u);      // backlash: -gap / 2 going forward
  EXPECT_NEAR(data["added"][0]["values"][0]["value"].get<double>(), play ? -4.0 : -2.0, 0.1);
  EXPECT_EQ(data["added"][0]["values"][0]["unit"], play ? "um" : "ms");
  EXPECT_TRUE(data["vectors"].is_null());
  const std::string page = reportPage(report, loadReportFiles(plotly_));
  EXPECT_NE(page.find("mm add &#39;my session.bag&#39;"), std::string::npos);
  EXPECT_EQ(countOf(page, "{{"), 0u);
}

/// What a browser makes of a page: its elements as text. Empty: there is no Chromium here.
std::string elementsOf(const std::filesystem::path& page) {
  if (std::system("command -v chromium >/dev/null 2>&1") != 0) return {};
  const std::string profile = page.string() + ".profile";
  const std::string command = "timeout 120 chromium --headless --no-sandbox --disable-gpu --user-data-dir='" +
                              profile + "' --virtual-time-budget=5000 --dump-dom 'file://" + page.string() +
                              "' 2>/dev/null";
  std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string text;
  char buffer[65536];
  while (pipe)
    if (const std::size_t n = std::fread(buffer, 1, sizeof(buffer), pipe.get()); n > 0)
      text.append(buffer, n);
    else
      break;
  return text;
}

TEST_F(ReportPage, LeadsWithVerdictPictureAndNextStepAndFoldsWhatExplainsNothing) {
  const auto library = folder_.write(
      "stub.js", "window.Plotly={react(){},Plots:{resize(){}}};/* plotly */" + std::string(200000, ' '));
  const auto shown = [&](const Session& session, const std::string& name) {
    return elementsOf(
        folder_.write(name, reportPage(contents(session, "s.bag", {EffectSpec("scale").set("axis", "x")}),
                                       loadReportFiles(library))));
  };
  const Session faulty = test::interferometerSession(2e-6, 0.1e-6),
                sound = test::interferometerSession(0.0, 0.1e-6);
  const std::string found = shown(faulty, "found.html");
  if (found.empty()) GTEST_SKIP() << "needs chromium";
  const auto at = [&](const char* what) {
    const std::size_t place = found.find(what);
    EXPECT_NE(place, std::string::npos) << what;
    return place;
  };
  const std::vector<std::size_t> order = {at("class=\"verdict "), at("class=\"lead-picture\""),
                                          at("id=\"step\""), at("id=\"error\""), at("id=\"positioning\"")};
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
  at("data-drawn=\"yes\"");
  at("Accuracy A↑");
  EXPECT_EQ(found.find("<details class=\"fold\" aria-labelledby=\"where\""), std::string::npos);
  const std::string nothing = shown(sound, "nothing.html");
  for (const char* section : {"where", "candidates", "limits", "points"})
    EXPECT_NE(nothing.find("<details class=\"fold\" aria-labelledby=\"" + std::string(section) + "\""),
              std::string::npos)
        << section;
}

/// Play and a drift: to predict drift from its neighbours is easier than to correct it.
Session driftingSession() {
  Session session = test::interferometerSession(2e-6, 0.1e-6);
  for (Observation& o : session.observations) o.deviation[0] += 1e-6 * std::sin(o.time / 120.0);
  return session;
}

TEST_F(ReportPage, HeldOutIsOneFigureInVerdictTableCardsAndLedger) {
  const Session session = driftingSession();
  const ReportContents report = contents(session, "s.bag", {EffectSpec("scale").set("axis", "x")});
  const std::vector<EffectSpec> added = effectsFound(report.diagnosis);
  ASSERT_FALSE(added.empty());
  const nlohmann::json data = nlohmann::json::parse(reportJson(report));
  const double before = data["figures"][2]["held_out_rms_um"], after = data["figures"][3]["held_out_rms_um"];
  char words[64];
  std::snprintf(words, sizeof(words), "eld-out RMS %.3g -> %.3g um", before, after);
  EXPECT_NE(data["diagnosis"]["sentence"].get<std::string>().find(words), std::string::npos)
      << words << " in: " << data["diagnosis"]["sentence"];
  EXPECT_NEAR(data["diagnosis"]["held_out_rms_with_found_um"], after, 1e-12);
  double now = before;
  for (const nlohmann::json& m : data["diagnosis"]["missing"]) {
    EXPECT_NEAR(m["held_out_rms_um"][0], now, 1e-12);
    now = m["held_out_rms_um"][1];
  }
  EXPECT_NEAR(now, after, 1e-12);
  // it is what the ledger will say when the proposed effects are added
  Calibration calibration = report.calibration;
  for (const EffectSpec& effect : added)
    calibration = addEffect(session, calibration, effect, {}).calibration;
  EXPECT_NEAR(calibration.ledger.back().heldOutAfter * 1e6, after, 1e-6 * after);
  EXPECT_NEAR(calibration.ledger.front().heldOutAfter * 1e6, before, 1e-6 * before);
  // and of mm diagnose, in its sentence and its text
  const Diagnosis alone = diagnoseCalibration(session, report.calibration, {});
  EXPECT_NEAR(alone.heldOutBefore * 1e6, before, 1e-9);
  EXPECT_NEAR(alone.heldOut * 1e6, after, 1e-9);
  EXPECT_NE(alone.sentence.find(words), std::string::npos) << words << " in: " << alone.sentence;
}

TEST_F(ReportPage, TheHeadSaysWhenWhatAndByWhom) {
  Session session = test::ballSession("b0", 3e-6, 0.2e-6);
  session.epoch = 1700000000.5;
  session.artifact.features[0].known = false;
  ReportContents report = contents(session, "s.bag");
  report.serial = "A-17";
  report.operatorName = "N. N.";
  const nlohmann::json data = nlohmann::json::parse(reportJson(report));
  EXPECT_EQ(data["measured"], "2023-11-14T22:13:20Z");
  EXPECT_EQ(data["title"], "three_axis, 2023-11-14");
  EXPECT_EQ(data["serial"], "A-17");
  EXPECT_EQ(data["operator"], "N. N.");
  ASSERT_EQ(data["features"].size(), 1u);  // nominal beside actual
  EXPECT_NEAR(data["features"][0]["nominal_mm"][1].get<double>(), 10.0, 1e-9);
  EXPECT_NEAR(data["features"][0]["actual_mm"][1].get<double>(), 10.0, 0.01);
  EXPECT_GT(data["features"][0]["std_um"][1].get<double>(), 0.0);
  session.epoch = 1000000000.0;  // what an import without a date has
  EXPECT_TRUE(nlohmann::json::parse(reportJson(report))["measured"].is_null());
  EXPECT_EQ(nlohmann::json::parse(reportJson(report))["title"], "three_axis");
  InputCoverage air{"air", "degC", true}, bed{"bed", "degC", true}, humidity{"humidity", "percent", false};
  air.lower = 20.04, air.upper = 20.5, bed.lower = 21.0, bed.upper = 23.26;
  humidity.lower = 40.0, humidity.upper = 50.0;
  report.pointSet.inputs = {air, bed, humidity};
  EXPECT_EQ(nlohmann::json::parse(reportJson(report))["title"], "three_axis, 20.0 to 23.3 °C");
  EXPECT_NE(reportPage(report, loadReportFiles(plotly_)).find("<title>three_axis, 20.0 to 23.3 °C – "),
            std::string::npos);
}

/// What each parameter is stands beside its name.
TEST_F(ReportPage, ParametersSayWhatTheyAre) {
  const Session session = test::interferometerSession(2e-6, 0.1e-6);
  const ReportContents report = contents(session, "s.bag", {EffectSpec("backlash").set("axis", "x")});
  const nlohmann::json data = nlohmann::json::parse(reportJson(report));
  EXPECT_EQ(data["parameters"][0]["values"][0]["meaning"],
            "difference between the two directions of travel (mean reversal error with the opposite sign)");
  EXPECT_EQ(data["weak"], nlohmann::json::array());  // as mm calibrate says
}

TEST_F(ReportPage, LoadsNothing) {
  const ReportFiles files = loadReportFiles(plotly_);
  for (const std::string& text : {files.html, files.css, files.js})
    for (const char* loader : {"src=\"", "@import", "url(", "fetch(", "http://", "https://"})
      EXPECT_EQ(text.find(loader), std::string::npos) << loader;
  EXPECT_NE(files.html.find("default-src 'none'"), std::string::npos);
}

TEST_F(ReportPage, AMissingOrBrokenPlotlySaysWhatToDo) {
  const std::string missing = test::messageOf<InputError>([&] { loadReportFiles(folder_.path("none.js")); });
  EXPECT_NE(missing.find("none.js"), std::string::npos);
  EXPECT_NE(missing.find("npm pack plotly.js-dist-min@"), std::string::npos);
  const auto broken = folder_.write("broken.js", "plotly");
  EXPECT_NE(test::messageOf<InputError>([&] { loadReportFiles(broken); }).find("6 bytes"), std::string::npos);
}

TEST_F(ReportPage, ASessionThatCannotBeFittedStillGivesAPage) {
  const Session whole = test::interferometerSession(2e-6, 0.1e-6);
  ReportContents report = contents(whole, "s.bag");
  report.diagnosis = Diagnosis();
  report.diagnosis.verdict = Verdict::kInsufficientData;
  report.diagnosis.sentence = "The model cannot be fitted to this session.";
  const nlohmann::json data = nlohmann::json::parse(reportJson(report));
  EXPECT_EQ(data["diagnosis"]["verdict"], "insufficient_data");
  EXPECT_TRUE(data["figures"].empty());
  EXPECT_EQ(data["command"], "");
}

TEST(ReportCurve, ReadsWhatCalibrateWrites) {
  const test::Folder folder;
  const ConvergenceCurve curve =
      readConvergenceCurve(folder.write("c.csv", "generation,rms_um\n0,9.5\n1,2.25\n"));
  EXPECT_EQ(curve.name, "c.csv");
  EXPECT_FALSE(curve.angular);
  EXPECT_EQ(curve.rms, (std::vector<double>{9.5, 2.25}));
}

TEST(ReportCurve, RefusesOtherFilesByLine) {
  const test::Folder folder;
  const auto message = [&](const std::string& text) {
    return test::messageOf<InputError>([&] { readConvergenceCurve(folder.write("c.csv", text)); });
  };
  EXPECT_NE(message("time,rms\n").find("line 1"), std::string::npos);
  EXPECT_NE(message("generation,rms_um\n0,1\n1,many\n").find("line 3: '1,many'"), std::string::npos);
  EXPECT_NE(message("generation,rms_um\n").find("least_squares"), std::string::npos);
}

TEST_F(ReportPage, AnRmsHasTheUncertaintyOfSoManyMeasurements) {
  const Session session = test::interferometerSession(2e-6, 0.1e-6);
  const ReportContents report = contents(session, "s.bag");
  const nlohmann::json data = nlohmann::json::parse(reportJson(report));
  for (const nlohmann::json& figure : data["figures"]) {
    const double rms = figure["rms_um"], dof = figure["degrees_of_freedom"];
    EXPECT_NEAR(figure["rms_std_um"], rms / std::sqrt(2.0 * dof), 1e-9) << figure["name"];
    EXPECT_EQ(figure["count_um"], 90);
  }
}

}  // namespace
}  // namespace mm
