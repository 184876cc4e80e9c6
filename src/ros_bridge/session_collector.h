#pragma once
#include <measuring_machine/Measured.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/numbered_names.h"
#include "ros_bridge/message_conversion.h"
#include "ros_bridge/travel_log.h"
#include "session/session.h"

namespace mm {

/// Gathers the messages of a session, from a bag or live, and makes the session of them: the same messages
/// give the same session to the bit, in whatever order the topics arrived. A contact, reference or logged
/// value that is wrong is set aside by its topic and number; the rest is the session. Not thread-safe.
class SessionCollector {
 public:
  /// @param source what messages for people call the session.
  explicit SessionCollector(std::string source) : source_(std::move(source)) {}

  // @throw InputError naming source and topic: a machine or artifact that cannot be read.
  void addRobotDescription(const std::string& urdf);
  /// The file that the session was imported from, empty: none. The headers' `seq` are its lines.
  void addImportedFrom(const std::string& file) {
    importedFrom_ = file;
    travel_.trustVelocities(!file.empty());
  }
  /// What the controller compensates, as compensationJson; the last one counts.
  void addCompensation(const std::string& json) { compensation_ = parseCompensation(json, source_); }
  /// Session::timesAssumed.
  void addTimesAssumed(const std::string& how) { timesAssumed_ = how; }
  /// The last one counts; without a stamp it is announced once more, and the session began when it began.
  void addArtifact(const measuring_machine::Artifact& message);
  void addContact(const measuring_machine::ProbeContact& message) { add(message); }
  void addReference(const measuring_machine::ReferenceMeasurement& message) { add(message); }
  void addTemperature(const std::string& sensor, const sensor_msgs::Temperature& message);
  void addCovariate(const measuring_machine::Covariate& message);
  /// @param publisher its node: of a joint only one counts, see TravelLog.
  void addJointState(const sensor_msgs::JointState& message, const std::string& publisher);
  /// Whose the joints are that it names.
  void addStatus(const measuring_machine::AxisStatus& message, const std::string& publisher) {
    travel_.take(message, publisher);
  }
  /// How many contacts a measure node has brought: those that are not here are told in the session's warning.
  void addMeasured(const measuring_machine::Measured& message);

  /// Bounds what is kept, as a server that runs for weeks needs it: observations beyond are set aside and
  /// counted; of what is logged, what lies before the session goes first, then the oldest, and the warning
  /// says so. Without a call everything is kept, as of a bag.
  void bound(std::size_t most) {
    most_ = most;
    travel_.bound(most);
  }

  /// Forgets everything stamped earlier (ns): a new session begins there. Live only.
  void dropBefore(std::int64_t stamp);
  /// Forgets everything stamped at that time or later (ns): the clock went back. Live only.
  void dropAfter(std::int64_t stamp);
  /// Stamp of the newest observation, ns; 0: none yet.
  std::int64_t newest() const;

  /// What was set aside so far, "/probe/contact message 3: why".
  std::vector<std::string> refused() const;
  std::size_t refusedCount() const { return refused_.size() + refusedMore_; }
  std::size_t observationCount() const { return rows_.size() + waiting_.size(); }  ///< so far
  bool hasMachine() const { return machine_.has_value(); }                         ///< a URDF was heard
  /// Used when there is no robot description. @throw InputError when messages do not fit it.
  void setMachine(Machine machine);

  /// The prepared session. It begins (t = 0) at the stamp of /artifact, where that has one no later than the
  /// first observation; of what was logged before it only the last value counts. So a recorder that was
  /// started earlier gives the same session. Else t = 0 is the earliest stamp of all messages.
  /// @throw InputError when there is no machine, no observation, or a bad value.
  Session build() const;

 private:
  struct Row {
    std::int64_t stamp;  // ns
    Observation observation;
    std::uint32_t line = 0;  // in the file of /imported_from; 0: not from one
  };
  struct Logged {
    std::string unit;
    std::vector<std::pair<std::int64_t, double>> values;  // stamp in ns, value
    std::size_t messages = 0, lost = 0, dropped = 0;      // lost: not a number; dropped: for want of room
  };
  struct Counted {
    ros::Time session;  // with which stamp of /artifact it began; zero: it goes on
    std::uint32_t contacts;
  };
  struct Refused {
    std::string topic;
    std::size_t number;
    std::string why;
    std::int64_t stamp;  // ns; 0: it has none
    std::string inWords() const { return topic + " message " + std::to_string(number); }
  };

  std::int64_t stampOf(const ros::Time& stamp);
  void refuse(const std::string& topic, std::size_t number, const std::string& why, std::int64_t stamp);
  /// @return whether there is room for one observation more; else it is counted as set aside.
  bool roomFor(const char* topic, std::size_t number, std::int64_t stamp);
  bool roomForName(const std::map<std::string, Logged>& all, const std::string& name);
  std::string lacking(const std::vector<Row>& rows) const;
  template <typename Message>
  void add(const Message& message);
  template <typename Message>
  void convert(const Message& message);
  /// Forgets what was measured, waits or was refused at stamps (ns) for which `gone` holds.
  template <typename Gone>
  void drop(Gone gone);
  void addValue(Logged& logged, const std::string& topic, const ros::Time& stamp, double value);
  void renumber();
  std::int64_t startOf(const std::vector<Row>& rows) const;
  void fillTravel(std::vector<Row>& rows) const;
  std::vector<Series> series(const std::map<std::string, Logged>& all, std::int64_t start,
                             std::string& warning) const;

  std::string source_, importedFrom_;
  ControllerCompensation compensation_;
  std::string timesAssumed_;
  std::optional<Machine> machine_;
  std::optional<Artifact> artifact_;
  std::vector<std::variant<measuring_machine::ProbeContact, measuring_machine::ReferenceMeasurement>>
      waiting_;            // for the machine
  std::vector<Row> rows_;  // in the order of arrival; `feature`, `stylus` … count in the lists below
  NumberedNames features_, setups_, placements_, styli_;
  std::map<std::string, Logged> temperatures_, covariates_;
  TravelLog travel_;
  std::vector<Refused> refused_;
  std::size_t refusedMore_ = 0;   // of which only the number is kept
  std::vector<Counted> counted_;  // in the order of arrival
  std::size_t most_ = 0;          // 0: without bound
  std::int64_t contactCount_ = 0, referenceCount_ = 0;
  std::optional<std::int64_t> earliest_, artifactStamp_;
};

}  // namespace mm
