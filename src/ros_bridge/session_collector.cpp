#include "ros_bridge/session_collector.h"

#include <tinyxml2.h>

#include <algorithm>
#include <cmath>

#include "base/erase_if.h"
#include "base/error.h"
#include "base/names_of.h"
#include "base/nearest_name.h"
#include "ros_bridge/bounded_log.h"
#include "session/time_stamp.h"

namespace mm {
namespace {

const char* const kContactTopic = "/probe/contact";
const char* const kReferenceTopic = "/reference";

template <typename Message>
constexpr bool kIsContact = std::is_same_v<Message, measuring_machine::ProbeContact>;
template <typename Message>
const char* const kTopic = kIsContact<Message> ? kContactTopic : kReferenceTopic;

/// The name in `<robot name="…">`: what messages call a machine that has no file.
std::string robotName(const std::string& urdf) {
  tinyxml2::XMLDocument document;
  const bool parsed = document.Parse(urdf.c_str(), urdf.size()) == tinyxml2::XML_SUCCESS;
  const tinyxml2::XMLElement* robot = parsed ? document.FirstChildElement("robot") : nullptr;
  const char* name = robot != nullptr ? robot->Attribute("name") : nullptr;
  return name != nullptr ? name : "robot_description";
}

/// Of one of several messages, ns.
template <typename OneOf>
std::int64_t stampIn(const OneOf& message) {
  return std::visit([](const auto& m) { return nanoseconds(m.header.stamp); }, message);
}

}  // namespace

std::int64_t SessionCollector::stampOf(const ros::Time& stamp) {
  if (stamp.isZero()) throw InputError("its header has no stamp; the time of the reading is needed");
  const std::int64_t ns = nanoseconds(stamp);
  earliest_ = earliest_ ? std::min(*earliest_, ns) : ns;
  return ns;
}

void SessionCollector::addRobotDescription(const std::string& urdf) {
  if (machine_ && machine_->urdf() == urdf) return;
  if (machine_) throw InputError(source_ + ": /robot_description changes within the session");
  try {
    setMachine(Machine(urdf, robotName(urdf)));
  } catch (const InputError& e) {
    throw InputError(source_ + ": " + e.what());
  }
}

void SessionCollector::setMachine(Machine machine) {
  machine_ = std::move(machine);
  for (const auto& message : waiting_) std::visit([this](const auto& m) { convert(m); }, message);
  waiting_.clear();
}

void SessionCollector::addArtifact(const measuring_machine::Artifact& message) {
  try {
    artifact_ = fromMessage(message);
  } catch (const InputError& e) {
    throw InputError(source_ + ": /artifact: " + e.what());
  }
  if (!message.header.stamp.isZero()) artifactStamp_ = stampOf(message.header.stamp);
}

template <typename Message>
void SessionCollector::add(const Message& message) {
  const std::int64_t before = kIsContact<Message> ? contactCount_ : referenceCount_;
  if (!roomFor(kTopic<Message>, before + 1, nanoseconds(message.header.stamp))) return;
  if (machine_)
    convert(message);
  else
    waiting_.emplace_back(message);
}
template void SessionCollector::add(const measuring_machine::ProbeContact& message);
template void SessionCollector::add(const measuring_machine::ReferenceMeasurement& message);

template <typename Message>
void SessionCollector::convert(const Message& message) {
  const std::int64_t number = kIsContact<Message> ? ++contactCount_ : ++referenceCount_;
  try {
    Observation o = fromMessage(message, *machine_);
    for (std::size_t j = 0; j < o.position.size(); ++j)
      if (!std::isfinite(o.position[j]))
        throw InputError("the reading of joint '" + machine_->joints()[j].name + "' is not a number");
    for (const double v : o.velocity)
      if (std::isinf(v)) throw InputError("a velocity is infinite");
    for (const double v : o.deviation)
      if (std::isinf(v)) throw InputError("a deviation is infinite");
    for (const double v : o.deviationStd)
      if (std::isinf(v) || v <= 0.0) throw InputError("a deviation's standard deviation must be above 0");
    if (std::isinf(o.laserReading)) throw InputError("the laser's reading is infinite");
    if (o.reference.array().isInf().any()) throw InputError("a reference position is infinite");
    o.row = number;
    const std::int64_t stamp = stampOf(message.header.stamp);
    if constexpr (kIsContact<Message>) {
      if (message.feature.empty())
        throw InputError("no feature is assigned; name the ball or point that was touched");
      o.feature = features_[message.feature];
    } else {
      if (!message.setup.empty()) o.setup = setups_[message.setup];
      if (!message.feature.empty()) o.feature = features_[message.feature];
      if (o.kind == ObservationKind::kLength &&
          !(std::isfinite(o.length) && (o.setup >= 0 || o.length > 0.0)))
        throw InputError("'length' must be a number, above 0 without a setup");
    }
    o.stylus = styli_[message.stylus];
    o.placement = placements_[message.placement];
    rows_.push_back({stamp, std::move(o), message.header.seq});
  } catch (const InputError& e) {
    refuse(kTopic<Message>, static_cast<std::size_t>(number), e.what(), nanoseconds(message.header.stamp));
  }
}

std::vector<std::string> SessionCollector::refused() const {
  std::vector<std::string> all;
  for (const Refused& r : refused_) all.push_back(r.inWords() + ": " + r.why);
  return all;
}

void SessionCollector::addValue(Logged& logged, const std::string& topic, const ros::Time& stamp,
                                double value) {
  ++logged.messages;
  if (stamp.isZero()) {
    refuse(topic, logged.messages, "its header has no stamp; the time of the reading is needed", 0);
    return;
  }
  const std::int64_t ns = stampOf(stamp);
  if (!std::isfinite(value)) {
    ++logged.lost;
    return;
  }
  logged.dropped +=
      makeRoom(logged.values, most_, artifactStamp_.value_or(0), [](const auto& v) { return v.first; });
  logged.values.emplace_back(ns, value);
}

void SessionCollector::addTemperature(const std::string& sensor, const sensor_msgs::Temperature& message) {
  const std::string name = sensorOf(sensor, message.header.frame_id);
  if (!roomForName(temperatures_, name)) return;
  Logged& logged = temperatures_[name];
  logged.unit = "degC";
  addValue(logged, "/temperature/" + sensor, message.header.stamp, message.temperature);
}

void SessionCollector::addCovariate(const measuring_machine::Covariate& message) {
  const std::string topic = "/covariate/" + topicOf(message.name);
  if (!roomForName(covariates_, message.name)) return;
  Logged& logged = covariates_[message.name];
  if (logged.messages > 0 && logged.unit != message.unit) {
    ++logged.messages;
    refuse(topic, logged.messages, "its unit '" + message.unit + "' was '" + logged.unit + "' before",
           nanoseconds(message.header.stamp));
    return;
  }
  logged.unit = message.unit;
  addValue(logged, topic, message.header.stamp, message.value);
}

void SessionCollector::addJointState(const sensor_msgs::JointState& message, const std::string& publisher) {
  if (message.header.stamp.isZero()) return;  // says nothing about when
  travel_.take(message, publisher, machine_ ? &*machine_ : nullptr, artifactStamp_.value_or(0));
}

/// What /joint_states adds to the contacts: the direction of the last motion before a contact at standstill,
/// or before one whose velocity was not latched.
void SessionCollector::fillTravel(std::vector<Row>& rows) const {
  for (std::size_t j = 0; j < machine_->joints().size(); ++j) {
    const std::vector<TravelLog::Motion> motions = travel_.motions(machine_->joints()[j].name);
    if (motions.empty() && !travel_.earliest(machine_->joints()[j].name)) continue;
    auto next = motions.begin();
    TravelLog::Motion last{0, 0.0};
    for (Row& row : rows) {
      Observation& o = row.observation;
      while (next != motions.end() && next->stamp <= row.stamp) last = *next++;
      o.travel.resize(machine_->joints().size(), 0.0);
      const double direction = directionOf(o.velocity[j]);
      if (direction == 0.0)
        o.travel[j] = last.direction;
      else
        last = {row.stamp, direction};
    }
  }
}

std::int64_t SessionCollector::startOf(const std::vector<Row>& rows) const {
  if (artifactStamp_ && *artifactStamp_ <= rows.front().stamp) return *artifactStamp_;
  std::int64_t earliest = *earliest_;
  for (const Joint& joint : machine_->joints())
    if (const auto first = travel_.earliest(joint.name)) earliest = std::min(earliest, *first);
  return earliest;
}

std::int64_t SessionCollector::newest() const {
  std::int64_t newest = 0;
  for (const Row& row : rows_) newest = std::max(newest, row.stamp);
  for (const auto& message : waiting_) newest = std::max(newest, stampIn(message));
  return newest;
}

void SessionCollector::renumber() {
  contactCount_ = referenceCount_ = 0;
  for (Row& row : rows_)
    row.observation.row =
        row.observation.kind == ObservationKind::kContact ? ++contactCount_ : ++referenceCount_;
}

template <typename Gone>
void SessionCollector::drop(Gone gone) {
  eraseIf(rows_, [&](const Row& row) { return gone(row.stamp); });
  eraseIf(waiting_, [&](const auto& message) { return gone(stampIn(message)); });
  eraseIf(refused_, [&](const Refused& r) { return gone(r.stamp); });
  renumber();
}

void SessionCollector::dropAfter(std::int64_t stamp) {
  drop([&](std::int64_t at) { return at >= stamp; });
  eraseIf(refused_, [](const Refused& r) { return r.stamp == 0; });
  for (std::map<std::string, Logged>* all : {&temperatures_, &covariates_})
    for (auto& [name, logged] : *all) eraseIf(logged.values, [&](const auto& v) { return v.first >= stamp; });
  counted_.clear();  // what they counted is gone
  travel_.dropAfter(stamp);
}

void SessionCollector::dropBefore(std::int64_t stamp) {
  drop([&](std::int64_t at) { return at < stamp; });
  // Of what was logged the last value before the stamp still counts.
  for (std::map<std::string, Logged>* all : {&temperatures_, &covariates_})
    for (auto& [name, logged] : *all) {
      std::int64_t last = 0;
      for (const auto& [at, value] : logged.values)
        if (at <= stamp) last = std::max(last, at);
      eraseIf(logged.values, [&](const auto& v) { return v.first < last; });
      logged.messages = logged.values.size();
      logged.lost = logged.dropped = 0;
    }
  refusedMore_ = 0;
  eraseIf(counted_, [&](const Counted& c) { return nanoseconds(c.session) < stamp; });
  travel_.dropBefore(stamp);
  earliest_ = stamp;
}

std::vector<Series> SessionCollector::series(const std::map<std::string, Logged>& all, std::int64_t start,
                                             std::string& warning) const {
  std::vector<Series> result;
  for (const auto& [name, logged] : all) {
    if (logged.lost > 0)
      addWords(warning,
               std::to_string(logged.lost) + " readings of '" + name + "' are not numbers and were ignored");
    if (logged.dropped > 0)
      addWords(warning, std::to_string(logged.dropped) + " readings of '" + name +
                            "', the oldest of the session, have been dropped");
    auto values = logged.values;
    std::stable_sort(values.begin(), values.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    Series s{name, logged.unit, {}, {}};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto& [stamp, value] = values[i];
      if (i + 1 < values.size() && values[i + 1].first <= start) continue;
      s.time.push_back(secondsBetween(start, stamp));
      s.value.push_back(value);
    }
    result.push_back(std::move(s));
  }
  return result;
}

Session SessionCollector::build() const {
  std::vector<Refused> refused = refused_;
  const auto empty = [&] {
    const std::string first = refused.empty()
                                  ? std::string()
                                  : "; of " + std::to_string(refused.size()) +
                                        " that cannot be used the first: " + refused.front().inWords() +
                                        ": " + refused.front().why;
    return InputError(source_ + ": the session is empty: no message on /probe/contact or /reference" + first);
  };
  if (observationCount() == 0) throw empty();
  if (!machine_)
    throw InputError(source_ + ": topic /robot_description is missing; it describes the machine");
  if (contactCount_ > 0 && !artifact_)
    throw InputError(source_ + ": topic /artifact is missing; it describes what the contacts touched");
  Session session(*machine_);
  session.source = source_;
  session.compensation = compensation_;
  session.timesAssumed = timesAssumed_;
  if (artifact_) session.artifact = *artifact_;
  std::vector<int> features, styli;
  for (const std::string& name : styli_.all())
    styli.push_back(name.empty() ? 0 : session.artifact.findStylus(name));
  for (const std::string& name : features_.all()) features.push_back(session.artifact.findFeature(name));
  std::vector<Row> rows = rows_;
  std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.stamp < b.stamp; });
  fillTravel(rows);
  session.warning = lacking(rows);
  const auto unknown = [&](const Row& row) {
    const Observation& o = row.observation;
    const bool contact = o.kind == ObservationKind::kContact;
    const auto refuse = [&](const char* what, const std::string& name,
                            const std::vector<std::string>& known) {
      refused.push_back({contact ? kContactTopic : kReferenceTopic, static_cast<std::size_t>(o.row),
                         std::string(what) + " '" + name + "' is not in artifact '" + session.artifact.name +
                             "'" + didYouMean(name, known),
                         row.stamp});
      return true;
    };
    if (o.feature >= 0 && features[o.feature] < 0)
      return refuse("feature", features_.all()[o.feature], allNames(session.artifact.features));
    return styli[o.stylus] < 0 && refuse("stylus", styli_.all()[o.stylus], allNames(session.artifact.styli));
  };
  eraseIf(rows, unknown);
  if (rows.empty()) throw empty();
  const std::int64_t start = startOf(rows);
  const bool lines = !importedFrom_.empty() &&
                     std::all_of(rows.begin(), rows.end(), [](const Row& row) { return row.line > 0; });
  if (lines) session.rowFile = importedFrom_;
  for (Row& row : rows) {
    Observation& o = row.observation;
    o.time = secondsBetween(start, row.stamp);
    o.stylus = styli[o.stylus];
    if (o.feature >= 0) o.feature = features[o.feature];
    if (lines) o.row = row.line;
    session.observations.push_back(std::move(o));
  }
  session.setups = setups_.all();
  session.placements = placements_.all();
  session.temperatures = series(temperatures_, start, session.warning);
  session.covariates = series(covariates_, start, session.warning);
  session.epoch = secondsBetween(0, start);
  for (const Refused& r : refused) {
    SetAside& aside = session.setAside.emplace_back();
    aside.field = r.inWords();
    aside.why = r.why;
  }
  addWords(session.warning, travel_.lacking());
  if (refusedMore_ > 0)
    addWords(session.warning, std::to_string(refusedMore_) + " more messages were set aside");
  session.prepare();
  return session;
}

}  // namespace mm
