// What a session collector does not keep, and how it says so.
#include <algorithm>

#include "ros_bridge/bounded_log.h"
#include "ros_bridge/session_collector.h"

namespace mm {
namespace {

// Of a bounded collector: messages set aside of which more than the number is kept, and sessions counted.
constexpr std::size_t kMostRefused = 1000, kMostSessions = 1000;

}  // namespace

void SessionCollector::refuse(const std::string& topic, std::size_t number, const std::string& why,
                              std::int64_t stamp) {
  if (most_ > 0 && refused_.size() >= kMostRefused)
    ++refusedMore_;
  else
    refused_.push_back({topic, number, why, stamp});
}

bool SessionCollector::roomFor(const char* topic, std::size_t number, std::int64_t stamp) {
  if (most_ == 0 || observationCount() < most_) return true;
  refuse(topic, number,
         "the session has " + std::to_string(most_) + " measurements, which is the limit; begin a new one",
         stamp);
  return false;
}

bool SessionCollector::roomForName(const std::map<std::string, Logged>& all, const std::string& name) {
  if (most_ == 0 || all.size() < kMostLoggedNames || all.count(name) != 0) return true;
  refuse("'" + name + "'", 1, std::to_string(kMostLoggedNames) + " others are logged, which is the limit", 0);
  return false;
}

void SessionCollector::addMeasured(const measuring_machine::Measured& message) {
  for (Counted& counted : counted_)
    if (counted.session == message.header.stamp) {
      counted.contacts = message.contacts;
      return;
    }
  if (counted_.size() >= kMostSessions) counted_.erase(counted_.begin());
  counted_.push_back({message.header.stamp, message.contacts});
}

/// How many of the contacts that were measured are here; empty: all. A count stands for its session, up to
/// the stamp of the next one: of one that was over before the first contact here nothing is lacking.
std::string SessionCollector::lacking(const std::vector<Row>& rows) const {
  std::size_t measured = 0, heard = refusedMore_;
  for (std::size_t i = 0; i < counted_.size(); ++i) {
    const auto next = std::find_if(counted_.begin() + static_cast<std::ptrdiff_t>(i) + 1, counted_.end(),
                                   [](const Counted& c) { return !c.session.isZero(); });
    const std::int64_t begin = nanoseconds(counted_[i].session);
    const bool ours = next == counted_.end() || std::any_of(rows.begin(), rows.end(), [&](const Row& row) {
                        return row.stamp >= begin && row.stamp < nanoseconds(next->session);
                      });
    if (ours) measured += counted_[i].contacts;
  }
  for (const Row& row : rows) heard += row.observation.kind == ObservationKind::kContact ? 1 : 0;
  for (const Refused& r : refused_) heard += r.topic == "/probe/contact" ? 1 : 0;
  if (heard >= measured) return {};
  return std::to_string(heard) + " of " + std::to_string(measured) +
         " measured contacts were received: the others came before the node or recorder started; measure "
         "those again, or use a bag that contains them";
}

}  // namespace mm
