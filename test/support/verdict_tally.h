#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "long_tests.h"
#include "verification/verify.h"

namespace mm::test {

/// What was said in so many runs, and what was not as it should be.
class VerdictTally {
 public:
  explicit VerdictTally(std::string what) : what_(std::move(what)) {}
  /// @param verdicts that are right. @param words that the sentence must hold.
  void add(std::uint64_t seed, const Verification& v, const std::vector<VerifyVerdict>& verdicts,
           const std::string& finding, bool drifted, const std::string& words = {}) {
    ++runs_;
    if (!drifted && v.drifted) ++falseAlarms_;
    const bool verdict = std::find(verdicts.begin(), verdicts.end(), v.verdict) != verdicts.end();
    if (verdict && v.finding == finding && v.drifted == drifted &&
        v.inWords.find(words) != std::string::npos) {
      ++right_;
      if (v.rivals.empty()) ++certain_;
      if (v.moreLeft && !v.drifted) ++qualified_;
      return;
    }
    const auto named = [&](const VerifyRival& r) { return r.inWords.find(words) != std::string::npos; };
    if (!words.empty() && std::any_of(v.rivals.begin(), v.rivals.end(), named)) {
      ++open_;
      std::cout << what_ << ", seed " << seed << ", not excluded: " << v.inWords << '\n';
      return;
    }
    ADD_FAILURE() << what_ << ", seed " << seed << ": " << nameOf(v.verdict) << " " << v.finding << ", "
                  << v.inWords;
  }
  int qualified() const { return qualified_; }  ///< said rightly, but that more is left than it should be
  /// At most one in twenty may be left open: what was loaded how is named among what is not excluded.
  ~VerdictTally() {
    EXPECT_LE(20 * open_, std::max(20, runs_)) << what_;
    if (runs_ == 0) return;
    std::cout << what_ << ": " << right_ << " of " << runs_ << " said rightly, " << certain_
              << " of them without another explanation, " << open_ << " not excluded, " << qualified_
              << " with more left than calibrated, " << falseAlarms_ << " drifts said in vain\n";
  }

 private:
  std::string what_;
  int runs_ = 0, right_ = 0, certain_ = 0, open_ = 0, qualified_ = 0, falseAlarms_ = 0;
};

/// MM_FIRST_SEED: machines that nothing was chosen by.
inline std::uint64_t firstSeed(std::uint64_t usual) {
  const char* asked = std::getenv("MM_FIRST_SEED");
  return asked != nullptr ? std::stoull(asked) : usual;
}

/// Every second run is rough: the machine wanders, and the noise is correlated.
inline std::string roughOf(std::uint64_t run) { return run % 2 == 0 ? "" : "drift,correlated"; }

/// Of a table at the wrong place: what two sessions of their own show, with it and without any. Where they
/// differ by no more than their noise, either is right.
inline std::vector<VerifyVerdict> rightFor(const Figure& with, const Figure& without) {
  const double difference = with.rms - without.rms, apart = 5.0 * std::hypot(with.std, without.std);
  if (difference > apart) return {VerifyVerdict::kWorse};
  if (difference < -apart) return {VerifyVerdict::kMixed};
  return {VerifyVerdict::kWorse, VerifyVerdict::kMixed};
}

}  // namespace mm::test
