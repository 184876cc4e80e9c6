// The disk fails at the n-th read or write, once or from then on: nothing that was there is lost, what is
// said to be written is whole, and a refusal is one line. Every n of every command that writes a file.
#include "failing_disk.h"

#include <algorithm>

namespace mm {
namespace {

namespace fs = std::filesystem;

using FailingDiskTest = FailingDisk;

/// Whether a file is what the command writes when nothing fails, but for the time that stands in it.
bool sameBut(const std::string& name, const std::string& found, const std::string& wanted) {
  const auto endsAs = [&](const std::string& end) {
    const std::size_t at = found.rfind(end);
    return at != std::string::npos && found.size() - at == wanted.size() - wanted.rfind(end);
  };
  // Of a page: its end, and its length but for a few digits.
  const std::size_t longer = std::max(found.size(), wanted.size()),
                    shorter = std::min(found.size(), wanted.size());
  const bool asLong = longer - shorter <= 8;
  const std::string kind = fs::path(name).extension().string();
  // what the browser of this test prints is the page
  if (kind == ".html" || kind == ".pdf") return asLong && endsAs("</html>");
  return withoutTime(found) == withoutTime(wanted);
}

struct Writer {
  const char* command;
  const char* before = "";  // writes the outputs that it finds; empty: itself
};

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

const std::vector<Writer>& writers() {
  static const std::vector<Writer> commands = {
      {"import s.csv --machine three_axis --artifact artifact.yaml -o out.bag"},
      {"simulate --machine three_axis --plan plan.yaml -o sim.bag --csv sim.csv --truth truth.yaml --force",
       "simulate --machine three_axis --plan plan.yaml --seed 7 -o sim.bag --csv sim.csv --truth truth.yaml"},
      {"calibrate s.bag --model long.yaml --method least_squares -o out.yaml"},
      {"calibrate s.bag --model m.yaml --generations 3 --population 20 -o ga.yaml --curve curve.csv"},
      {"add s.bag --calibration c.yaml '{type: backlash, axis: x}' -o added.yaml"},
      {"remove s.bag --calibration c.yaml '{type: scale, axis: x}' -o removed.yaml"},
      {"report s.bag --calibration c.yaml --plotly plotly.js -o report.html"},
      {"apply states.csv --calibration c.yaml -o corrected.csv",
       "apply states.csv --calibration t.yaml -o corrected.csv"},
      {"sensors series.csv --target nose_um --picture picture.svg"},
      {"machine new --axis x=0:120mm --axis y=0:80mm -o new.urdf --model new_model.yaml --force",
       "machine new --axis x=0:90mm --axis y=0:80mm -o new.urdf --model new_model.yaml"},
      {"plan new --machine three_axis --balls 2x2 -o new_plan.yaml --force",
       "plan new --machine three_axis --balls 2x3 -o new_plan.yaml"},
      {"plan verify plan.yaml --calibration c.yaml -o fresh_plan.yaml --force",
       "plan verify plan.yaml --calibration c.yaml --places 4 -o fresh_plan.yaml"},
      {"export c.yaml --to linuxcnc -o tables", "export t.yaml --to linuxcnc -o tables"},
      {"export c.yaml --to csv -o numbers"},
      {"certificate c.yaml s.bag --serial 7 --trials 1000 -o certificate.html"},
      {"certificate c.yaml --serial 7 --trials 1000 -o certificate.pdf"},
      {"history --store history --trend --plotly plotly.js -o trend.html"},
  };
  return commands;
}

TEST_F(FailingDiskTest, NothingIsLostWhateverFailsAndWhenever) {
  // What is read in several parts: half of this model is a model, too, but another one.
  folder_->write("long.yaml", "machine: three_axis\neffects:\n  - {type: scale, axis: x}\n" +
                                  std::string(200000, '#') + "\n  - {type: backlash, axis: x}\n");
  folder_->write("plotly.js", "// plotly\n" + std::string(150000, ' '));
  // A browser that prints a page by copying it.
  const std::string browser = folder_->write("browser",
                                             "#!/bin/sh\nfor w; do case $w in --print-to-pdf=*) to=${w#*=};; "
                                             "file://*) from=${w#file://};; esac; done\n"
                                             "cp \"$from\" \"$to\"\n");
  fs::permissions(browser, fs::perms::owner_all);
  ::setenv("MM_CHROMIUM", browser.c_str(), 1);
  run("promote t.yaml --store history");
  run("promote c.yaml --store history");
  const auto untouched = files();
  int runs = 0, refused = 0;
  for (const Writer& writer : writers()) {
    SCOPED_TRACE(writer.command);
    putBack(untouched);
    run(*writer.before != '\0' ? writer.before : writer.command);
    const auto old = files();
    const Answer plain = typedOn({}, writer.command);
    ASSERT_LE(plain.status, 1) << plain.error;
    ASSERT_GT(reads(), 0);
    ASSERT_GT(writes(), 3);
    const auto wanted = files();
    for (const DiskFault& fault : faults(reads(), writes())) {
      SCOPED_TRACE(fault.inWords());
      putBack(fault.anew ? untouched : old);
      const Answer answer = typedOn(fault, writer.command);
      ++runs;
      // A trend goes on without a calibration that cannot be read, and names it.
      if (answer.status == plain.status && answer.error.find("warning: left out") != std::string::npos) {
        ++refused;
        EXPECT_EQ(std::count(answer.error.begin(), answer.error.end(), '\n'), 1) << answer.error;
        continue;
      }
      Judged{answer, fault.anew ? untouched : old, files(), wanted}.everyFileIsWhole();
      if (answer.status != plain.status) {
        ++refused;
        expectOneLine(answer, fault);
        EXPECT_GT(fault.n, 0) << "what is short or interrupted is taken up again";
      } else {
        EXPECT_EQ(withoutTime(answer.out), withoutTime(plain.out));
      }
      if (HasFailure()) return;
    }
    std::printf("%5d runs, %5d refused: mm %s\n", runs, refused, writer.command);
    std::fflush(stdout);  // hours, where every n is asked
  }
  ::unsetenv("MM_CHROMIUM");
  fs::remove_all(*folder_ / "history");
  putBack(untouched);
  EXPECT_GT(refused, runs / 4);
}

}  // namespace
}  // namespace mm
