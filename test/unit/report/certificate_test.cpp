// A certificate says what it must, takes names as data, and is refused where its content is not that of its
// checksum.
#include "report/certificate.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "compensation_support.h"
#include "model/model_spec.h"
#include "report/certificate_figures.h"
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
  c.number = c.calibration.id + "-20260302T080000123Z-1";
  c.checksum = "0123456789abcdef";
  c.facts.serial = "M-17";
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
        "ISO 14253-1", "Predicted, no test was made: distance: predicted to keep the limit; ",
        "2 s of the fit; reference not included", "scale of x (EXX)", "w-b-X-Y-Z-t", "bidirectional: Y; ",
        "repeatability of the probe", "18 to 26 °C", "<svg"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  EXPECT_EQ(page.find("<no. 7>"), std::string::npos);
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_EQ(page.find("http://"), std::string::npos);
  EXPECT_EQ(page.find("nan"), std::string::npos);
  // Nothing conforms that nobody measured.
  EXPECT_EQ(page.find("verdict conforms"), std::string::npos);
  EXPECT_EQ(page.find(": conforms"), std::string::npos);
  Certificate stated = c;
  stated.calibration.artifact->radiusStd = 0.1e-6;
  EXPECT_EQ(certificatePage(stated).find("reference not included"), std::string::npos);
}

TEST(Certificate, AMeasuredValueConformsAsItsIssuerStatesIt) {
  Certificate c = exampleCertificate();
  ToleranceAsked asked;
  asked.tolerance = 100e-6;
  asked.measured = 20e-3;
  c.tasks[0].verdicts = verdictsOf(c.tasks[0].result, asked);
  const std::string page = certificatePage(c);
  for (const char* part :
       {"verdict conforms", "Of the measured value that the issuer states: distance: conforms; "})
    EXPECT_NE(page.find(part), std::string::npos) << part;
}

// The largest of many errors is not symmetric about its mean: its interval says more than a U.
TEST(Certificate, OneSidedFiguresHaveAnInterval) {
  Certificate c = exampleCertificate();
  QuantityUncertainty& q = c.tasks[0].result.quantities[0];
  q.quantity.oneSided = true;
  q.mean = 1.2e-6;
  q.std = 0.3e-6;
  q.lower = 0.9e-6;
  q.upper = 2.0e-6;
  const StatedFigure figure = taskFigures(c.tasks[0]).figures.at(0);
  EXPECT_EQ(figure.value, "1.20");
  EXPECT_EQ(figure.expanded, "");
  EXPECT_EQ(figure.standard, "0.30");
  EXPECT_NE(certificatePage(c).find("95 %: 0.90 … 2.00"), std::string::npos);
}

TEST(Certificate, PrintsWhatWasTypedAsItIs) {
  Certificate c = exampleCertificate();
  c.facts.remark = "5 um of degC";
  c.calibration.sessionSource = "a um.bag";
  const std::string page = certificatePage(c);
  for (const char* part : {"5 um of degC", "a um.bag"}) EXPECT_NE(page.find(part), std::string::npos) << part;
}

