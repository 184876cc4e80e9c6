#include "ros_bridge/bag_session.h"

#include <sensor_msgs/JointState.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/names_of.h"
#include "base/text.h"
#include "ros_bridge/bag_writer.h"
#include "ros_bridge/message_conversion.h"
#include "session/gross_rows.h"

namespace mm {
namespace {

constexpr double kHeardFirst = 1.0;  // s

/// The file under a temporary name; removed unless it was put in place.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::filesystem::path& target) : target_(target), path_(target) {
    path_ += ".part-" + std::to_string(::getpid());
  }
  ~TemporaryFile() {
    std::error_code ignored;
    if (!done_) std::filesystem::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  std::string path() const { return path_.string(); }

  void putInPlace() {
    std::error_code error;
    std::filesystem::rename(path_, target_, error);
    if (error) throw InputError(target_.string() + ": cannot be moved into place: " + error.message());
    done_ = true;
  }

 private:
  std::filesystem::path target_, path_;
  bool done_ = false;
};

/// Everything of a session, in the order of time, into an open bag.
class SessionWriter {
 public:
  SessionWriter(const Session& session, const std::vector<MotionSample>& motion, BagWriter& bag)
      : session_(session), motion_(motion), bag_(bag), epoch_(std::llround(session.epoch * 1e9)) {
    if (epoch_ <= 0) epoch_ = 1000000000LL * 1000000000LL;  // a simulated or hand-made session has no date
    for (const Series& s : session.temperatures)
      series_.push_back({&s, kTemperatureTopics + topicOf(s.name)});
    for (const Series& s : session.covariates) series_.push_back({&s, kCovariateTopics + topicOf(s.name)});
  }

  void write(const ProgressCallback& progress) {
    const ros::Time start = rosTime(epoch_);
    bag_.write("/robot_description", start, toText(session_.machine.urdf()), true);
    auto artifact = toMessage(session_.artifact);
    artifact.header.stamp = start;
    bag_.write("/artifact", start, artifact, true);
    if (session_.compensation.stated != ControllerCompensation::Stated::kNot)
      bag_.write(kCompensationTopic, start, toText(compensationJson(session_.compensation)), true);
    if (!session_.timesAssumed.empty())
      bag_.write(kTimesAssumedTopic, start, toText(session_.timesAssumed), true);
    if (!session_.rowFile.empty()) {
      // before the first motion, which is read by the file's directions and not by its own; by as much as a
      // node needs to hear it first, however fast the bag is played
      const double first = motion_.empty() ? 0.0 : std::min(0.0, motion_.front().time);
      const std::int64_t before = epoch_ + std::llround((first - kHeardFirst) * 1e9);
      bag_.write("/imported_from", rosTime(std::max<std::int64_t>(before, 1)), toText(session_.rowFile),
                 true);
    }
    std::size_t count = 0;
    for (const Observation& o : session_.observations) {
      writeSeries(o.time);
      writeMotion(o.time);
      writeObservation(o);
      if (progress && ++count % 4096 == 0)
        progress(static_cast<double>(count) / static_cast<double>(session_.observations.size()));
    }
    writeSeries(INFINITY);
    writeMotion(INFINITY);
  }

 private:
  struct Cursor {
    const Series* series;
    std::string topic;
    std::size_t next = 0;
  };

  ros::Time stamp(double time) const { return rosTime(epoch_ + std::llround(time * 1e9)); }

  /// What was logged up to `time`.
  void writeSeries(double time) {
    for (Cursor& c : series_) {
      for (; c.next < c.series->time.size() && c.series->time[c.next] <= time; ++c.next) {
        const ros::Time at = stamp(c.series->time[c.next]);
        const double value = c.series->value[c.next];
        if (startsWith(c.topic, kTemperatureTopics)) {
          sensor_msgs::Temperature message;
          message.header.stamp = at;
          const std::string& name = c.series->name;  // stands in the topic, where a topic can hold it
          message.header.frame_id = topicOf(name) == name ? "workpiece" : name;
          message.temperature = value;
          bag_.write(c.topic, at, message);
        } else {
          measuring_machine::Covariate message;
          message.header.stamp = at;
          message.name = c.series->name;
          message.unit = c.series->unit;
          message.value = value;
          bag_.write(c.topic, at, message);
        }
      }
    }
  }

  /// The joints' motion up to `time`.
  void writeMotion(double time) {
    for (; nextMotion_ < motion_.size() && motion_[nextMotion_].time <= time; ++nextMotion_) {
      const MotionSample& sample = motion_[nextMotion_];
      sensor_msgs::JointState message;
      message.header.stamp = stamp(sample.time);
      message.name = allNames(session_.machine.joints());
      message.position = sample.position;
      message.velocity = sample.velocity;
      bag_.write("/joint_states", message.header.stamp, message);
    }
  }

  void writeObservation(const Observation& o) {
    const auto write = [&](const char* topic, auto message) {
      message.header.stamp = stamp(o.time);
      // The line of the file that /imported_from names; 0: none.
      message.header.seq = session_.rowFile.empty() ? 0U : static_cast<std::uint32_t>(o.row);
      bag_.write(topic, message.header.stamp, message);
    };
    if (o.kind == ObservationKind::kContact)
      write("/probe/contact", toContactMessage(o, session_));
    else
      write("/reference", toReferenceMessage(o, session_));
  }

  const Session& session_;
  const std::vector<MotionSample>& motion_;
  std::size_t nextMotion_ = 0;
  BagWriter& bag_;
  std::int64_t epoch_;  // ns
  std::vector<Cursor> series_;
};

}  // namespace

void writeSessionBag(const Session& session, const std::filesystem::path& file,
                     const ProgressCallback& progress, const std::vector<MotionSample>& motion) {
  if (session.observations.empty())
    throw InputError(session.source + ": the session is empty, so nothing is written");
  TemporaryFile temporary(file);
  BagWriter bag(temporary.path(), file.string());
  Session whole = session;  // nothing that was measured is lost
  takeBackGrossRows(whole);
  SessionWriter(whole, motion, bag).write(progress);
  bag.close();
  temporary.putInPlace();
  if (progress) progress(1.0);
}

}  // namespace mm
