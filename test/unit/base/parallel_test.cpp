#include "base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

#include "base/cancel_scope.h"
#include "base/error.h"

namespace mm {
namespace {

TEST(Parallel, EachCallIsMadeOnceWhateverTheThreads) {
  for (const unsigned threads : {0u, 1u, 2u, 5u}) {
    std::vector<std::atomic<int>> calls(1000);
    Threads(threads).run([&] { parallelFor(calls.size(), [&](std::size_t i) { ++calls[i]; }); });
    for (const std::atomic<int>& count : calls) EXPECT_EQ(count, 1);
  }
  parallelFor(0, [](std::size_t) { FAIL() << "nothing was to be done"; });
}

TEST(Parallel, NoMoreRunAtATimeThanWereAllowed) {
  for (const int threads : {1, 3}) {
    std::atomic<int> running{0}, most{0};
    Threads(static_cast<unsigned>(threads)).run([&] {
      parallelFor(200, [&](std::size_t) {
        const int now = ++running;
        for (int seen = most; now > seen && !most.compare_exchange_weak(seen, now);) {
        }
        parallelFor(3, [](std::size_t) {});  // one within the other takes no further ones
        --running;
      });
    });
    EXPECT_LE(most, threads);
  }
}

TEST(Parallel, WhatOneThrowsComesHere) {
  for (const unsigned threads : {1u, 4u})
    EXPECT_THROW(Threads(threads).run([] {
      parallelFor(50, [](std::size_t i) {
        if (i == 30) throw std::runtime_error("thirty");
      });
    }),
                 std::runtime_error);
}

TEST(Parallel, TheScopeOfTheCallerIsThatOfEveryCall) {
  std::atomic<bool> stop{false};
  const CancelScope scope([&] { return stop.load(); });
  Threads(4).run([&] {
    parallelFor(100, [&](std::size_t) { EXPECT_EQ(CancelScope::current(), &scope); });
    stop = true;
    EXPECT_THROW(parallelFor(100, [](std::size_t) { CancelScope::check(); }), Cancelled);
  });
  EXPECT_EQ(CancelScope::current(), &scope);
}

TEST(Parallel, PartsCoverEverythingOnce) {
  for (const std::size_t count : {0u, 1u, 7u, 8u, 9u, 100u}) {
    std::size_t at = 0;
    for (std::size_t p = 0; p < partsOf(count, 8); ++p) {
      const Part part = partOf(count, 8, p);
      EXPECT_EQ(part.first, at);
      EXPECT_GT(part.end, part.first);
      at = part.end;
    }
    EXPECT_EQ(at, count);
  }
}

}  // namespace
}  // namespace mm
