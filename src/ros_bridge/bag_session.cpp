#include "ros_bridge/bag_session.h"

#include <sensor_msgs/JointState.h>
#include <std_msgs/String.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
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
    std_msgs::String urdf;
    urdf.data = session_.machine.urdf();
    bag_.write("/robot_description", start, urdf, true);
    auto artifact = toMessage(session_.artifact);
    artifact.header.stamp = start;
    bag_.write("/artifact", start, artifact, true);
    if (session_.compensation.stated != ControllerCompensation::Stated::kNot) {
      std_msgs::String compensation;
      compensation.data = compensationJson(session_.compensation);
      bag_.write(kCompensationTopic, start, compensation, true);
    }
    if (!session_.timesAssumed.empty()) {
      std_msgs::String how;
      how.data = session_.timesAssumed;
      bag_.write(kTimesAssumedTopic, start, how, true);
    }
    if (!session_.rowFile.empty()) {
      std_msgs::String file;
      file.data = session_.rowFile;
      // before the first motion, which is read by the file's directions and not by its own; by as much as a
      // node needs to hear it first, however fast the bag is played
      const double first = motion_.empty() ? 0.0 : std::min(0.0, motion_.front().time);
      const std::int64_t before = epoch_ + std::llround((first - kHeardFirst) * 1e9);
      bag_.write("/imported_from", rosTime(std::max<std::int64_t>(before, 1)), file, true);
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
      for (const Joint& joint : session_.machine.joints()) message.name.push_back(joint.name);
      message.position = sample.position;
      message.velocity = sample.velocity;
      bag_.write("/joint_states", message.header.stamp, message);
    }
  }

  void writeObservation(const Observation& o) {
    const ros::Time at = stamp(o.time);
    if (o.kind == ObservationKind::kContact) {
      auto message = toContactMessage(o, session_);
      message.header.stamp = at;
      message.header.seq = rowOf(o);
      bag_.write("/probe/contact", at, message);
    } else {
      auto message = toReferenceMessage(o, session_);
      message.header.stamp = at;
      message.header.seq = rowOf(o);
      bag_.write("/reference", at, message);
    }
  }

  /// The line of the file that /imported_from names; 0: none.
  std::uint32_t rowOf(const Observation& o) const {
    return session_.rowFile.empty() ? 0U : static_cast<std::uint32_t>(o.row);
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
