#include "base/requested_file.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "base/error.h"

namespace mm {
namespace {

class RequestedFile : public ::testing::Test {
 protected:
  RequestedFile() {
    std::string name = (std::filesystem::temp_directory_path() / "mm_requested_XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~RequestedFile() override { std::filesystem::remove_all(folder_); }
  std::string write(const std::string& name, std::size_t bytes) const {
    std::ofstream(folder_ / name) << std::string(bytes, 'a');
    return folder_ / name;
  }
  static std::string refusal(const std::string& path) {
    try {
      requestedYaml(path, "plan");
    } catch (const InputError& e) {
      return e.what();
    }
    return {};
  }
  std::filesystem::path folder_;
};

TEST_F(RequestedFile, IsAShortYamlFile) {
  const std::string plan = write("plan.yaml", 100);
  EXPECT_EQ(requestedYaml(plan, "plan"), plan);
  EXPECT_EQ(refusal(write("plan.yml", 100)), "");
}

TEST_F(RequestedFile, NoOtherFileIsRead) {
  EXPECT_NE(refusal("/etc/passwd").find("'/etc/passwd' is no plan file"), std::string::npos);
  EXPECT_NE(refusal(write("long.yaml", (1 << 20) + 1)).find("is no plan file"), std::string::npos);
  EXPECT_NE(refusal("/dev/zero").find("is no file"), std::string::npos);
  EXPECT_NE(refusal(folder_).find("is no file"), std::string::npos);
  EXPECT_NE(refusal((folder_ / "nowhere.yaml").string()).find("nowhere.yaml"), std::string::npos);
  EXPECT_LT(refusal(std::string(100000, 'a')).size(), 1000u);
}

TEST_F(RequestedFile, ATextOfLinesNamesNone) {
  EXPECT_FALSE(namesFile("effects: []\n"));
  EXPECT_FALSE(namesFile(std::string(5000, 'a')));
  EXPECT_TRUE(namesFile(write("m.yaml", 1)));
}

}  // namespace
}  // namespace mm
