#include "fleet/manifest.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

class ManifestTest : public testing::Test {
 protected:
  ManifestTest() {
    std::string pattern = (fs::temp_directory_path() / "mm_manifest_XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    write("m1/a.bag", "first");
    write("m1/b.bag", "second");
    write("m2/c.bag", "third");
    write("model.yaml", "machine: three_axis\neffects: []\n");
    write("other.yaml", "machine: three_axis\neffects: [{type: scale, axis: x}]\n");
    write("c.yaml", "a calibration");
  }
  ~ManifestTest() override { fs::remove_all(folder_); }
  void write(const std::string& name, const std::string& text) {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
  }
  Manifest load(const std::string& text) {
    write("manifest.yaml", text);
    return loadManifest(folder_ / "manifest.yaml");
  }
  std::string refusal(const std::string& text) {
    try {
      load(text);
    } catch (const InputError& e) {
      return e.what();
    }
    return "was accepted";
  }
  fs::path folder_;
};

TEST_F(ManifestTest, takesEveryFileOfAPatternWithEveryModel) {
  const Manifest m = load(
      "models: [model.yaml, other.yaml]\nsessions:\n  - {bags: 'm1/*.bag', machine: mill, date: 2026-01-05}\n"
      "  - {bags: m2/c.bag, serial: 4711, model: model.yaml, steps: [report, calibrate]}\n");
  ASSERT_EQ(m.jobs.size(), 5u);
  EXPECT_EQ(m.jobs[0].machine, "mill");
  EXPECT_EQ(m.jobs[0].date, "2026-01-05T00:00:00Z");
  EXPECT_EQ(m.jobs[0].steps, (std::vector<std::string>{"check", "calibrate", "diagnose"}));
  EXPECT_EQ(m.jobs[0].bag, folder_ / "m1/a.bag");
  EXPECT_NE(m.jobs[0].key, m.jobs[1].key);  // another model
  EXPECT_EQ(m.jobs[4].machine, "4711");
  EXPECT_EQ(m.jobs[4].steps, (std::vector<std::string>{"calibrate", "report"}));  // in the order of the work
  EXPECT_EQ(m.jobs[4].source, (folder_ / "manifest.yaml").string() + ":4");
}

TEST_F(ManifestTest, theKeyIsOfTheContentAndNothingElse) {
  const std::string text = "model: model.yaml\nsessions:\n  - {bags: m1/a.bag, machine: mill}\n";
  const std::string key = load(text).jobs[0].key;
  EXPECT_EQ(key.size(), 32u);
  EXPECT_EQ(load("model: model.yaml\nsessions:\n  - {bags: m1/a.bag, machine: lathe, date: 2026-01-05}\n")
                .jobs[0]
                .key,
            key);  // labels
  EXPECT_NE(load("model: model.yaml\nseed: 2\nsessions:\n  - {bags: m1/a.bag, machine: mill}\n").jobs[0].key,
            key);
  EXPECT_NE(load("model: other.yaml\nsessions:\n  - {bags: m1/a.bag, machine: mill}\n").jobs[0].key, key);
  write("m1/a.bag", "measured again");
  EXPECT_NE(load(text).jobs[0].key, key);
  write("m1/a.bag", "first");
  EXPECT_EQ(load(text).jobs[0].key, key);
}

TEST_F(ManifestTest, theCorrectionThatIsLoadedIsPartOfAVerification) {
  const std::string entry = "sessions:\n  - {bags: m2/c.bag, calibration: c.yaml, steps: [verify], loaded: ";
  const BatchJob loaded = load(entry + "true}\n").jobs[0], raw = load(entry + "false}\n").jobs[0];
  EXPECT_TRUE(loaded.loaded);
  EXPECT_TRUE(jobOf(jobJson(loaded)).loaded);
  EXPECT_FALSE(raw.loaded);
  EXPECT_NE(loaded.key, raw.key);
}

TEST_F(ManifestTest, aBagIsNotHeldInMemoryForItsKey) {
  constexpr long kSize = 96L << 20;
  fs::resize_file(folder_ / "m2/c.bag", kSize);  // sparse: only what reads it needs memory
  BatchJob job;
  job.bag = folder_ / "m2/c.bag";
  const pid_t child = ::fork();
  if (child == 0) {
    const auto most = [] {
      rusage used{};
      ::getrusage(RUSAGE_SELF, &used);
      return used.ru_maxrss;  // kB
    };
    const long before = most();
    const bool named = keyOf(job).size() == 32;
    ::_exit(named && most() - before < kSize / 1024 / 4 ? 0 : 1);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
}

TEST_F(ManifestTest, aNameThatIsNoUtf8IsRefusedWithItsLineAndKey) {
  const std::string latin = "geh\xE4use";
  const std::string why =
      refusal("model: model.yaml\nsessions:\n  - {bags: m2/c.bag, machine: " + latin + "}\n");
  for (const char* part : {"manifest.yaml:3", "machine", "geh\\xE4use", "UTF-8"})
    EXPECT_NE(why.find(part), std::string::npos) << why;
  write("m3/" + latin + ".bag", "fourth");
  const std::string file = refusal("model: model.yaml\nsessions:\n  - {bags: 'm3/*.bag', machine: mill}\n");
  for (const char* part : {"manifest.yaml:3", "bags", "geh\\xE4use.bag", "rename"})
    EXPECT_NE(file.find(part), std::string::npos) << file;
  EXPECT_EQ(load("model: model.yaml\nsessions:\n  - {bags: m2/c.bag, machine: gehäuse}\n").jobs[0].machine,
            "gehäuse");
}

TEST_F(ManifestTest, itsOwnFolderIsNoPatternAndTheHomeFolderIsKnown) {
  const fs::path odd = folder_ / "year [2026] {a,b} *";
  fs::create_directories(odd);
  for (const char* name : {"m1", "model.yaml"})
    fs::copy(folder_ / name, odd / name, fs::copy_options::recursive);
  std::ofstream(odd / "manifest.yaml") << "model: model.yaml\nsessions:\n  - {bags: 'm1/{a,b}.bag'}\n";
  const Manifest m = loadManifest(odd / "manifest.yaml");
  ASSERT_EQ(m.jobs.size(), 2u);
  EXPECT_EQ(m.jobs[0].bag, odd / "m1/a.bag");
  const std::string home = std::getenv("HOME") == nullptr ? "" : std::getenv("HOME");
  ::setenv("HOME", folder_.c_str(), 1);
  EXPECT_EQ(load("model: model.yaml\nsessions:\n  - {bags: '~/m2/*.bag'}\n").jobs[0].bag,
            folder_ / "m2/c.bag");
  ::setenv("HOME", home.c_str(), 1);
}

TEST_F(ManifestTest, aMachineIsNamedByItsFolderWhereNothingElseIsTold) {
  EXPECT_EQ(load("model: model.yaml\nsessions:\n  - {bags: m2/c.bag}\n").jobs[0].machine, "m2");
}

TEST_F(ManifestTest, theSameSessionTwiceIsDoneOnceAndSaid) {
  const Manifest m = load(
      "model: model.yaml\nsessions:\n  - {bags: m1/*.bag, machine: mill}\n  - {bags: m1/a.bag, machine: "
      "mill}\n");
  EXPECT_EQ(m.jobs.size(), 2u);
  ASSERT_EQ(m.remarks.size(), 1u);
  EXPECT_NE(m.remarks[0].find("manifest.yaml:4"), std::string::npos) << m.remarks[0];
}

TEST_F(ManifestTest, oneSessionOfTwoMachinesIsRefusedWithBothLines) {
  const std::string why = refusal(
      "model: model.yaml\nsessions:\n  - {bags: m1/a.bag, machine: mill}\n  - {bags: m1/a.bag, machine: "
      "lathe}\n");
  for (const char* part :
       {"manifest.yaml:3", "manifest.yaml:4", "mill", "lathe", "one session is of one machine"})
    EXPECT_NE(why.find(part), std::string::npos) << why;
}

TEST_F(ManifestTest, whatIsWrongIsNamedByFileLineAndKey) {
  const std::string head = "model: model.yaml\nsessions:\n  - {bags: m2/c.bag}\n";
  const struct {
    std::string text;
    std::vector<std::string> parts;
  } cases[] = {
      {"model: model.yaml\nsessions:\n  - {bags: m9/*.bag}\n",
       {"manifest.yaml:3", "bags", "m9/*.bag", "fits no file"}},
      {head + "  - {bag: m2/c.bag}\n", {"manifest.yaml:4", "unknown key 'bag'", "bags"}},
      {head + "  - {bags: m2/c.bag, model: nowhere.yaml}\n", {"manifest.yaml:4", "model", "nowhere.yaml"}},
      {head + "  - {bags: m2/c.bag, steps: [callibrate]}\n",
       {"manifest.yaml:4", "steps", "did you mean 'calibrate'"}},
      {head + "  - {bags: m2/c.bag, date: yesterday}\n", {"manifest.yaml:4", "date", "2026-01-05"}},
      {head + "  - {bags: m2/c.bag, date: 2026-13-05}\n", {"manifest.yaml:4", "date", "2026-13-05"}},
      {head + "  - {bags: m2/c.bag, date: 2026-02-31}\n", {"manifest.yaml:4", "date", "2026-02-31"}},
      {head + "  - {bags: m2/c.bag, date: '2026-02-03T99:99:99Z'}\n",
       {"manifest.yaml:4", "date", "99:99:99"}},
      {head + "  - {bags: m2/c.bag, date: '2026-02-03T23:59:60Z'}\n", {"manifest.yaml:4", "date"}},
      {head + "  - {bags: m2/c.bag, loaded: maybe}\n", {"manifest.yaml:4", "loaded", "true"}},
      {head + "  - {bags: m2/c.bag, method: newton}\n", {"manifest.yaml:4", "method", "least_squares"}},
      {head + "  - {bags: m2/c.bag, repeatability_um: -1}\n", {"manifest.yaml:4", "repeatability_um"}},
      {head + "  - {bags: m2/c.bag, steps: [verify]}\n", {"manifest.yaml:4", "verify", "calibration"}},
      {"sessions:\n  - {bags: m2/c.bag}\n", {"manifest.yaml:2", "calibrate", "model"}},
      {"model: model.yaml\nsessions: []\n", {"manifest.yaml:2", "sessions", "names no session"}},
      {"model: model.yaml\nsessions:\n  - {bags: [m2/c.bag\n", {"manifest.yaml:"}},
  };
  for (const auto& c : cases) {
    const std::string why = refusal(c.text);
    EXPECT_EQ(why.find('\n'), std::string::npos);
    for (const std::string& part : c.parts) EXPECT_NE(why.find(part), std::string::npos) << c.text << why;
  }
}

TEST_F(ManifestTest, aCalibrationIsNeededOnlyWhereAStepAsksForIt) {
  const Manifest m =
      load("sessions:\n  - {bags: m2/c.bag, steps: [diagnose, report], calibration: c.yaml}\n");
  ASSERT_EQ(m.jobs.size(), 1u);
  EXPECT_EQ(m.jobs[0].calibration, folder_ / "c.yaml");
  EXPECT_TRUE(m.jobs[0].model.empty());
}

}  // namespace
}  // namespace mm
