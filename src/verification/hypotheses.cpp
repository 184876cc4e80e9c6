#include "verification/hypotheses.h"

#include <algorithm>
#include <cmath>

namespace mm {
namespace {

constexpr AxisState kStates[] = {AxisState::kCorrected, AxisState::kNotCorrected, AxisState::kWrongSign,
                                 AxisState::kTwice};
// Odds before any data: that everything is right or that nothing was loaded is what mostly happens; one axis
// of its own is a mistake, two are two. That some tables are exchanged is shared by all the ways in which
// they can be.
constexpr double kUniform = -1.0, kOneAxis = -4.0, kExchange = -3.0;
// External offsets are loaded by themselves: not to have started them is one thing forgotten.
constexpr double kOffsetsForgotten = -1.0, kOffsetsOtherwise = -4.0;

/// How much of an error the raw readings show.
double shown(AxisState state, bool loaded) {
  const double remains = factsOf(state).remaining;
  return loaded ? remains : 1.0 - remains;
}

class Maker {
 public:
  Maker(const FreshPoints& points, bool loaded) : points_(points), loaded_(loaded), rest_(points.rest()) {}

  /// @param rest state of what no axis can show.
  LoadedHow of(std::vector<AxisState> axes, double logPrior, AxisState rest) const {
    LoadedHow h;
    h.field = (points_.tabled() ? 1.0 : shown(rest, loaded_)) * rest_;  // no table has it
    for (int a = 0; a < points_.axisCount(); ++a) h.field += shown(axes[a], loaded_) * points_.own(a);
    if (points_.hasOffsets()) {
      h.field += shown(rest, loaded_) * points_.offsets();
      h.offsets = rest;
    }
    h.axes = std::move(axes);
    h.logPrior = logPrior;
    return h;
  }

  /// Tables of two axes at the wrong place. An axis whose table stands elsewhere has none of its own, and one
  /// that got another's has lost its own.
  LoadedHow exchanged(const std::vector<Exchange>& exchanges) const {
    std::vector<AxisState> axes(points_.axisCount(), AxisState::kCorrected);
    for (const Exchange& e : exchanges) axes[e.of] = axes[e.on] = AxisState::kNotCorrected;
    LoadedHow h = of(std::move(axes), kExchange - (exchanges.size() == 1 ? 1.0 : 0.0), AxisState::kCorrected);
    for (const Exchange& e : exchanges) h.field += (loaded_ ? -1.0 : 1.0) * columnOf(e);
    h.exchanges = exchanges;
    return h;
  }

 private:
  Eigen::VectorXd columnOf(const Exchange& e) const {
    if (!e.entered) return points_.crossed().col(e.on * points_.axisCount() + e.of);
    for (const MisplacedTable& table : points_.misplaced())
      if (table.of == e.of && table.on == e.on) return table.column;
    return Eigen::VectorXd::Zero(points_.length());
  }

  const FreshPoints& points_;
  bool loaded_;
  Eigen::VectorXd rest_;
};

/// Every way of the tables with every way of the external offsets; `tables` have them as the axes where these
/// are alike, else as corrected.
std::vector<LoadedHow> withOffsets(const std::vector<LoadedHow>& tables, const FreshPoints& points,
                                   bool loaded, bool tablesSeen) {
  std::vector<LoadedHow> all;
  for (const LoadedHow& how : tables) {
    const AxisState along = how.offsets.value_or(AxisState::kCorrected);
    std::vector<AxisState> states = {along};
    // Where no axis's table is to be seen, the offsets alone tell how it was loaded.
    for (const AxisState other : {AxisState::kCorrected, AxisState::kNotCorrected, AxisState::kWrongSign})
      if (tablesSeen && other != along) states.push_back(other);
    for (const AxisState state : states) {
      LoadedHow with = how;
      with.offsets = state;
      with.field += (shown(state, loaded) - shown(along, loaded)) * points.offsets();
      if (state != along)
        with.logPrior += state == AxisState::kNotCorrected ? kOffsetsForgotten : kOffsetsOtherwise;
      all.push_back(std::move(with));
    }
  }
  return all;
}

}  // namespace

const StateFacts& factsOf(AxisState state) {
  static constexpr StateFacts kFacts[] = {{0.0, "corrected", "corrected", "are loaded"},
                                          {1.0, "not_corrected", "not corrected", "are not"},
                                          {2.0, "wrong_sign", "wrong sign", "have the wrong sign"},
                                          {-1.0, "corrected_twice", "corrected twice", "are loaded twice"}};
  return kFacts[static_cast<std::size_t>(state)];
}

bool LoadedHow::alike() const {
  return exchanges.empty() &&
         std::all_of(axes.begin(), axes.end(), [&](AxisState s) { return s == axes.front(); });
}

bool LoadedHow::uniform() const { return alike() && (!offsets || *offsets == state()); }

AxisState LoadedHow::state() const {
  return axes.empty() ? offsets.value_or(AxisState::kCorrected) : axes.front();
}

std::vector<LoadedHow> hypothesesOf(const FreshPoints& points, bool loaded, const std::vector<char>& seen,
                                    bool offsetsSeen) {
  const Maker maker(points, loaded);
  const int count = points.axisCount();
  std::vector<LoadedHow> all;
  for (const AxisState state : kStates)
    all.push_back(maker.of(std::vector<AxisState>(count, state),
                           state == AxisState::kCorrected ? 0.0 : kUniform, state));
  std::vector<int> told;
  for (int a = 0; a < count; ++a)
    if (seen[a]) told.push_back(a);
  std::size_t combinations = told.size() > 1 ? 1 : 0;
  for (std::size_t i = 0; combinations > 0 && i < told.size(); ++i) combinations *= 4;
  for (std::size_t c = 0; c < combinations; ++c) {
    std::vector<AxisState> axes(count, AxisState::kCorrected);
    std::size_t rest = c, other = 0;
    bool uniform = true;
    for (const int a : told) {
      axes[a] = kStates[rest % 4];
      rest /= 4;
      if (axes[a] != AxisState::kCorrected) ++other;
      uniform = uniform && axes[a] == axes[told.front()];
    }
    if (!uniform) all.push_back(maker.of(axes, kOneAxis * other, AxisState::kCorrected));
  }
  const std::size_t firstExchange = all.size();
  for (int a = 0; a < count; ++a)
    for (int b = a + 1; b < count; ++b) {
      if (!seen[a] && !seen[b]) continue;
      for (const bool entered : {false, true}) {
        const auto ofThese = [&](const MisplacedTable& table) { return table.of == a && table.on == b; };
        const auto& tables = points.misplaced();
        if (entered && std::none_of(tables.begin(), tables.end(), ofThese)) continue;
        const Exchange forth{a, b, entered}, back{b, a, entered};
        all.push_back(maker.exchanged({forth, back}));
        all.push_back(maker.exchanged({forth}));
        all.push_back(maker.exchanged({back}));
      }
    }
  const double asked = std::max<std::size_t>(1, all.size() - firstExchange);
  for (std::size_t h = firstExchange; h < all.size(); ++h) all[h].logPrior -= std::log(asked);
  if (!offsetsSeen) {
    for (LoadedHow& how : all) how.offsets.reset();
    return all;
  }
  const bool tablesSeen = std::any_of(seen.begin(), seen.end(), [](char s) { return s != 0; });
  return withOffsets(all, points, loaded, tablesSeen);
}

}  // namespace mm
