#pragma once
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "effects/quantity.h"

namespace mm {

/// Positions of a joint (m or rad, ascending, at least one) between which a table is linear, and beyond which
/// it is constant.
class Knots {
 public:
  static constexpr int kMost = 64;

  Knots() = default;
  Knots(std::vector<double> positions, JointKind kind) : positions_(std::move(positions)), kind_(kind) {}

  int count() const { return static_cast<int>(positions_.size()); }  ///< of knots

  /// Calls `add(knot, share)` for the one or two knots whose values, times their shares, sum to the table's
  /// value at q.
  template <typename Add>
  void at(double q, const Add& add) const {
    if (std::isnan(q)) {  // what is not known stays so
      for (int i = 0; i < count(); ++i) add(i, q);
      return;
    }
    const auto after = std::upper_bound(positions_.begin(), positions_.end(), q);
    const int i = static_cast<int>(after - positions_.begin());
    if (i == 0) return add(0, 1.0);
    if (i == count()) return add(i - 1, 1.0);
    const double share = (q - positions_[i - 1]) / (positions_[i] - positions_[i - 1]);
    add(i - 1, 1.0 - share);
    add(i, share);
  }

  /// Names of the values at the knots, each once: at_-12.5mm, at_90deg.
  std::vector<std::string> names() const {
    constexpr double kShown = 1e-4, kPerShown = 1e4;  // mm or deg: positions are distinct from 1 um on
    const bool linear = kind_ == JointKind::kLinear;
    std::vector<std::string> names;
    for (const double position : positions_) {
      EffectSpec text;
      text.set("at", kShown * std::round(kPerShown * position / (linear ? kMillimetre : kDegree)));
      names.push_back("at_" + text.text("at") + (linear ? "mm" : "deg"));
    }
    for (std::size_t i = 1; i < names.size(); ++i)
      if (names[i] == names[i - 1]) names[i] += "_" + std::to_string(i);
    return names;
  }

 private:
  std::vector<double> positions_;
  JointKind kind_ = JointKind::kLinear;
};

}  // namespace mm
