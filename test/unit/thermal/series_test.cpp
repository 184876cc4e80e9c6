#include "thermal/series.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>

#include "base/error.h"

namespace mm {
namespace {

/// A file of the given text for the time of a test.
class TextFile {
 public:
  explicit TextFile(const std::string& text) : path_("/tmp/mm_series_" + std::to_string(getpid()) + ".csv") {
    std::ofstream(path_) << text;
  }
  ~TextFile() { std::remove(path_.c_str()); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

std::string complaint(const std::string& text) {
  const TextFile file(text);
  try {
    readSeries(file.path());
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(SampledSeries, ReadsNamedColumns) {
  const TextFile file("time_s, a_degC ,nose_um\r\n# a comment\n0,20.5,1e-1\n\n1,21,-3\n");
  const SampledSeries series = readSeries(file.path());
  EXPECT_EQ(series.names, (std::vector<std::string>{"time_s", "a_degC", "nose_um"}));
  ASSERT_EQ(series.samples(), 2);
  EXPECT_EQ(series.values(0, 1), 20.5);
  EXPECT_EQ(series.values(1, 2), -3.0);
  EXPECT_EQ(series.column("nose_um"), 2);
  EXPECT_THROW(series.column("nose"), InputError);
}

TEST(SampledSeries, NamesLineAndColumnOfWhatIsWrong) {
  EXPECT_NE(complaint("a,b\n1,2\n3\n").find(":3: 1 values for 2 columns"), std::string::npos);
  EXPECT_NE(complaint("a,b\n1,nan\n").find(":2: column 'b': 'nan'"), std::string::npos);
  EXPECT_NE(complaint("a,b\n1,\n").find(":2: column 'b': ''"), std::string::npos);
  EXPECT_NE(complaint("a,b\n1,2x\n").find("'2x'"), std::string::npos);
  EXPECT_NE(complaint("a,a\n1,2\n").find("appears twice"), std::string::npos);
  EXPECT_NE(complaint("").find("is empty"), std::string::npos);
  EXPECT_THROW(readSeries("/nonexistent/series.csv"), InputError);
}

TEST(SampledSeries, KnowsTimeAndUnits) {
  EXPECT_TRUE(isTimeColumn("time_s"));
  EXPECT_FALSE(isTimeColumn("timer_degC"));
  EXPECT_EQ(micrometresPerUnit("nose_mm"), 1e3);
  EXPECT_EQ(micrometresPerUnit("nose_um"), 1.0);
  EXPECT_EQ(micrometresPerUnit("drift"), 1.0);
}

}  // namespace
}  // namespace mm
