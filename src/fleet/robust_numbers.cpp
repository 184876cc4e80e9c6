#include "fleet/robust_numbers.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/distributions.h"
#include "base/median.h"
#include "base/tiny.h"

namespace mm {
namespace {

constexpr double kNormalMedian = 0.6744897501960817;  // of the size of a normal number

}  // namespace

double robustSpread(const std::vector<double>& values) {
  const double middle = median(values);
  std::vector<double> away;
  for (const double v : values) away.push_back(std::abs(v - middle));
  constexpr double kOfNormal = 1.482602218505602;  // 1 / quantile of 3/4
  return kOfNormal * median(away);
}

double pairSpread(const std::vector<double>& values) {
  const std::size_t n = values.size();
  if (n < 2) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> apart;
  apart.reserve(n * (n - 1) / 2);
  for (std::size_t i = 1; i < n; ++i)
    for (std::size_t j = 0; j < i; ++j) apart.push_back(std::abs(values[i] - values[j]));
  const std::size_t half = n / 2 + 1, order = half * (half - 1) / 2;
  const auto at = apart.begin() + (order - 1);
  std::nth_element(apart.begin(), at, apart.end());
  constexpr double kOfNormal = 2.21914446598508;  // 1 / (sqrt(2) times the quantile of 5/8)
  constexpr double kSmall[] = {0.399, 0.994, 0.512, 0.844, 0.611, 0.857, 0.669, 0.872};  // of 2 to 9
  const double count = n;
  const double factor = n <= 9 ? kSmall[n - 2] : count / (count + (n % 2 == 1 ? 1.4 : 3.8));
  return kOfNormal * factor * *at;
}

double leastSpread(const std::function<bool(double)>& tooSmall, double high, int halvings) {
  if (!tooSmall(0.0)) return 0.0;
  double low = 0.0;
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (low + high);
    (tooSmall(middle) ? low : high) = middle;
  }
  return high;
}

double excessScatter(const std::vector<double>& value, const std::vector<double>& variance) {
  if (value.empty()) return 0.0;
  const auto tooSmall = [&](double scatter) {
    std::vector<double> size;
    for (std::size_t i = 0; i < value.size(); ++i)
      size.push_back(std::abs(value[i]) / std::sqrt(variance[i] + scatter * scatter + kTiny));
    return median(std::move(size)) > kNormalMedian;
  };
  double high = 0.0;
  for (const double v : value) high = std::max(high, 2.0 * std::abs(v));
  constexpr int kHalvings = 60;
  return leastSpread(tooSmall, high, kHalvings);
}

double twoSidedT(double t, double dof) {
  const double size = std::abs(t);
  if (std::isnan(t)) return 1.0;
  if (!std::isfinite(dof) || dof > 1e6) return 2.0 * normalBelow(-size);
  return 2.0 * studentTail(size, dof);
}

}  // namespace mm
