#include "workflow/job.h"

#include <gtest/gtest.h>

#include <future>

#include "base/error.h"

namespace mm {
namespace {

TEST(Job, ASecondOneIsRefusedWithTheNameAndStageOfTheFirst) {
  Job job({});
  job.run("calibrate", [&] {
    job.step("refine", 0.4);
    try {
      job.run("diagnose", [] { FAIL() << "must not run"; });
      FAIL() << "must throw";
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("'calibrate' has been running for 0 s (refine, 40 %)"),
                std::string::npos)
          << e.what();
    }
  });
  bool ran = false;
  job.run("diagnose", [&] { ran = true; });
  EXPECT_TRUE(ran);
}

TEST(Job, CancelIsHeardAtTheNextStepOfEveryStage) {
  for (const std::string stage : {"reading the bag", "genetic", "refine", "uncertainty"}) {
    Job job({});
    std::promise<void> there;
    std::promise<void> go;
    auto work = std::async(std::launch::async, [&] {
      job.run("calibrate", [&] {
        job.step(stage, 0.0);
        there.set_value();
        go.get_future().wait();
        EXPECT_TRUE(job.cancelled());
        job.step(stage, 0.5);
        FAIL() << "must throw";
      });
    });
    there.get_future().wait();
    EXPECT_EQ(job.cancel().stage, stage);
    go.set_value();
    EXPECT_THROW(work.get(), Cancelled);
    EXPECT_EQ(job.state().task, "") << "idle again";
  }
}

TEST(Job, CancelOfNothingDoesNotStopTheNext) {
  Job job({});
  EXPECT_EQ(job.cancel().task, "");
  job.run("compare", [&] { EXPECT_NO_THROW(job.step("reading", 0.1)); });
}

TEST(Job, WhatIsThrownLeavesItIdleAndTold) {
  std::vector<std::string> told;
  Job job([&](const Job::State& state) { told.push_back(state.task + ":" + state.stage); });
  EXPECT_THROW(job.run("compare",
                       [&] {
                         job.step("reading", 0.0);
                         throw InputError("no");
                       }),
               InputError);
  EXPECT_EQ(told, (std::vector<std::string>{"compare:", "compare:reading", ":"}));
}

}  // namespace
}  // namespace mm
