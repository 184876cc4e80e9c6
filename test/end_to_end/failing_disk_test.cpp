// The disk fails at the n-th read or write, once or from then on: nothing that was there is lost, what is
// said to be written is whole, and a refusal is one line. Every n of every command that writes, and of the
// folder of calibrations.
#include <filesystem>

#include "calibration_file/calibration_yaml.h"
#include "long_tests.h"
#include "session_folder.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

class FailingDisk : public SessionFolder {
 protected:
  static Answer typedOn(const std::string& disk, const std::string& arguments) {
    const std::string out = *folder_ / "stdout.txt", error = *folder_ / "stderr.txt";
    const std::string whole = fs::canonical(*folder_ / ".").string();
    const int status = std::system(("cd '" + whole + "' && FAILING_DISK_FOLDER='" + whole +
                                    "/' FAILING_DISK='" + disk + "' FAILING_DISK_COUNT='" + whole +
                                    ".count' LD_PRELOAD='" FAILING_DISK_LIBRARY "' '" MM_PROGRAM "' " +
                                    arguments + " >'" + out + "' 2>'" + error + "' </dev/null")
                                       .c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, textOf(out), textOf(error)};
  }

  struct Counts {
    int reads = 0, writes = 0;
  };
  static Counts counts() {
    const std::string file = fs::canonical(*folder_ / ".").string() + ".count";
    Counts c;
    std::ifstream(file) >> c.reads >> c.writes;
    fs::remove(file);
    return c;
  }

  static void putBack(const std::map<std::string, std::string>& files) {
    for (const auto& [name, text] : FailingDisk::files()) {
      if (files.count(name) == 0) fs::remove(name);
    }
    for (const auto& [name, text] : files)
      if (textOf(name) != text) std::ofstream(name, std::ios::binary) << text;
  }

  static void expectOneLine(const Answer& answer) {
    EXPECT_EQ(answer.status, 2) << answer.error;
    EXPECT_EQ(std::count(answer.error.begin(), answer.error.end(), '\n'), 1) << answer.error;
    EXPECT_EQ(answer.error.rfind("mm: error: ", 0), 0u) << answer.error;
  }

  /// Which of 1 … most are tried: all in a long test, else the first and the last ones and some between.
  static std::vector<int> tried(int most) {
    std::vector<int> all;
    const int dense = 3, step = mm_test::longTests() ? 1 : std::max(1, most / 4);
    for (int n = 1; n <= most; ++n)
      if (n <= dense || n > most - dense || n % step == 0) all.push_back(n);
    return all;
  }
};

/// What a calibration says, without its time.
std::string withoutTime(const std::string& text) {
  std::istringstream in(text);
  std::string kept;
  for (std::string line; std::getline(in, line);) {
    bool leave = false;
    for (const char* key : {"checksum:", "id:", "created:", "time:", "  - {action", "simulated in"})
      leave = leave || line.find(key) != std::string::npos;
    if (!leave) kept += line + "\n";
  }
  return kept;
}

/// Whether a file is what the command writes when nothing fails, but for the time that stands in it.
bool sameBut(const std::string& name, const std::string& found, const std::string& wanted) {
  if (fs::path(name).extension() != ".html") return withoutTime(found) == withoutTime(wanted);
  const std::string end = "</html>\n";
  return found.size() == wanted.size() && found.compare(found.size() - end.size(), end.size(), end) == 0;
}

struct Writer {
  const char *command, *output;
};

