#include "base/nearest_name.h"

#include <algorithm>
#include <cstdlib>

#include "base/text.h"

namespace mm {
int editDistance(const std::string& a, const std::string& b) {
  const int n = static_cast<int>(a.size()), m = static_cast<int>(b.size());
  std::vector<int> beforeLast(m + 1), last(m + 1), row(m + 1);
  for (int j = 0; j <= m; ++j) last[j] = j;
  for (int i = 1; i <= n; ++i) {
    row[0] = i;
    for (int j = 1; j <= m; ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], beforeLast[j - 2] + 1);
    }
    std::swap(beforeLast, last);
    std::swap(last, row);
  }
  return last[m];
}

std::string nearestName(const std::string& name, const std::vector<std::string>& known) {
  std::string nearest;
  int best = std::max<int>(2, static_cast<int>(name.size()) / 3) + 1;
  const std::string wanted = lower(name);
  for (const std::string& candidate : known) {
    // as many changes as one has letters more than the other, at least
    if (std::abs(static_cast<int>(name.size()) - static_cast<int>(candidate.size())) >= best) continue;
    const int distance = editDistance(wanted, lower(candidate));
    // as many changes as there are letters: nothing in common
    if (distance < best && (distance == 0 || distance < static_cast<int>(name.size()))) {
      best = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

std::string listOf(const std::vector<std::string>& names) {
  return names.empty() ? "none" : joined(names, ", ");
}

std::string didYouMean(const std::string& name, const std::vector<std::string>& known) {
  const std::string nearest = nearestName(name, known);
  return nearest.empty() ? "" : "; did you mean '" + nearest + "'?";
}

}  // namespace mm
