// The disk fails at the n-th read or write, once or from then on: nothing that was there is lost, what is
// said to be written is whole, and a refusal is one line. Every n of every command that writes a file.
#include "failing_disk.h"

#include <algorithm>
#include <regex>

namespace mm {
namespace {

namespace fs = std::filesystem;

/// A certificate without its number and that of the one that it replaces, which depend on what was there.
std::string withoutNumber(const std::string& text) {
  static const std::regex number(
      "-[0-9]{8}T[0-9]{9}Z-[0-9]+"
      "|<tr><th>Replaces</th><td>[^<]*</td></tr>\n"
      "|[ \n]{0,40}<dcc:reportAmendedSubstituted>[^/]*/[^/]*/[^/]*/dcc:reportAmendedSubstituted>");
  return std::regex_replace(text, number, "");
}

/// Whether a file is what the command writes when nothing fails, but for the time that stands in it.
bool sameBut(const std::string& name, const std::string& foundFile, const std::string& wantedFile) {
  const std::string kind = fs::path(name).extension().string();
  const bool certificate = kind == ".html" || kind == ".pdf" || kind == ".xml";
  const std::string found = certificate ? withoutNumber(foundFile) : foundFile,
                    wanted = certificate ? withoutNumber(wantedFile) : wantedFile;
  const auto endsAs = [&](const std::string& end) {
    const std::size_t at = found.rfind(end);
    return at != std::string::npos && found.size() - at == wanted.size() - wanted.rfind(end);
  };
  // Of a page: its end, and its length but for a few digits.
  const std::size_t longer = std::max(found.size(), wanted.size()),
                    shorter = std::min(found.size(), wanted.size());
  const bool asLong = longer - shorter <= 8;
  // what the browser of this test prints is the page
  if (kind == ".html" || kind == ".pdf") return asLong && endsAs("</html>");
  return withoutTime(found) == withoutTime(wanted);
}

struct Writer {
  const char* name;
  const char* command;
  const char* before = "";  // writes the outputs that it finds; empty: itself
};

void PrintTo(const Writer& writer, std::ostream* out) { *out << "mm " << writer.command; }

/// What one command did on one broken disk.
struct Judged {
  Answer answer;
  std::map<std::string, std::string> old, found, wanted;

  void everyFileIsWhole() const {
    for (const auto& [name, text] : found) EXPECT_GT(wanted.count(name), 0u) << name << " was left behind";
    for (const auto& [name, text] : old) EXPECT_GT(found.count(name), 0u) << name << " is lost";
    for (const auto& [name, text] : found) {
      if (wanted.count(name) == 0) continue;
      const bool kept = old.count(name) > 0 && old.at(name) == text;
      const bool done = sameBut(name, text, wanted.at(name));
      EXPECT_TRUE(answer.status == 0 ? done : kept || done) << name << " is neither the old nor the new one";
    }
    if (answer.status != 0) return;
    for (const auto& [name, text] : wanted) EXPECT_GT(found.count(name), 0u) << name << " is not written";
  }
};

class FailingDiskTest : public FailingDisk, public ::testing::WithParamInterface<Writer> {
 protected:
  static void SetUpTestSuite() {
    FailingDisk::SetUpTestSuite();
    // What is read in several parts: half of this model is a model, too, but another one.
    folder_->write("long.yaml", "machine: three_axis\neffects:\n  - {type: scale, axis: x}\n" +
                                    std::string(200000, '#') + "\n  - {type: backlash, axis: x}\n");
    folder_->write("short.yaml", textOf("test/ros/short_plan.yaml"));
    const std::string rows = axisCsv(7);  // a fifth of them
    folder_->write("few.csv", rows.substr(0, rows.find("\n10,")) + "\n");
    run("import few.csv --machine three_axis -o few.bag");
    folder_->write("plotly.js", "// plotly\n" + std::string(150000, ' '));
    // A printer that prints a page by copying it.
    const std::string printer = folder_->write("weasyprint", "#!/bin/sh\nexec cat \"$2\" >\"$3\"\n");
    fs::permissions(printer, fs::perms::owner_all);
    path_ = std::getenv("PATH");
    ::setenv("PATH", (fs::path(printer).parent_path().string() + ":" + path_).c_str(), 1);
    run("promote t.yaml --store history");
    run("promote c.yaml --store history");
    untouched_ = files();
  }
  static void TearDownTestSuite() {
    ::setenv("PATH", path_.c_str(), 1);
    FailingDisk::TearDownTestSuite();
  }