TEST_F(FailingDisk, NothingIsLostWhateverFailsAndWhenever) {
  const std::vector<Writer> writers = {
      {"import s.csv --machine three_axis --artifact artifact.yaml -o out.bag", "out.bag"},
      {"simulate --machine three_axis --plan plan.yaml -o sim.bag --csv sim.csv --truth truth.yaml --force",
       "sim.bag sim.csv truth.yaml"},
      {"calibrate s.bag --model long.yaml --method least_squares -o out.yaml", "out.yaml"},
      {"calibrate s.bag --model m.yaml --generations 3 --population 20 -o ga.yaml --curve curve.csv",
       "ga.yaml curve.csv"},
      {"add s.bag --calibration c.yaml '{type: backlash, axis: x}' -o added.yaml", "added.yaml"},
      {"remove s.bag --calibration c.yaml '{type: scale, axis: x}' -o removed.yaml", "removed.yaml"},
      {"report s.bag --calibration c.yaml --plotly plotly.js -o report.html", "report.html"},
      {"apply states.csv --calibration c.yaml -o corrected.csv", "corrected.csv"},
      {"sensors series.csv --target nose_um --picture picture.svg", "picture.svg"},
      {"machine new --axis x=0:120mm --axis y=0:80mm -o new.urdf --model new_model.yaml --force",
       "new.urdf new_model.yaml"},
      {"plan new --machine three_axis --balls 2x2 -o new_plan.yaml --force", "new_plan.yaml"},
  };
  // What is read in several parts: half of this model is a model, too, but another one.
  folder_->write("long.yaml", "machine: three_axis\neffects:\n  - {type: scale, axis: x}\n" +
                                  std::string(200000, '#') + "\n  - {type: backlash, axis: x}\n");
  folder_->write("plotly.js", "// plotly\n" + std::string(150000, ' '));
  const auto untouched = files();
  int runs = 0, refused = 0;
  for (const Writer& writer : writers) {
    SCOPED_TRACE(writer.command);
    putBack(untouched);
    run(writer.command);
    const auto old = files();
    const Answer plain = typedOn("", writer.command);
    ASSERT_EQ(plain.status, 0) << plain.error;
    const Counts most = counts();
    ASSERT_GT(most.reads, 0);
    ASSERT_GT(most.writes, 3);
    const auto wanted = files();
    for (const bool reads : {true, false})
      for (const std::string way : {"once", "lasting", "short", "interrupted"})
        for (const int n : way == "once" || way == "lasting" ? tried(reads ? most.reads : most.writes)
                                                             : std::vector<int>{0}) {
          const std::string disk = (reads ? "reads " : "writes ") + std::to_string(n) + " " + way;
          SCOPED_TRACE(disk);
          putBack(old);
          const Answer answer = typedOn(disk, writer.command);
          const auto found = files();
          ++runs;
          for (const auto& [name, text] : found) EXPECT_GT(old.count(name), 0u) << name << " was left behind";
          bool changed = false;
          for (const auto& [name, text] : old) {
            ASSERT_GT(found.count(name), 0u) << name << " is lost";
            const bool same = found.at(name) == text;
            changed = changed || !same;
            EXPECT_TRUE(same || sameBut(name, found.at(name), wanted.at(name))) << name;
          }
          if (answer.status != 0) {
            ++refused;
            expectOneLine(answer);
            EXPECT_GT(n, 0) << "what is short or interrupted is taken up again";
          } else {
            EXPECT_EQ(withoutTime(answer.out), withoutTime(plain.out));
          }
          if (HasFailure()) return;
        }
  }
  putBack(untouched);
  std::printf("%d runs, %d refused\n", runs, refused);
  EXPECT_GT(refused, runs / 4);
}

/// Of a folder of calibrations, what counts: which are there, whole, and what was ever active.
TEST_F(FailingDisk, AFolderOfCalibrationsKeepsWhatItHas) {
  run("calibrate s.bag --model m.yaml --method least_squares -o c2.yaml --force");
  run("promote c.yaml --store kept");
  const fs::path kept = *folder_ / "kept", copy = *folder_ / "copy";
  fs::copy(kept, copy, fs::copy_options::recursive | fs::copy_options::copy_symlinks);
  const std::string list = textOf((kept / "promotions").string()),
                    before = fs::read_symlink(kept / "active").string();
  ASSERT_EQ(typedOn("", "promote t.yaml --store kept").status, 0);
  const Counts most = counts();
  const std::string wanted = fs::read_symlink(kept / "active").string();
  ASSERT_NE(wanted, before);
  int runs = 0;
  for (const bool reads : {true, false})
    for (const std::string way : {"once", "lasting"})
      for (const int n : tried(reads ? most.reads : most.writes)) {
        SCOPED_TRACE((reads ? "reads " : "writes ") + std::to_string(n) + " " + way);
        fs::remove_all(kept);
        fs::copy(copy, kept, fs::copy_options::recursive | fs::copy_options::copy_symlinks);
        const Answer answer = typedOn((reads ? "reads " : "writes ") + std::to_string(n) + " " + way,
                                      "promote t.yaml --store kept");
        ++runs;
        const std::string active = fs::read_symlink(kept / "active").string();
        EXPECT_TRUE(active == before || active == wanted) << active;
        if (answer.status == 0)
          EXPECT_EQ(active, wanted);
        else
          expectOneLine(answer);
        EXPECT_EQ(textOf((kept / "promotions").string()).rfind(list, 0), 0u) << "lines of the list are lost";
        for (const auto& entry : fs::directory_iterator(kept))
          if (entry.is_regular_file() && entry.path().extension() == ".yaml") loadCalibration(entry.path());
        // It goes on as if nothing had been.
        run("promote t.yaml --store kept");
        EXPECT_EQ(fs::read_symlink(kept / "active").string(), wanted);
        for (const auto& entry : fs::directory_iterator(kept))
          EXPECT_EQ(entry.path().filename().string().find(".mm-tmp-"), std::string::npos) << entry.path();
        run("rollback --store kept");
        EXPECT_EQ(fs::read_symlink(kept / "active").string(), before);
        if (HasFailure()) return;
      }
  EXPECT_GT(runs, 20);
  fs::remove_all(kept);
  fs::remove_all(copy);
}

}  // namespace
}  // namespace mm
