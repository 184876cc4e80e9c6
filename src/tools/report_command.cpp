#include <iostream>
#include <optional>

#include "calibration_file/calibration_yaml.h"
#include "report/report_page.h"
#include "tools/commands.h"
#include "tools/output_files.h"
#include "tools/progress_bar.h"
#include "tools/session_input.h"
#include "workflow/learning.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

struct ReportCommand {
  Bags bags;
  std::string calibration, output = "report.html", plotly;
  std::vector<std::string> curves;
  ReportOptions report;
  FitOptions fit;
  OutputFiles files;
};

void runReport(ReportCommand& c) {
  c.files.input(c.bags.paths);
  c.files.input({c.calibration, c.plotly});
  c.files.input(c.curves);
  c.files.output("-o", c.output, FileKind::kPage);
  c.files.check();
  const ReportFiles files = loadReportFiles(c.plotly);
  ReportOptions& options = c.report;
  options.diagnose = diagnosing(c.fit.checked());
  options.sessionPath = c.bags.joined();
  options.calibrationPath = c.calibration;
  for (const std::string& curve : c.curves) options.curves.push_back(readConvergenceCurve(curve));
  std::optional<Calibration> calibration;
  if (!c.calibration.empty()) calibration = loadCalibration(c.calibration);
  const Session session = calibration ? loadSession(c.bags.joined(), *calibration, c.fit.space)
                                      : loadSession(c.bags.joined(), nullptr, c.fit.space);
  if (!calibration) askFirst(session);
  const ReportContents report = withBar("diagnosing", options.diagnose, [&] {
    return calibration ? makeReport(session, *calibration, options) : makeReport(session, options);
  });
  c.files.write(c.output, reportPage(report, files));
  std::cout << reportSentence(report) << '\n';
  if (!calibration)
    for (const StandardTest& test : report.tests) std::cout << "  " << test.inWords << '\n';
  std::cout << "written to " << c.output << '\n';
}

}  // namespace

void addReportCommand(CLI::App& app, int& exitStatus) {
  auto [c, command] = addCommand<ReportCommand>(
      app, exitStatus, runReport, "report",
      "Write a self-contained HTML report of a session, with its calibration or without");
  c.bags.declare(command);
  command.add_option("--calibration", c.calibration,
                     "the calibration file; without it, the tests of the standards on the machine as it is");
  command.add_option("-o,--output", c.output, "the page")->capture_default_str();
  command.add_option("--curve", c.curves, "CSV of mm calibrate --curve; two curves are plotted side by side")
      ->expected(1, 2);
  command.add_option("--serial", c.report.serial, "serial number of the machine, for the page header");
  command.add_option("--operator", c.report.operatorName, "name of the operator, for the page header");
  command.add_option("--plotly", c.plotly, "path of plotly.min.js, if it was not fetched during the build");
  c.files.declare(command);
  c.fit.declare(command, true);
  command.footer(
      "The page needs no network connection.\n"
      "Example:\n"
      "  mm report plate.bag --calibration plate.yaml -o report.html");
}

}  // namespace mm
