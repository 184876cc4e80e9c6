// A certificate says what it must, takes names as data, and is refused when a byte of it was changed.
#include "report/certificate.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "compensation_support.h"
#include "model/model_spec.h"
#include "report/certificate_plots.h"
#include "report/certificate_seal.h"
#include "report/uncertainty_output.h"
#include "session_files.h"

namespace mm {
namespace {

Certificate exampleCertificate() {
  Certificate c;
  c.calibration = test::calibrationOf(Machine::load("three_axis"),
                                      {parseEffectSpec("{type: scale, axis: x}", "effect"),
                                       parseEffectSpec("{type: backlash, axis: y}", "effect")});
  c.calibration.id = "20260301T093000Z-00c0ffee";
  c.calibration.domain.tipLower = Eigen::Vector3d::Constant(-0.02);
  c.calibration.domain.tipUpper = Eigen::Vector3d::Constant(0.02);
  c.calibration.values[0].value = 123.4e-6;
  c.calibration.values[0].std = 2e-6;
  c.calibration.covariance(0, 0) = 4e-12;
  c.calibration.artifact = CalibratedBy{"plate <no. 7>", 9, false, 1e-3, 0.05, 0.2e-6, 0.0};
  c.calibration.rms = c.calibration.heldOutRms = c.calibration.repeatability = 0.3e-6;
  c.serial = "M-17";
  c.facts.operatorName = "E. Abbe";
  c.facts.traceability = "D-K-15070 & 2026";
  c.facts.issued = "2026-03-02T08:00:00Z";
  const Model model(Machine::load("three_axis"), c.calibration.domain, c.calibration.effects);
  const auto task = makeTask("distance:-10,0,0:10,0,0", {}, model);
  MonteCarloOptions options;
  options.trials = 5000;
  CertifiedTask stated;
  stated.result = taskUncertainty(*task, VirtualMachine(c.calibration, *task, {}), options);
  ToleranceAsked asked;
  asked.tolerance = 5e-6;
  stated.verdicts = verdictsOf(stated.result, asked);
  c.tasks.push_back(stated);
  c.curves = correctionCurves(c.calibration);
  return c;
}

TEST(Certificate, SaysWhatACertificateMust) {
  const Certificate c = exampleCertificate();
  const std::string page = certificatePage(c);
  for (const char* part :
       {"20260301T093000Z-00c0ffee", "M-17", "E. Abbe", "D-K-15070 &amp; 2026", "plate &lt;no. 7&gt;",
        "U = 0.4 µm (k = 2), in the results", "taken as exact", "distance:-10,0,0:10,0,0", "k = 2",
        "ISO 14253-1", "conforms", "scale of x", "repeatability of the probe", "18 to 26 °C", "<svg"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  EXPECT_EQ(page.find("<no. 7>"), std::string::npos);
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_EQ(page.find("http://"), std::string::npos);
  EXPECT_EQ(page.find("nan"), std::string::npos);
}

TEST(Certificate, TellsWhenItWasActiveAndWhatFreshPointsSaid) {
  const test::Folder folder;
  const CalibrationStore store(folder.path("store"));
  Certificate c = exampleCertificate();
  EXPECT_FALSE(storeRecord(store, c.calibration));
  EXPECT_NE(certificatePage(c).find("in no store of calibrations"), std::string::npos);
  Calibration earlier = c.calibration, foreign = c.calibration;
  earlier.id = "earlier";
  foreign.id = "foreign";
  foreign.machineName = "another";
  CalibrationStore writer(folder.path("store"));
  for (Calibration* one : {&earlier, &foreign, &c.calibration}) {
    one->created = "2026-03-01T09:30:00Z";
    writer.add(*one);
  }
  writer.promote("foreign");
  writer.promote("earlier");
  writer.promote(c.calibration.id);
  store.note({"2999-01-01T00:00:00Z", c.calibration.id, "no_change", 3.12e-6, 3.1e-6, 0.04e-6, 0.03e-6, false,
              54, "fresh a.bag"});
  writer.rollback();
  EXPECT_THROW(store.note({"", "unknown", "helped", 0, 0, 0, 0, false, 1, ""}), InputError);
  c.store = storeRecord(store, c.calibration);
  ASSERT_TRUE(c.store);
  EXPECT_FALSE(c.store->active);
  ASSERT_EQ(c.store->events.size(), 4U);  // of three promotions the foreign one is left out
  EXPECT_EQ(c.store->events[0].id, "earlier");
  EXPECT_EQ(c.store->events[0].until, c.store->events[1].time);
  EXPECT_EQ(c.store->events[1].id, c.calibration.id);
  EXPECT_EQ(c.store->events[2].what, "made active again");
  EXPECT_EQ(c.store->events[2].until, "");
  EXPECT_EQ(c.store->events[3].what,
            "verified: no change, 3.12 ± 0.08 → 3.1 ± 0.06 um (k = 2) at 54 points (fresh a.bag)");
  const std::string page = certificatePage(c);
  for (const char* part : {"History of use", "<b>not active</b>", "this one", "made active again", "today",
                           "no change, 3.12 ± 0.08 → 3.1 ± 0.06 µm (k = 2) at 54 points (fresh a.bag)"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  EXPECT_EQ(page.find("foreign"), std::string::npos);
}

// A session of angles: its residuals are arcseconds, and so is the drift of a rotary joint.
TEST(Certificate, AnglesAreNotCalledMicrometres) {
  Certificate c = exampleCertificate();
  Calibration& k = c.calibration;
  k.rms = k.heldOutRms = std::nan("");
  k.rmsAngular = k.heldOutRmsAngular = 13.8 * kArcsecond;
  k.repeatability = 1.25 * kArcsecond;
  LedgerEntry step;
  step.action = "add";
  step.rmsBefore = step.heldOutBefore = 13.8 * kArcsecond;
  step.rmsAfter = step.heldOutAfter = 1.0 * kArcsecond;
  k.ledger = {step, step};
  const std::string page = certificatePage(c);
  for (const char* part : {"RMS, arcsec", "held out, arcsec", "13.8 → 1<", "RMS 13.8 arcsec",
                           "repeatability 1.25 arcsec", "step of the calibration"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  EXPECT_EQ(page.find("66.9"), std::string::npos) << "13.8 arcsec are 66.9 urad, no micrometres";
}

TEST(Certificate, TheCorrectionOverAnAxisIsThatOfTheModel) {
  const std::vector<CorrectionCurve> curves = exampleCertificate().curves;
  ASSERT_EQ(curves.size(), 3U);
  EXPECT_EQ(curves[0].axis, "x");
  EXPECT_NEAR(curves[0].at.front(), -20.0, 1e-9);
  EXPECT_NEAR(curves[0].correction.back().x(), 20e3 * 123.4e-6, 1e-9);
  EXPECT_NEAR(curves[0].expanded.back().x(), 2.0 * 20e3 * 2e-6, 1e-6);
}

TEST(CertificateSeal, FindsEveryChange) {
  for (const std::string& content :
       {certificatePage(exampleCertificate()), std::string("%PDF-1.4\nbinary \0 bytes\n%%EOF\n", 29)}) {
    const std::string sealed =
        sealedCertificate(content, {"20260301T093000Z-00c0ffee", "0123456789abcdef", "feed", {}});
    const CertificateSeal seal = checkCertificate(sealed, "c");
    EXPECT_EQ(seal.calibration, "20260301T093000Z-00c0ffee");
    EXPECT_EQ(seal.checksum, "0123456789abcdef");
    EXPECT_EQ(seal.session, "feed");
    EXPECT_EQ(seal.sha256.size(), 64U);
    // A seal of before these were told.
    const CertificateSeal old = checkCertificate(sealedCertificate(content, {"old-one", "", "", ""}), "c");
    EXPECT_EQ(old.calibration, "old-one");
    EXPECT_EQ(old.checksum + old.session, "");
    for (std::size_t at = 0; at < sealed.size(); at += 1 + sealed.size() / 97) {
      std::string tampered = sealed;
      tampered[at] = static_cast<char>(tampered[at] ^ 1);
      EXPECT_THROW(checkCertificate(tampered, "c"), InputError) << at;
    }
    EXPECT_THROW(checkCertificate(sealed + "more", "c"), InputError);
    EXPECT_THROW(checkCertificate(sealed.substr(0, sealed.size() / 2), "c"), InputError);
    EXPECT_THROW(checkCertificate(content, "c"), InputError);
  }
  EXPECT_EQ(sha256Of("abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");  // FIPS 180-2, B.1
}

TEST(CertificatePlots, ShowRoundMarksAndNothingWithoutPoints) {
  const std::string svg =
      svgPlot("x, mm", "µm", {{"a", "#000", {-20.0, 20.0}, {-2.5, 2.5}, {0.1, 0.1}, false}});
  for (const char* mark : {">-20<", ">0<", ">20<", "<polygon"})
    EXPECT_NE(svg.find(mark), std::string::npos) << mark;
  EXPECT_TRUE(svgPlot("x", "y", {}).empty());
  EXPECT_TRUE(historyPlot({}, false).empty());
}

TEST(UncertaintyJson, HasTheKeysOfTheCommand) {
  const Certificate c = exampleCertificate();
  const auto json =
      nlohmann::json::parse(uncertaintyJson(c.tasks[0].result, c.tasks[0].verdicts, c.calibration));
  EXPECT_EQ(json["task"], "distance:-10,0,0:10,0,0");
  EXPECT_NEAR(json["mean_mm"].get<double>(), 20.0, 1e-4);
  EXPECT_NEAR(json["k2_um"].get<double>(), 2.0 * json["std_um"].get<double>(), 1e-12);
  double sum = 0.0;
  for (const auto& share : json["budget"]) {
    EXPECT_TRUE(share["source"].is_string());
    sum += share["share"].get<double>();
  }
  EXPECT_NEAR(sum, 1.0, 1e-9);
  EXPECT_EQ(json["decisions"][0]["verdict"], "conforms");
  EXPECT_TRUE(json["valid"].get<bool>());
  EXPECT_EQ(millimetres(0.0123456789, 0.46e-6), "12.34568");
}

}  // namespace
}  // namespace mm
