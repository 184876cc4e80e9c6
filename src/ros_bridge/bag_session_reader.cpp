#include <std_msgs/String.h>

#include <algorithm>
#include <map>

#include "base/error.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "ros_bridge/bag_reader.h"
#include "ros_bridge/bag_session.h"
#include "ros_bridge/bag_writer.h"
#include "ros_bridge/checked_stream.h"
#include "ros_bridge/session_collector.h"
#include "session/assumed_travel.h"
#include "session/joined.h"

namespace mm {
namespace {

/// An older version of a message, which ended before the fields that it has now: as bytes 0 these are empty.
struct OlderVersion {
  const char* md5;
  std::size_t missing;  // bytes
};

template <typename Message>
const std::vector<OlderVersion> kOlder = {};
template <>
const std::vector<OlderVersion> kOlder<measuring_machine::Artifact> = {
    {"2901c4140fcd49a8ea7858e0305e0f38", 8}};
template <>
const std::vector<OlderVersion> kOlder<measuring_machine::ProbeContact> = {
    {"b4c29775d90e8a19f75fcdbca4598966", 8}};
template <>
const std::vector<OlderVersion> kOlder<measuring_machine::ReferenceMeasurement> = {
    {"eeba7cd1b94dfc51f75c0202a252cc66", 20},   // without placement, stylus, feature and length
    {"a482de645c806787ff92691de62d6090", 16},   // without stylus, feature and length
    {"82269c670d85bc4d38c304750d8ffddf", 12}};  // without feature and length

/// One message of a bag as `Message`. @throw InputError when the topic holds another type.
template <typename Message>
Message decode(const BagMessage& raw, const std::string& source) {
  namespace traits = ros::message_traits;
  const BagConnection& c = *raw.connection;
  const auto older = std::find_if(kOlder<Message>.begin(), kOlder<Message>.end(),
                                  [&](const OlderVersion& version) { return c.md5 == version.md5; });
  const bool isOlder = older != kOlder<Message>.end();
  if (c.md5 != traits::MD5Sum<Message>::value() && !isOlder)
    throw InputError(source + ": topic " + c.topic + " holds " + c.type +
                     (c.type == traits::DataType<Message>::value()
                          ? " of another version"
                          : std::string(", but ") + traits::DataType<Message>::value() + " is needed"));
  Message message;
  std::vector<std::uint8_t> filled;
  if (isOlder) {
    filled.assign(raw.data, raw.data + raw.size);
    filled.resize(raw.size + older->missing, 0);
  }
  CheckedStream stream(isOlder ? filled.data() : raw.data, isOlder ? filled.size() : raw.size);
  try {
    stream.next(message);
  } catch (const ros::serialization::StreamOverrunException&) {
    throw InputError(source + ": topic " + c.topic +
                     " holds a message that is shorter than its type; the bag is damaged");
  }
  return message;
}

constexpr const char* kStatus = "/status";  // of an axis driver, whatever that is called

/// "/m1/probe/contact" is "/probe/contact" in the namespace "/m1".
struct SessionTopic {
  std::string space, topic;  // topic empty: nothing of a session
};

SessionTopic splitTopic(const BagConnection& connection) {
  const std::string& full = connection.topic;
  // One of another version of this package says nothing that is needed.
  if (connection.md5 == ros::message_traits::MD5Sum<measuring_machine::AxisStatus>::value()) {
    const std::string driver = full.substr(0, full.rfind('/'));
    return {driver.substr(0, std::max<std::size_t>(driver.rfind('/') + 1, 1) - 1), kStatus};
  }
  for (const char* name :
       {"/probe/contact", "/reference", "/joint_states", "/artifact", "/robot_description", "/imported_from",
        "/measure/measured", kCompensationTopic.c_str(), kTimesAssumedTopic.c_str()}) {
    if (endsWith(full, name)) return {full.substr(0, full.size() - std::string(name).size()), name};
  }
  for (const std::string& start : {kTemperatureTopics, kCovariateTopics}) {
    const std::size_t at = full.find(start);
    if (at != std::string::npos && at + start.size() < full.size())
      return {full.substr(0, at), full.substr(at)};
  }
  return {};
}

std::string shown(const std::string& space) { return space.empty() ? "/" : space; }

std::string normalised(std::string space) {
  while (!space.empty() && space.back() == '/') space.pop_back();
  return space.empty() || space[0] == '/' ? space : "/" + space;
}

/// The sessions of all namespaces of a bag: only at its end it is known which one is meant.
class NamespacedSessions {
 public:
  explicit NamespacedSessions(std::string source) : source_(std::move(source)) {}

