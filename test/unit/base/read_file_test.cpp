#include "base/read_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <thread>

#include "base/error.h"
#include "base/nearest_name.h"

namespace mm {
namespace {

class ReadFile : public ::testing::Test {
 protected:
  ReadFile() {
    std::string name = (std::filesystem::temp_directory_path() / "mm_read_XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~ReadFile() override { std::filesystem::remove_all(folder_); }
  static std::string refusal(const std::filesystem::path& file) {
    try {
      readWholeFile(file, "look there");
    } catch (const InputError& e) {
      return e.what();
    }
    return {};
  }
  std::filesystem::path folder_;
};

TEST_F(ReadFile, AllBytesOfAFileAndOfAPipe) {
  const std::string text = std::string(200000, 'a') + '\0' + "end";
  std::ofstream(folder_ / "f", std::ios::binary) << text;
  EXPECT_EQ(readWholeFile(folder_ / "f", ""), text);
  std::ofstream(folder_ / "empty");
  EXPECT_EQ(readWholeFile(folder_ / "empty", ""), "");
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  std::thread writer([&] { std::ofstream(folder_ / "pipe") << text; });
  EXPECT_EQ(readWholeFile(folder_ / "pipe", ""), text);
  writer.join();
}

TEST_F(ReadFile, ARefusalNamesFileCauseAndRemedy) {
  EXPECT_EQ(refusal("/nosuch/file"), "/nosuch/file: cannot be read: No such file or directory; look there");
  EXPECT_EQ(refusal(folder_), folder_.string() + ": is a folder; name a file in it");
  EXPECT_NE(refusal("/dev/zero").find("/dev/zero: does not end"), std::string::npos);
}

TEST(NearestName, FarLongerNamesAreNotCompared) {
  const std::string longName(200000, 'q');
  EXPECT_EQ(nearestName(longName, {"x_mm", "time_s"}), "");
  EXPECT_EQ(nearestName("x_mmm", {"y_degrees", "x_mm"}), "x_mm");
  EXPECT_EQ(nearestName("x", {"abcdefgh"}), "");
}

}  // namespace
}  // namespace mm