  static inline std::map<std::string, std::string> untouched_;  // before any command
  static inline std::string path_;                              // without the printer
};

TEST_P(FailingDiskTest, NothingIsLostWhateverFailsAndWhenever) {
  const Writer& writer = GetParam();
  putBack(untouched_);
  run(*writer.before != '\0' ? writer.before : writer.command);
  const auto old = files();
  const Answer plain = typedOn({}, writer.command);
  ASSERT_LE(plain.status, 1) << plain.error;
  const int mostReads = reads(), mostWrites = writes();
  ASSERT_GT(mostReads, 0);
  ASSERT_GT(mostWrites, 3);
  const auto wanted = files();
  int runs = 0, refused = 0;
  for (const DiskFault& fault : faults(mostReads, mostWrites)) {
    SCOPED_TRACE(fault.inWords());
    putBack(fault.anew ? untouched_ : old);
    const Answer answer = typedOn(fault, writer.command);
    ++runs;
    // A trend goes on without a calibration that cannot be read, and names it.
    if (answer.status == plain.status && answer.error.find("warning: left out") != std::string::npos) {
      ++refused;
      EXPECT_EQ(std::count(answer.error.begin(), answer.error.end(), '\n'), 1) << answer.error;
      continue;
    }
    Judged{answer, fault.anew ? untouched_ : old, files(), wanted}.everyFileIsWhole();
    if (answer.status != plain.status) {
      ++refused;
      expectOneLine(answer, fault);
      EXPECT_GT(fault.n, 0) << "what is short or interrupted is taken up again";
    } else {
      EXPECT_EQ(withoutTime(answer.out), withoutTime(plain.out));
    }
    if (HasFailure()) return;
  }
  std::printf("%d reads, %d writes: %d runs, %d refused\n", mostReads, mostWrites, runs, refused);
  std::fflush(stdout);  // hours, where every n is asked
  EXPECT_GT(refused, 0);
}

INSTANTIATE_TEST_SUITE_P(
    Every, FailingDiskTest,
    ::testing::Values(
        Writer{"Import", "import s.csv --machine three_axis --artifact artifact.yaml -o out.bag"},
        Writer{"Simulate",
               "simulate --machine three_axis --plan short.yaml -o sim.bag --csv sim.csv --truth truth.yaml "
               "--force",
               "simulate --machine three_axis --plan short.yaml --seed 7 -o sim.bag --csv sim.csv --truth "
               "truth.yaml"},
        Writer{"CalibrateLinear", "calibrate s.bag --model long.yaml --method least_squares -o out.yaml"},
        Writer{"CalibrateGenetic",
               "calibrate s.bag --model m.yaml --generations 3 --population 20 -o ga.yaml --curve curve.csv"},
        Writer{"Add", "add s.bag --calibration c.yaml '{type: backlash, axis: x}' -o added.yaml"},
        Writer{"Remove", "remove s.bag --calibration c.yaml '{type: scale, axis: x}' -o removed.yaml"},
        Writer{"Report", "report few.bag --calibration c.yaml --plotly plotly.js -o report.html"},
        Writer{"Apply", "apply states.csv --calibration c.yaml -o corrected.csv",
               "apply states.csv --calibration t.yaml -o corrected.csv"},
        Writer{"Sensors", "sensors series.csv --target nose_um --picture picture.svg"},
        Writer{"NewMachine",
               "machine new --axis x=0:120mm --axis y=0:80mm -o new.urdf --model new_model.yaml --force",
               "machine new --axis x=0:90mm --axis y=0:80mm -o new.urdf --model new_model.yaml"},
        Writer{"NewPlan", "plan new --machine three_axis --balls 2x2 -o new_plan.yaml --force",
               "plan new --machine three_axis --balls 2x3 -o new_plan.yaml"},
        Writer{"VerificationPlan", "plan verify plan.yaml --calibration c.yaml -o fresh_plan.yaml --force",
               "plan verify plan.yaml --calibration c.yaml --places 4 -o fresh_plan.yaml"},
        mm_test::thoroughTests()
            ? Writer{"ExportLinuxCnc", "export c.yaml --to linuxcnc -o tables",
                     "export t.yaml --to linuxcnc -o tables"}
            : Writer{"ExportLinuxCnc", "export c.yaml --to linuxcnc --tables-alone -o tables",
                     "export t.yaml --to linuxcnc --tables-alone -o tables"},
        Writer{"ExportCsv", "export c.yaml --to csv -o numbers"},
        Writer{"CertificateHtml",
               "certificate c.yaml s.bag --serial 7 --task position:0,0,0 --trials 200 -o certificate.html"},
        Writer{"CertificatePdf",
               "certificate c.yaml --serial 7 --task position:0,0,0 --trials 200 -o certificate.pdf"},
        Writer{"CertificateXml",
               "certificate c.yaml --serial 7 --task position:0,0,0 --trials 200 -o certificate.xml"},
        Writer{"Trend", "history --store history --trend --plotly plotly.js -o trend.html"}),
    [](const ::testing::TestParamInfo<Writer>& info) { return info.param.name; });

}  // namespace
}  // namespace mm
