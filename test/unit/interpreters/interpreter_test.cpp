#include "interpreter_support.h"

namespace mm {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(Interpreters, ATargetThatIsNotKnownIsNamedWithItsNeighbour) {
  const TableFolder folder;
  EXPECT_THAT(refusal("linuxnc", folder),
              AllOf(HasSubstr("'linuxnc'"), HasSubstr("did you mean 'linuxcnc'")));
}

TEST(Interpreters, AFolderThatIsNotThereOrEmptyIsRefusedByEveryTarget) {
  const TableFolder folder;
  for (const std::string& target : interpretedTargets()) {
    EXPECT_THAT(refusal(target, folder), HasSubstr(folder.path().string())) << target;
    EXPECT_THROW(interpret(target, folder.path() / "missing"), InputError) << target;
  }
}

TEST(Interpreters, JointsWithoutATableComeBackAsTheyAreCommanded) {
  TableFolder folder;
  folder.file("settings.txt", "$160=0.05\n");
  const auto motors =
      interpret("grblhal", folder.path())->motors(atMillimetres({{"x", 1.0}, {"turret", 7.0}}));
  EXPECT_DOUBLE_EQ(motors.at("turret"), 7.0 * kMillimetre);
  EXPECT_EQ(motors.size(), 2u);
}

TEST(Interpreters, LinesOfWindowsAndAByteOrderMarkAreRead) {
  TableFolder folder;
  folder.file("settings.txt", "\xEF\xBB\xBF$160=0.05\r\n$23=1\r\n");
  EXPECT_NEAR(addedMicrometres(*interpret("grblhal", folder.path()), atMillimetres({{"x", 1.0}}, -1), "x"),
              -50.0, kNanometre);
}

TEST(Interpreters, ATableThatTheDiskDoesNotGiveIsNotTakenForAnEmptyOne) {
  const TableFolder folder;
  std::filesystem::create_symlink("/proc/self/mem", folder.path() / "settings.txt");  // EIO
  EXPECT_THAT(refusal("grblhal", folder), AllOf(HasSubstr("settings.txt"), HasSubstr("Input/output error")));
}

}  // namespace
}  // namespace mm
