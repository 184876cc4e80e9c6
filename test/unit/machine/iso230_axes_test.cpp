// Letters of the axes by ISO 841, and the chain as ISO 10791-6 writes it.
#include "machine/iso230_axes.h"

#include <gtest/gtest.h>

#include "machine_chains.h"

namespace mm {
namespace {

using test::ChainJoint;
using test::kAlong;

std::string lettersOf(const Machine& machine) {
  std::string letters;
  for (const Iso230Axis& axis : iso230Axes(machine))
    letters += (letters.empty() ? "" : " ") + (axis.name.empty() ? "-" : axis.name);
  return letters;
}

TEST(Iso230Axes, AreNamedByTheDirectionInWorkpieceWhateverTheJointIsCalled) {
  EXPECT_EQ(lettersOf(Machine::load("three_axis")), "X Y Z");
  EXPECT_EQ(lettersOf(Machine::load("five_axis")), "Y X Z C A");  // its joint b turns about z
  EXPECT_EQ(lettersOf(test::tableTable()), "C A X Y Z");
  EXPECT_EQ(lettersOf(test::headHead()), "X Y Z C A");  // y of a link that is turned about z is x
  EXPECT_EQ(lettersOf(test::movingColumn()), "B X Y Z");
  EXPECT_EQ(lettersOf(test::telescope()), "C B");
}

TEST(Iso230Axes, TheSecondOfADirectionHasTheSecondLetterUnlessItIsCalledByTheFirst) {
  EXPECT_EQ(lettersOf(test::gantry()), "Y X Z W");
  EXPECT_EQ(lettersOf(test::chainOf("twice", {{"u", "workpiece", "l1", kAlong, "1 0 0"},
                                              {"x", "l1", "l2", kAlong, "-1 0 0"},
                                              {"q", "l2", "l3", kAlong, "1 0 0"},
                                              {"c", "l3", "l4", test::kTurns, "0 0 1"},
                                              {"d", "l4", "probe_tip", test::kTurns, "0 0 1"}})),
            "U X P C C2");
}

TEST(Iso230Axes, AnAxisThatSlantsHasNoLetter) {
  EXPECT_EQ(lettersOf(test::equatorialMount()), "- A");
  const auto slanted = [](const std::string& axis) {
    return lettersOf(test::chainOf("slanted", {{"x", "workpiece", "probe_tip", kAlong, axis}}));
  };
  EXPECT_EQ(slanted("0.99 0.1 0"), "X");     // 6 degrees
  EXPECT_EQ(slanted("0.97 0.2431 0"), "-");  // 14 degrees
}

TEST(KinematicChain, GoesFromTheWorkpieceOverTheBedToTheProbe) {
  EXPECT_EQ(kinematicChain(Machine::load("three_axis")), "w-b-X-Y-Z-t");
  EXPECT_EQ(kinematicChain(Machine::load("five_axis")), "w-Y-X-b-Z-C-A-t");
  EXPECT_EQ(kinematicChain(test::tableTable()), "w-C-A-X-b-Y-Z-t");
  EXPECT_EQ(kinematicChain(test::headHead()), "w-b-X-Y-Z-C-A-t");
  EXPECT_EQ(kinematicChain(test::gantry()), "w-b-Y-X-Z-W-t");
  EXPECT_EQ(kinematicChain(test::movingColumn()), "w-B-b-X-Y-Z-t");
  EXPECT_EQ(kinematicChain(test::telescope()), "w-b-C-B-t");
  EXPECT_EQ(kinematicChain(test::equatorialMount()), "w-b-\"ha\"-A-t");
}

TEST(KinematicChain, TheBedMayCarryTheProbe) {
  EXPECT_EQ(kinematicChain(test::chainOf("all_in_the_table", {{"mount", "base", "probe_tip"},
                                                              {"y", "base", "cross", kAlong, "0 1 0"},
                                                              {"x", "cross", "workpiece", kAlong, "1 0 0"}})),
            "w-X-Y-b-t");
}

}  // namespace
}  // namespace mm
