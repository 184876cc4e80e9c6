#include "session/travel.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "session/travel_tracker.h"

namespace mm {

void deriveTravel(std::vector<Observation>& observations, int joints) {
  std::vector<std::size_t> order(observations.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto earlier = [&](std::size_t a, std::size_t b) {
    return observations[a].time < observations[b].time;
  };
  if (!std::is_sorted(order.begin(), order.end(), earlier))
    std::stable_sort(order.begin(), order.end(), earlier);
  std::vector<double> last(joints, 0.0);
  for (const std::size_t i : order) {
    Observation& o = observations[i];
    o.travel.resize(joints, 0.0);
    for (int j = 0; j < joints; ++j) {
      const double v = o.velocity[j];
      if (directionOf(v) != 0.0)
        o.travel[j] = directionOf(v);
      else if (!std::isnan(v) && o.travel[j] == 0.0)
        o.travel[j] = last[j];
      if (o.travel[j] != 0.0) last[j] = o.travel[j];
    }
  }
}

}  // namespace mm
