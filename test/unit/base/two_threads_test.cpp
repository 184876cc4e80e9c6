#include "base/two_threads.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace mm {
namespace {

TEST(TwoThreads, WhatEitherThrowsComesHereOnceBothHaveEnded) {
  for (std::size_t which : {std::size_t(0), std::size_t(1)}) {
    bool ended[2] = {false, false};
    const auto work = [&](std::size_t half) {
      ended[half] = true;
      if (half == which) throw std::runtime_error("half " + std::to_string(half));
    };
    EXPECT_THROW(inTwo(work), std::runtime_error);
    EXPECT_TRUE(ended[0] && ended[1]);
  }
}

}  // namespace
}  // namespace mm