  void take(const BagMessage& raw) {
    const auto [known, fresh] = topics_.try_emplace(raw.connection->topic);
    if (fresh) {
      known->second = splitTopic(*raw.connection);
      const std::string& caller = raw.connection->caller;
      byUs_ = byUs_ || caller == kBagWriterName;
      byOthers_ = byOthers_ || (!caller.empty() && caller != kBagWriterName) ||
                  known->second.topic == "/imported_from";
    }
    if (known->second.topic.empty()) return;
    One& one = all_.try_emplace(known->second.space, source_).first->second;
    if (!one.wrong.empty()) return;
    try {
      add(known->second.topic, raw, one.session);
    } catch (const InputError& e) {
      one.wrong = e.what();  // counts if it is this one
    }
  }

  /// @return the chosen one; null: there is no measurement anywhere. @throw InputError.
  SessionCollector* choose(const BagNamespace& where) {
    std::vector<std::string> holding;
    for (const auto& [space, one] : all_)
      if (one.session.observationCount() > 0) holding.push_back(space);
    const std::string wanted = normalised(where.name);
    if (std::find(holding.begin(), holding.end(), wanted) != holding.end()) return checked(wanted);
    if (where.required)
      throw InputError(source_ + ": holds no measurement in namespace " + shown(wanted) +
                       "; there is one in: " + words(holding));
    if (holding.size() > 1)
      throw InputError(source_ + ": holds the sessions of several machines, in the namespaces " +
                       words(holding) + "; choose one with --namespace " + shown(holding.front()) +
                       " (of a service: ask the calibration_server in that namespace)");
    if (holding.size() == 1) return checked(holding.front());
    for (const auto& [space, one] : all_)
      if (!one.wrong.empty()) throw InputError(one.wrong);
    return nullptr;
  }

  /// Whether this package wrote the bag without a file that it imported.
  bool simulated() const { return byUs_ && !byOthers_; }

 private:
  struct One {
    explicit One(const std::string& source) : session(source) {}
    SessionCollector session;
    std::string wrong;  // the first message that is
  };

  void add(const std::string& topic, const BagMessage& raw, SessionCollector& session) {
    if (topic == "/probe/contact")
      session.addContact(decode<measuring_machine::ProbeContact>(raw, source_));
    else if (topic == "/reference")
      session.addReference(decode<measuring_machine::ReferenceMeasurement>(raw, source_));
    else if (topic == "/joint_states")
      session.addJointState(decode<sensor_msgs::JointState>(raw, source_), raw.connection->caller);
    else if (topic == kStatus)
      session.addStatus(decode<measuring_machine::AxisStatus>(raw, source_), raw.connection->caller);
    else if (topic == "/artifact")
      session.addArtifact(decode<measuring_machine::Artifact>(raw, source_));
    else if (topic == "/robot_description")
      session.addRobotDescription(decode<std_msgs::String>(raw, source_).data);
    else if (topic == kCompensationTopic)
      session.addCompensation(decode<std_msgs::String>(raw, source_).data);
    else if (topic == kTimesAssumedTopic)
      session.addTimesAssumed(decode<std_msgs::String>(raw, source_).data);
    else if (topic == "/imported_from")
      session.addImportedFrom(decode<std_msgs::String>(raw, source_).data);
    else if (topic == "/measure/measured")
      session.addMeasured(decode<measuring_machine::Measured>(raw, source_));
    else if (topic.rfind(kTemperatureTopics, 0) == 0)
      session.addTemperature(topic.substr(kTemperatureTopics.size()),
                             decode<sensor_msgs::Temperature>(raw, source_));
    else
      session.addCovariate(decode<measuring_machine::Covariate>(raw, source_));
  }

