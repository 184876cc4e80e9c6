#include "diagnosis/shortlist.h"

#include <algorithm>
#include <numeric>

namespace mm {
namespace {

constexpr std::size_t kMostAtFirst = 40;  // groups
constexpr std::size_t kMostLater = 10;
constexpr double kNear = 6.0;  // nats below its price: what comes in later

bool isMember(const Explanation& found, long group) {
  return std::any_of(found.members.begin(), found.members.end(),
                     [&](const Member& m) { return m.group == group; });
}

/// The shapes of a group that gain most, ascending.
std::vector<int> bestOf(const std::vector<double>& gains) {
  constexpr std::size_t kMostShapes = 12;
  std::vector<int> best(gains.size());
  std::iota(best.begin(), best.end(), 0);
  std::stable_sort(best.begin(), best.end(), [&](int a, int b) { return gains[a] > gains[b]; });
  best.resize(std::min(best.size(), kMostShapes));
  std::sort(best.begin(), best.end());
  return best;
}

/// The questions of the given groups, beside one another.
Groups together(std::vector<Groups> ones, Eigen::Index length) {
  Groups all;
  int columns = 0;
  for (const Groups& one : ones) columns += static_cast<int>(one.columns.cols());
  all.columns.resize(length, columns);
  int at = 0;
  for (Groups& one : ones) {
    all.columns.middleCols(at, one.columns.cols()) = one.columns;
    for (Shape& s : one.groups[0].shapes) s.first += at;
    at += static_cast<int>(one.columns.cols());
    all.causes += !one.groups[0].profile;
    all.groups.push_back(std::move(one.groups[0]));
  }
  return all;
}

/// Whether one of the group's shapes is this one.
bool hasShape(const Group& group, const Shape& shape) {
  return std::any_of(group.shapes.begin(), group.shapes.end(),
                     [&](const Shape& s) { return s.spec == shape.spec && s.nonlinear == shape.nonlinear; });
}

}  // namespace

struct Shortlist::Candidate {
  std::size_t order;
  double gain;  // less the price
  bool fresh;   // its best shape is not among those that are asked
  Groups one;
};

Shortlist::Shortlist(const ResidualSpace& space, Questions& q) : q_(q) {
  lists_.push_back(QuestionList::causes(space));
  lists_.push_back(QuestionList::profiles(space));
  q_.asked = static_cast<int>(lists_[0].size());
  q_.profiles = static_cast<int>(lists_[1].size());
}

bool Shortlist::extend(Explanation& found, Explanation* other) {
  const Search search(q_);
  std::vector<Candidate> candidates = bestCandidates(search, found);
  first_ = false;
  if (candidates.empty()) return false;
  const bool any = std::any_of(candidates.begin(), candidates.end(),
                               [](const Candidate& c) { return c.fresh && c.gain > 0.0; });
  const std::vector<int> now = take(std::move(candidates));
  const auto move = [&](Explanation& one) {
    for (Member& m : one.members) m = search.moved(std::move(m), now[static_cast<std::size_t>(m.group)]);
  };
  move(found);
  if (other != nullptr) move(*other);
  return any;
}

std::vector<Shortlist::Candidate> Shortlist::bestCandidates(const Search& search, const Explanation& found) {
  const auto noise = search.evidenceAt(found);
  std::vector<Candidate> candidates;
  const std::size_t most = first_ ? kMostAtFirst : kMostLater;
  std::size_t before = 0;
  for (const QuestionList& list : lists_) {
    for (std::size_t first = 0, end = 0; first < list.size(); first = end) {
      end = list.endOfPart(first, kShapesTogether);
      const Groups part = list.made(first, end - first);
      if (first_) notShown_.insert(notShown_.end(), part.notShown.begin(), part.notShown.end());
      addCandidates(search, noise->ofGroups(part), part, before + first, found, candidates);
      std::stable_sort(candidates.begin(), candidates.end(),
                       [](const Candidate& a, const Candidate& b) { return a.gain > b.gain; });
      if (candidates.size() > most) candidates.resize(most);
    }
    before += list.size();
  }
  return candidates;
}

void Shortlist::addCandidates(const Search& search, const Evidence& evidence, const Groups& part,
                              std::size_t before, const Explanation& found,
                              std::vector<Candidate>& candidates) const {
  const std::vector<Group>& asked = q_.groups.groups;
  const Evidence::Given given = evidence.given(found.members);
  for (const Gain& g : evidence.gains(given)) {
    if (g.group < 0) continue;
    const std::size_t place = static_cast<std::size_t>(g.group);
    const Group& group = part.groups[place];
    const auto same =
        std::find_if(asked.begin(), asked.end(), [&](const Group& o) { return o.key == group.key; });
    // one that is asked already may have other shapes, now that something was found
    if (same != asked.end() &&
        (same->shapes.size() == group.shapes.size() || isMember(found, same - asked.begin())))
      continue;
    const bool fresh = same == asked.end() || !hasShape(*same, group.shapes[g.shape]);
    const double gain = g.value - search.priceOfOne(group);
    if (!first_ && gain < -kNear) continue;
    std::vector<double> ofShapes;
    evidence.gainOf(given, g.group, &ofShapes);
    candidates.push_back({before + place, gain, fresh, oneOf(part, place, bestOf(ofShapes))});
  }
}

std::vector<int> Shortlist::take(std::vector<Candidate> candidates) {
  struct Place {
    std::size_t order;
    long before;  // the group that it was; -1: none
    Groups one;
  };
  std::vector<Place> places;
  for (std::size_t g = 0; g < q_.groups.groups.size(); ++g)
    places.push_back({order_[g], static_cast<long>(g), oneOf(q_.groups, g)});
  for (Candidate& c : candidates) places.push_back({c.order, -1, std::move(c.one)});
  std::stable_sort(places.begin(), places.end(),
                   [](const Place& a, const Place& b) { return a.order < b.order; });
  std::vector<int> now(q_.groups.groups.size());
  order_.clear();
  std::vector<Groups> ones;
  for (Place& p : places) {
    if (p.before >= 0) now[static_cast<std::size_t>(p.before)] = static_cast<int>(order_.size());
    order_.push_back(p.order);
    ones.push_back(std::move(p.one));
  }
  Groups all = together(std::move(ones), q_.space->length());
  all.notShown = notShown_;
  q_.groups = std::move(all);
  return now;
}

}  // namespace mm