TEST(Certificate, NamesWhatTheIssuerStatedToChangeU) {
  Certificate c = exampleCertificate();
  c.conditions.repeatability = 0.1e-6;
  c.conditions.margin = 0.5;
  c.conditions.temperatures = {{c.calibration.domain.sensors.at(0), 21.5, 0.2}};
  c.conditions.travel = {{"x", -1.0}};
  c.points = 25;
  const std::string page = certificatePage(c);
  for (const char* part :
       {"0.100 µm, stated by the issuer; calibration: 0.300 µm", "50 %, stated by the issuer; usual: 10 %",
        "21.50 °C, standard uncertainty 0.2 K, stated by the issuer; middle of the calibrated range: 22.00 "
        "°C",
        "-1, stated by the issuer; usual: +1", "25, stated by the issuer", "<td>5 s</td>"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  EXPECT_EQ(certificatePage(exampleCertificate()).find("stated by the issuer; "), std::string::npos);
}

TEST(Certificate, IsARecordWhereItDoesNotSayAll) {
  Certificate c = exampleCertificate();
  std::string page = certificatePage(c);
  for (const char* part :
       {"<h1>Record of calibration</h1>", "<th>Date of measurement</th><td>not recorded</td>",
        "Authorised by: not stated", "The results relate only to the item calibrated."})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  c.facts.laboratory = "L & Co";
  c.facts.customer = "The customer";
  c.facts.authorisedBy = "C. Zeiss";
  c.calibration.sessionEpoch = 1767225600.0;
  c.calibration.artifact->serial = "P-4";
  page = certificatePage(c);
  for (const char* part :
       {"<h1>Calibration certificate</h1>", "<th>Date of measurement</th><td>2026-01-01T00:00:00Z</td>",
        "Authorised by: C. Zeiss", "<th>Serial number of the artifact</th><td>P-4</td>"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  c.facts.traceability = "unknown";
  EXPECT_NE(certificatePage(c).find("<h1>Record of calibration</h1>"), std::string::npos);
}

TEST(Certificate, OfASimulationIsNone) {
  Certificate c = exampleCertificate();
  c.calibration.artifact->radiusStd = 0.1e-6;
  EXPECT_EQ(certificatePage(c).find("SIMULATED"), std::string::npos);
  c.calibration.sessionOrigin = "simulated";
  decideConformity(c);
  EXPECT_TRUE(c.tasks[0].verdicts.empty());
  EXPECT_EQ(c.tasks[0].noConformity, std::vector<std::string>{"the session is simulated"});
  const std::string page = certificatePage(c);
  for (const char* part : {"<p class=\"verdict fails\">SIMULATED: not a calibration of a machine",
                           "content: \"Record of calibration, SIMULATED: not a calibration of a machine"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
}

TEST(Certificate, SaysWhetherTheModelLeavesMoreThanTheRepeatability) {
  Certificate c = exampleCertificate();
  c.calibration.repeatabilityFrom = "declared";
  c.calibration.chi2PerDof = 9.0;
  const char* const kRemain = "errors that this model does not describe remain";
  EXPECT_NE(certificatePage(c).find(std::string("3.0 times the repeatability: ") + kRemain),
            std::string::npos);
  c.calibration.chi2PerDof = 1.0;
  EXPECT_EQ(certificatePage(c).find(kRemain), std::string::npos);
  c.calibration.chi2PerDof = 9.0;
  c.calibration.repeatabilityFrom = "estimated";
  EXPECT_EQ(certificatePage(c).find(kRemain), std::string::npos) << "of what is left itself";
}

TEST(Certificate, TellsWhenItWasActiveAndWhatFreshPointsSaid) {
  const test::Folder folder;
  const CalibrationStore store(folder.path("store"));
  Certificate c = exampleCertificate();
  EXPECT_FALSE(storeRecord(store, c.calibration));
  EXPECT_NE(certificatePage(c).find("not in a named store of calibrations"), std::string::npos);
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
            "compared with fresh points: no change, 3.12 ± 0.08 → 3.1 ± 0.06 µm (k = 2) at 54 points (fresh "
            "a.bag)");
  const std::string page = certificatePage(c);
  for (const char* part : {"History of use", "<b>not active</b>", "this one", "made active again", "today",
                           "no change, 3.12 ± 0.08 → 3.1 ± 0.06 µm (k = 2) at 54 points (fresh a.bag)"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  EXPECT_EQ(page.find("foreign"), std::string::npos);
}

// Forty points a plot would show a wave of 2 mm over 491 mm as another one.
TEST(Certificate, CurvesFollowShortWaves) {
  Calibration k =
      test::calibrationOf(Machine::load("three_axis"),
                          {parseEffectSpec("{type: lead_screw_periodic, axis: x, period_mm: 2}", "effect")});
  k.domain.lower[0] = 2.0e-3;
  k.domain.upper[0] = 493.0e-3;
  k.values[0].value = 1e-6;  // S
  const std::vector<CorrectionCurve> curves = correctionCurves(k);
  ASSERT_FALSE(curves.empty());
  const CorrectionCurve& x = curves.front();
  ASSERT_EQ(x.axis, "x");
  int turns = 0;
  for (std::size_t i = 1; i + 1 < x.at.size(); ++i)
    turns +=
        (x.correction[i].x() - x.correction[i - 1].x()) * (x.correction[i + 1].x() - x.correction[i].x()) <
        0.0;
  EXPECT_NEAR(turns, 2 * 491.0 / 2.0, 2.0) << "a crest and a trough each 2 mm";
  EXPECT_LT(correctionPlot(x).size(), 300000U) << "no more than a plot can show";
}

TEST(Certificate, RoundingOfAConstantCurveIsNoCurve) {
  Calibration k = test::calibrationOf(Machine::load("three_axis"),
                                      {parseEffectSpec("{type: backlash, axis: y}", "effect")});
  k.values[0].value = 3e-6;
  const std::vector<CorrectionCurve> curves = correctionCurves(k);
  ASSERT_FALSE(curves.empty());
  for (const CorrectionCurve& curve : curves) EXPECT_LE(curve.at.size(), 41U) << curve.axis;
}

TEST(Certificate, StatesNoTimesThatNobodyRecorded) {
  Certificate c = exampleCertificate();
  c.calibration.domain.duration = 0.0;
  c.calibration.drift = {{"x", 0.5e-6, 210.0, false}};
  const std::string page = certificatePage(c);
  EXPECT_EQ(page.find("time constant"), std::string::npos);
  EXPECT_NE(page.find("no times were recorded"), std::string::npos);
  EXPECT_NE(page.find("not recorded"), std::string::npos);
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
  for (const char* part :
       {"before and after each step, in arcsec", "<td class=\"n\">13.8</td><td class=\"n\">1</td>",
        "<td>RMS</td><td class=\"n\">13.8</td><td class=\"n\">informative, without uncertainty</td>",
        "<td class=\"n\">1.25</td><td class=\"n\">informative, without uncertainty</td><td>arcsec</td>",
        "step of the calibration"})
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
        sealedCertificate(content, {"20260301T093000Z-00c0ffee", "id-1", "0123456789abcdef", "feed", {}});
    const CertificateSeal seal = checkCertificate(sealed, "c");
    EXPECT_EQ(seal.calibration, "20260301T093000Z-00c0ffee");
    EXPECT_EQ(seal.number, "id-1");
    EXPECT_EQ(seal.checksum, "0123456789abcdef");
    EXPECT_EQ(seal.session, "feed");
    EXPECT_EQ(seal.sha256.size(), 64U);
    // A seal of before these were told.
    const CertificateSeal old =
        checkCertificate(sealedCertificate(content, {"old-one", "", "", "", ""}), "c");
    EXPECT_EQ(old.calibration, "old-one");
    EXPECT_EQ(old.number + old.checksum + old.session, "");
    for (std::size_t at = 0; at < sealed.size(); at += 1 + sealed.size() / 97) {
      std::string tampered = sealed;
      tampered[at] = static_cast<char>(tampered[at] ^ 1);
      EXPECT_THROW(checkCertificate(tampered, "c"), InputError) << at;
    }
    // It says what it knows: not who changed it, nor when.
    const std::string refused = test::messageOf<InputError>([&] { checkCertificate("x" + sealed, "c"); });
    EXPECT_NE(refused.find("does not match its checksum"), std::string::npos) << refused;
    EXPECT_THROW(checkCertificate(sealed + "more", "c"), InputError);
    EXPECT_THROW(checkCertificate(sealed.substr(0, sealed.size() / 2), "c"), InputError);
    EXPECT_THROW(checkCertificate(content, "c"), InputError);
  }
  EXPECT_EQ(sha256Of("abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");  // FIPS 180-2, B.1
}

// Where the reference's uncertainty is not stated, nothing conforms, and the line that would state it is
// named.
TEST(CertificateConformity, NeedsTheUncertaintyOfTheReference) {
  Certificate c = exampleCertificate();
  CalibratedBy& a = *c.calibration.artifact;
  TaskConditions conditions;
  const auto missing = [&] { return uncertaintyNotStated(c.calibration, conditions, true); };
  a.centreStd = a.radiusStd = 0.0;
  ASSERT_EQ(missing().size(), 2U);
  EXPECT_NE(missing()[0].find("centre_std_um"), std::string::npos) << missing()[0];
  EXPECT_NE(missing()[1].find("radius_std_um"), std::string::npos) << missing()[1];
  a.centreStd = 0.2e-6;
  EXPECT_EQ(missing().size(), 1U);
  a.radiusStd = 0.1e-6;
  EXPECT_TRUE(missing().empty());
  // One ball that was taken as exact.
  FoundInArtifact ball{"b0", true, false, {}, Eigen::Vector3d::Constant(0.2e-6), 4e-3, 0.1e-6}, exact = ball;
  exact.name = "b1";
  exact.std.setZero();
  a.found = {ball, exact};
  ASSERT_EQ(missing().size(), 1U);
  EXPECT_NE(missing()[0].find("of b1 "), std::string::npos) << missing()[0];
  conditions.artifactScale = 1e-6;
  EXPECT_TRUE(missing().empty());
  // A scale says nothing of the squareness of a plate.
  ASSERT_EQ(uncertaintyNotStated(c.calibration, conditions, false).size(), 1U);
  EXPECT_EQ(uncertaintyNotStated(c.calibration, conditions, false)[0].find("--artifact-scale-um-m"),
            std::string::npos);
  // Points have no radius.
  a.found[0].ball = a.found[1].ball = false;
  a.radiusStd = a.centreStd = 0.0;
  conditions.artifactScale = 0.0;
  ASSERT_EQ(missing().size(), 1U);
  EXPECT_NE(missing()[0].find("position_std_um"), std::string::npos) << missing()[0];
  // An instrument, and a file that does not tell.
  a.features = 0;
  EXPECT_NE(missing().at(0).find("--artifact-scale-um-m"), std::string::npos);
  c.calibration.artifact.reset();
  EXPECT_EQ(missing().size(), 1U);
  conditions.artifactScale = 1e-6;
  EXPECT_TRUE(missing().empty());

  c.conditions.artifactScale = 1e-6;
  c.tasks[0].noConformity = {"the uncertainty of <this> is not stated"};
  c.tasks[0].asked = true;
  c.tasks[0].verdicts.clear();
  const std::string page = certificatePage(c);
  EXPECT_NE(page.find("No statement of conformity: the uncertainty of &lt;this&gt;"), std::string::npos);
  EXPECT_EQ(page.find("predicted to keep the limit"), std::string::npos);
  EXPECT_NE(page.find("U = 2 µm/m (k = 2), stated for the predicted results"), std::string::npos);
}

TEST(CertificateConformity, NeedsAModelAndACalibrationThatHold) {
  const auto why = [](const Certificate& made) {
    Certificate c = made;
    c.calibration.artifact->radiusStd = 0.1e-6;
    decideConformity(c);
    EXPECT_EQ(c.tasks[0].verdicts.empty(), !c.tasks[0].noConformity.empty());
    return c.tasks[0].noConformity;
  };
  const Certificate c = exampleCertificate();
  EXPECT_EQ(why(c).size(), 0U);
  Certificate leaves = c;
  leaves.calibration.repeatabilityFrom = "declared";
  leaves.calibration.chi2PerDof = 9.0;
  ASSERT_EQ(why(leaves).size(), 1U);
  EXPECT_EQ(why(leaves)[0], "the model leaves 3.0 times the repeatability");
  Certificate outside = c;
  outside.tasks[0].result.outside = {"at 30 degC"};
  ASSERT_EQ(why(outside).size(), 1U);
  EXPECT_EQ(why(outside)[0], "the calibration does not hold at 30 degC");
}

// Every table has figures of one origin, and every figure is in one.
TEST(CertificateFigures, MeasuredAndPredictedAreNeverInOneTable) {
  Certificate c = exampleCertificate();
  c.session.emplace();
  c.session->path = "s.bag";
  c.session->uncorrected = 9.87e-6;
  c.session->corrected = 0.654e-6;
  const std::string page = certificatePage(c);
  const auto tableOf = [&](const std::string& cell) {
    const std::size_t at = page.find(">" + cell + "<"), head = page.rfind("<thead>", at);
    EXPECT_NE(at, std::string::npos) << cell;
    return page.substr(head, page.find("</table>", at) - head);
  };
  for (const auto& [cell, origin] : {std::pair<const char*, const char*>{"9.87", "Value, measured<"},
                                     {"0.654", "Value, calculated, not measured<"},
                                     {"123.4", "Value, estimated from the measurements<"},
                                     {"distance", "Value, predicted, not measured<"}}) {
    const std::string table = tableOf(cell);
    EXPECT_NE(table.find(origin), std::string::npos) << cell << ": " << table;
    std::size_t heads = 0;
    for (std::size_t at = table.find("Value, "); at != std::string::npos; at = table.find("Value, ", at + 1))
      ++heads;
    EXPECT_EQ(heads, 1U) << table;
  }
  EXPECT_EQ(page.find("→"), std::string::npos);
}

// The plot of a test shows the table's figures: its highest mark is the table's largest sum, and nothing
// printed lies above its scale.
TEST(CertificateFigures, PlotAndTableAreOfOneSource) {
  const Certificate c = exampleCertificate();
  const Model model(Machine::load("three_axis"), c.calibration.domain, c.calibration.effects);
  const auto task = makeTask("iso10360-2", {}, model);
  MonteCarloOptions options;
  options.trials = 2000;
  CertifiedTask stated;
  stated.result = taskUncertainty(*task, VirtualMachine(c.calibration, *task, {}), options);
  const LengthTable table = lengthTable(stated.result);
  ASSERT_EQ(table.rows.size(), 35U);
  const std::string plot = lengthsPlot(table);
  double highest = 1e9, lowest = -1e9;
  std::string title;
  std::size_t marks = 0;
  for (std::size_t at = plot.find("<circle "); at != std::string::npos;
       at = plot.find("<circle ", at + 1), ++marks) {
    const std::size_t y = plot.find("cy=\"", at) + 4, text = plot.find("<title>", at) + 7;
    const double pixel = std::stod(plot.substr(y));
    lowest = std::max(lowest, pixel);
    if (pixel >= highest) continue;
    highest = pixel;
    title = plot.substr(text, plot.find("</title>", text) - text);
  }
  EXPECT_EQ(marks, table.rows.size());
  const std::string& largest = table.rows[table.largest].sumText;
  EXPECT_EQ(title.substr(title.rfind(": ") + 2), largest + " µm");
  for (const LengthRow& row : table.rows) {
    EXPECT_LE(row.sum, table.rows[table.largest].sum);
    EXPECT_LE(row.sum, table.least.at(row.length) + 1e-9);
    EXPECT_NEAR(std::stod(row.sumText), std::abs(std::stod(row.error.value)) + std::stod(row.error.expanded),
                1e-9);
  }
  Certificate whole = c;
  whole.tasks = {stated};
  const std::string page = certificatePage(whole);
  EXPECT_NE(page.find("<b>" + largest + "</b>"), std::string::npos);
  EXPECT_NE(page.find("Largest |E| + U of a length: " + largest + " µm"), std::string::npos);
  // The expected largest |E| of the test is drawn, too: its line is a polyline of the plot's last series.
  EXPECT_GT(table.wholeTest, 0.0);
  const double over = std::stod(plot.substr(plot.find(',', plot.rfind("<polyline points=\"")) + 1));
  const double perMicrometre =
      (lowest - highest) /
      (table.rows[table.largest].sum -
       std::min_element(table.rows.begin(), table.rows.end(), [](const LengthRow& a, const LengthRow& b) {
         return a.sum < b.sum;
       })->sum);
  EXPECT_NEAR(highest - over, (table.wholeTest - table.rows[table.largest].sum) * perMicrometre,
              0.1 * std::abs(highest - over) + 2.0);
}

TEST(CertificateIssue, HasANumberOfItsOwn) {
  const IssueNumber first{"20260301T093000Z-00c0ffee", "20260302T080000123Z", 1};
  EXPECT_EQ(first.text(), "20260301T093000Z-00c0ffee-20260302T080000123Z-1");
  const IssueNumber read = IssueNumber::parsed(first.text());
  EXPECT_EQ(read.calibration, first.calibration);
  EXPECT_EQ(read.stamp, first.stamp);
  EXPECT_EQ(read.count, 1);
  for (const char* none :
       {"", "20260301T093000Z-00c0ffee", "id-20260302T080000123Z-0", "id-20260302T080000Z-1"})
    EXPECT_EQ(IssueNumber::parsed(none).count, 0) << none;
  EXPECT_EQ(IssueNumber::parsed(IssueNumber{"id", issueStamp(), 12}.text()).count, 12);

  Certificate c = exampleCertificate();
  c.number = first.text();
  EXPECT_EQ(certificatePage(c).find("Replaces"), std::string::npos);
  c.replaces = "id-of-the-first";
  const std::string page = certificatePage(c);
  EXPECT_NE(page.find("No. " + first.text()), std::string::npos);
  EXPECT_NE(page.find("certificate No. id-of-the-first"), std::string::npos);
}

TEST(CertificateIssue, IsCountedInTheStore) {
  const test::Folder folder;
  CalibrationStore store(folder.path("store"));
  Certificate c = exampleCertificate();
  EXPECT_THROW(store.noteIssue({"20260302T080000123Z", c.calibration.id, "paper", 0}), InputError);
  c.calibration.created = "2026-03-01T09:30:00Z";
  store.add(c.calibration);
  const std::string& id = c.calibration.id;
  EXPECT_EQ(store.noteIssue({"20260302T080000123Z", id, "paper", 0}), 1);
  EXPECT_EQ(store.noteIssue({"20260302T080000124Z", id, "digital", 0}), 2);
  EXPECT_EQ(store.noteIssue({"20260302T080000125Z", id, "paper", 7}), 7);
  const auto issues = store.issues();
  ASSERT_EQ(issues.size(), 3U);
  EXPECT_EQ(issues[1].form, "digital");
  EXPECT_EQ(issues[2].count, 7);
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
