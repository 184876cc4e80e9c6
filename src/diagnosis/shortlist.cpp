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

struct Candidate {
  std::size_t order;
  double gain;  // less the price
  bool fresh;   // its best shape is not among those that are asked
  Groups one;
};

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

}  // namespace

Shortlist::Shortlist(const ResidualSpace& space, Questions& q) : q_(q) {
  lists_.push_back(QuestionList::causes(space));
  lists_.push_back(QuestionList::profiles(space));
  q_.asked = static_cast<int>(lists_[0].size());
  q_.profiles = static_cast<int>(lists_[1].size());
}

bool Shortlist::extend(Explanation& found) {
  const Search search(q_);
  const auto noise = search.evidenceAt(found);
  std::vector<Candidate> candidates;
  const std::size_t most = first_ ? kMostAtFirst : kMostLater;
  std::size_t before = 0;
  for (const QuestionList& list : lists_) {
    for (std::size_t first = 0, end = 0; first < list.size(); first = end) {
      end = list.endOfPart(first, kShapesTogether);
      const Groups part = list.made(first, end - first);
      if (first_) notShown_.insert(notShown_.end(), part.notShown.begin(), part.notShown.end());
      const Evidence evidence = noise->ofGroups(part);
      const Evidence::Given given = evidence.given(found.members);
      for (const Gain& g : evidence.gains(given)) {
        if (g.group < 0) continue;
        const Group& group = part.groups[static_cast<std::size_t>(g.group)];
        const auto& asked = q_.groups.groups;
        const auto same =
            std::find_if(asked.begin(), asked.end(), [&](const Group& o) { return o.key == group.key; });
        // one that is asked already may have other shapes, now that something was found
        bool fresh = same == asked.end();
        if (!fresh) {
          if (same->shapes.size() == group.shapes.size() || isMember(found, same - asked.begin())) continue;
          fresh = std::none_of(same->shapes.begin(), same->shapes.end(), [&](const Shape& s) {
            return s.spec == group.shapes[g.shape].spec && s.nonlinear == group.shapes[g.shape].nonlinear;
          });
        }
        const double gain = g.value - search.priceOfOne(group);
        if (!first_ && gain < -kNear) continue;
        std::vector<double> ofShapes;
        evidence.gainOf(given, g.group, &ofShapes);
        candidates.push_back({before + first + static_cast<std::size_t>(g.group), gain, fresh,
                              oneOf(part, static_cast<std::size_t>(g.group), bestOf(ofShapes))});
      }
      std::stable_sort(candidates.begin(), candidates.end(),
                       [](const Candidate& a, const Candidate& b) { return a.gain > b.gain; });
      if (candidates.size() > most) candidates.resize(most);
    }
    before += list.size();
  }
  first_ = false;
  if (candidates.empty()) return false;

  // all in the order of the lists: of causes that act alike the first is named
  struct Place {
    std::size_t order;
    Groups one;
  };
  std::vector<Place> places;
  for (std::size_t g = 0; g < q_.groups.groups.size(); ++g)
    places.push_back({order_[g], oneOf(q_.groups, g)});
  bool any = false;
  for (Candidate& c : candidates) {
    any = any || (c.fresh && c.gain > 0.0);
    places.push_back({c.order, std::move(c.one)});
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const Place& a, const Place& b) { return a.order < b.order; });
  std::vector<std::string> keyOfMember;
  for (const Member& m : found.members) keyOfMember.push_back(q_.groups.groups[m.group].key);
  Groups all;
  order_.clear();
  int columns = 0;
  for (const Place& p : places) columns += static_cast<int>(p.one.columns.cols());
  all.columns.resize(q_.space->length(), columns);
  int at = 0;
  for (Place& p : places) {
    all.columns.middleCols(at, p.one.columns.cols()) = p.one.columns;
    for (Shape& s : p.one.groups[0].shapes) s.first += at;
    at += static_cast<int>(p.one.columns.cols());
    all.groups.push_back(std::move(p.one.groups[0]));
    order_.push_back(p.order);
  }
  for (const Group& g : all.groups) all.causes += !g.profile;
  all.notShown = notShown_;
  q_.groups = std::move(all);
  for (std::size_t j = 0; j < found.members.size(); ++j)
    for (std::size_t g = 0; g < q_.groups.groups.size(); ++g)
      if (q_.groups.groups[g].key == keyOfMember[j])
        found.members[j] = search.moved(std::move(found.members[j]), static_cast<int>(g));
  return any;
}

}  // namespace mm