  SessionCollector* checked(const std::string& space) {
    One& one = all_.at(space);
    if (!one.wrong.empty()) throw InputError(one.wrong);
    return &one.session;
  }

  static std::string words(const std::vector<std::string>& spaces) {
    std::vector<std::string> names;
    for (const std::string& space : spaces) names.push_back(shown(space));
    return listOf(names);
  }

  std::string source_;
  std::map<std::string, SessionTopic> topics_;
  std::map<std::string, One> all_;
  bool byUs_ = false, byOthers_ = false;
};

/// See bagSpace, of one bag.
std::string spaceOf(const std::filesystem::path& file, const std::string& wanted) {
  std::string found;
  for (const BagConnection& connection : BagReader(file).indexedConnections()) {
    const SessionTopic split = splitTopic(connection);
    if (split.topic != "/probe/contact" && split.topic != "/reference") continue;
    if (connection.caller.empty() || connection.caller == kBagWriterName) continue;
    if (!wanted.empty() && normalised(wanted) == split.space) return shown(split.space);
    if (found.empty()) found = shown(split.space);
  }
  return found;
}

}  // namespace

Session readSessionBag(const std::filesystem::path& file, const ProgressCallback& progress,
                       const Machine* fallback, const BagNamespace& where) {
  BagReader bag(file);
  const std::string source = file.string();
  NamespacedSessions sessions(source);
  bag.read([&](const BagMessage& message) { sessions.take(message); }, progress);
  SessionCollector* const collector = sessions.choose(where);
  if (collector == nullptr) {
    const std::string damage = bag.damage().empty() ? "" : " (" + bag.damage() + ")";
    throw InputError(
        source +
        ": holds no measurement: /probe/contact and /reference are missing or empty; topics found: " +
        listOf(bag.topics()) + damage);
  }
  if (!collector->hasMachine() && fallback != nullptr) collector->setMachine(*fallback);
  Session session = collector->build();
  session.simulated = sessions.simulated();
  assumeTravel(session);
  if (!bag.damage().empty())
    session.warning = bag.damage() + (session.warning.empty() ? "" : "; " + session.warning);
  return session;
}

std::vector<std::string> bagPaths(const std::string& bags) {
  std::vector<std::string> paths;
  if (std::filesystem::exists(bags)) return {bags};  // whose name has a colon
  for (std::size_t begin = 0; begin <= bags.size();) {
    const std::size_t end = std::min(bags.find(':', begin), bags.size());
    if (end == begin)
      throw InputError("'" + bags + "': a path is empty; several bags are separated by single colons");
    paths.push_back(bags.substr(begin, end - begin));
    begin = end + 1;
  }
  return paths;
}

Session readSessionBags(const std::vector<std::string>& bags, const ProgressCallback& progress,
                        const Machine* fallback, const BagNamespace& where) {
  std::vector<Session> sessions;
  for (std::size_t i = 0; i < bags.size(); ++i) {
    const auto share = [&](double done) {
      progress((static_cast<double>(i) + done) / static_cast<double>(bags.size()));
    };
    sessions.push_back(
        readSessionBag(bags[i], progress ? ProgressCallback(share) : ProgressCallback(), fallback, where));
  }
  return joined(std::move(sessions));
}

std::string bagSpace(const std::string& bags, const std::string& wanted) {
  for (const std::string& bag : bagPaths(bags))
    if (std::string space = spaceOf(bag, wanted); !space.empty()) return space;
  return {};
}

}  // namespace mm
