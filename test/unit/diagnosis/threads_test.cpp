// A diagnosis is the same to the last bit whatever the number of threads.
#include <gtest/gtest.h>

#include "diagnosis/diagnose.h"
#include "long_tests.h"
#include "model/observed_domain.h"
#include "nine_ball_plate.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

TEST(Diagnose, TheSameBitsWhateverTheThreads) {
  const Machine machine = Machine::load("three_axis");
  std::vector<std::string> hidden{"backlash:x=3um"};
  if (mm_test::thoroughTests()) hidden.emplace_back("scale:y=40ppm");
  const Simulation s = simulate(machine, test::everydayPlate(machine), {hidden, 5, ""});
  const auto run = [&](unsigned threads) {
    DiagnoseOptions options;
    options.calibrate.threads = threads;
    return diagnose(s.session, Model(machine, observedDomain(s.session), std::vector<EffectSpec>{}), options);
  };
  const Diagnosis one = run(1);
  ASSERT_FALSE(one.missing.empty()) << one.sentence;
  for (const unsigned threads :
       mm_test::thoroughTests() ? std::vector<unsigned>{2, 5} : std::vector<unsigned>{2}) {
    const Diagnosis other = run(threads);
    EXPECT_EQ(other.sentence, one.sentence);
    EXPECT_EQ(other.noise, one.noise);
    EXPECT_EQ(other.heldOut, one.heldOut);
    ASSERT_EQ(other.candidates.size(), one.candidates.size());
    for (std::size_t i = 0; i < one.candidates.size(); ++i) {
      EXPECT_EQ(other.candidates[i].effect, one.candidates[i].effect);
      EXPECT_EQ(other.candidates[i].gain, one.candidates[i].gain);
      EXPECT_EQ(other.candidates[i].size, one.candidates[i].size);
    }
    ASSERT_EQ(other.missing.size(), one.missing.size());
    for (std::size_t i = 0; i < one.missing.size(); ++i)
      for (std::size_t k = 0; k < one.missing[i].parameters.size(); ++k) {
        EXPECT_EQ(other.missing[i].parameters[k].value, one.missing[i].parameters[k].value);
        EXPECT_EQ(other.missing[i].parameters[k].std, one.missing[i].parameters[k].std);
      }
  }
}

}  // namespace
}  // namespace mm
