#include "nodes/live_inputs.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace mm {
namespace {

constexpr double kNanosecond = 1e-9;  // s
constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr std::int64_t kBlink =
    100000000;  // ns: what comes later than that out of order is a clock that went back
constexpr std::int64_t kDense = 5000000000;  // ns between the values that a history keeps
constexpr std::size_t kHistory = 20000;      // values: more than a day
constexpr int kClockWentBack = 5;            // stamps in a row that lie behind: it is no single bad one
constexpr double kDecayed = 7.0;             // time constants: a thousandth is left

int indexOf(const std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

}  // namespace

/// The past of one domain's sensors; made anew when a temperature has arrived, and only when it is asked.
class LiveInputs::History final : public YoungHistory {
 public:
  /// @param lower, upper calibrated range of each sensor, degC: where it may have been before it was heard.
  History(const LiveInputs& inputs, std::vector<int> sensors, std::vector<double> lower,
          std::vector<double> upper)
      : inputs_(inputs),
        sensors_(std::move(sensors)),
        lower_(std::move(lower)),
        upper_(std::move(upper)),
        other_(*this) {}

  double lagged(int sensor, double tau, double /*time*/, double* byTau) const override {
    if (!series_ || revision_ != inputs_.revision_) {
      std::vector<Series> past;
      for (const int place : sensors_) past.push_back(inputs_.sensors_[place].history);
      series_ = std::make_unique<SeriesHistory>(std::move(past));
      revision_ = inputs_.revision_;
    }
    longest_ = std::max(longest_, tau);
    return series_->lagged(sensor, tau, now(), byTau);
  }

  const TemperatureHistory* otherPast() const override {
    for (std::size_t s = 0; s < sensors_.size(); ++s)
      if (heardFor(static_cast<int>(s)) < kDecayed * longest_) return &other_;
    return nullptr;
  }

 private:
  /// The same where the sensor was elsewhere in its range before it was heard, at a standard deviation of a
  /// uniform distribution.
  class Other final : public TemperatureHistory {
   public:
    explicit Other(const History& heard) : heard_(heard) {}
    double lagged(int sensor, double tau, double time, double* byTau) const override {
      const double value = heard_.lagged(sensor, tau, time, byTau);
      if (sensor < 0 || sensor >= static_cast<int>(heard_.lower_.size()) || !(tau > 0.0)) return value;
      const auto& past = heard_.inputs_.sensors_[heard_.sensors_[sensor]].history.value;
      if (past.empty()) return value;
      const double away =
          std::max(past.front() - heard_.lower_[sensor], heard_.upper_[sensor] - past.front());
      return value + std::max(0.0, away) / std::sqrt(3.0) * std::exp(-heard_.heardFor(sensor) / tau);
    }

   private:
    const History& heard_;
  };

  double now() const { return static_cast<double>(inputs_.last_ - inputs_.origin_) * kNanosecond; }
  /// s since its first value.
  double heardFor(int sensor) const {
    const std::vector<double>& times = inputs_.sensors_[sensors_[sensor]].history.time;
    return times.empty() ? 0.0 : std::max(0.0, now() - times.front());
  }

  const LiveInputs& inputs_;
  std::vector<int> sensors_;
  std::vector<double> lower_, upper_;
  Other other_;
  mutable double longest_ = 0.0;  // time constant that was asked, s
  mutable std::unique_ptr<SeriesHistory> series_;
  mutable std::uint64_t revision_ = 0;
};

LiveInputs::LiveInputs(const Machine& machine, Settings settings) : settings_(settings) {
  for (const Joint& joint : machine.joints()) {
    joints_.push_back(joint.name);
    travel_.emplace_back(joint.kind == JointKind::kLinear ? settings.deadband : settings.rotaryDeadband);
  }
  seen_.assign(joints_.size(), 0);
  told_.resize(joints_.size());
  position_.assign(joints_.size(), kNotMeasured);
  velocity_ = position_;
}

void LiveInputs::orderFor(const std::vector<std::string>& names) {
  if (names == namesBefore_) return;
  namesBefore_ = names;
  order_.clear();
  for (const std::string& name : names) order_.push_back(indexOf(joints_, name));
}

void LiveInputs::forgetTravel(int joint) {
  travel_[joint].forget();
  told_[joint] = Told();
}

void LiveInputs::forget() {
  std::fill(seen_.begin(), seen_.end(), 0);
  for (std::size_t j = 0; j < joints_.size(); ++j) forgetTravel(static_cast<int>(j));
  for (Logged& logged : sensors_) logged = Logged();
  for (Logged& logged : covariates_) logged = Logged();
  ++revision_;
  last_ = origin_ = 0;
}

/// After the reading of a joint at last_. What the driver told of the time before counts first.
void LiveInputs::followTravel(int joint) {
  const Told& told = told_[joint];
  TravelTracker& tracker = travel_[joint];
  const bool known = told.direction != 0.0 && told.stamp <= last_;
  if (std::isnan(velocity_[joint])) {
    tracker.forget();  // a publisher that tells no velocity: nothing is guessed
  } else {
    if (known && told.stamp < last_) tracker.tell(told.stamp, told.direction);
    tracker.take(last_, position_[joint], velocity_[joint]);
  }
  if (known) tracker.tell(told.stamp, told.direction);
}

bool LiveInputs::takeJoints(std::int64_t stamp, const std::vector<std::string>& names,
                            const std::vector<double>& position, const std::vector<double>& velocity,
                            std::string& reason) {
  reason.clear();
  orderFor(names);
  if (std::all_of(order_.begin(), order_.end(), [](int joint) { return joint < 0; })) return false;
  if (stamp == 0) reason = "a joint state has no stamp";
  if (position.size() != names.size() || (!velocity.empty() && velocity.size() != names.size()))
    reason = "a joint state has " + std::to_string(names.size()) + " names, " +
             std::to_string(position.size()) + " positions and " + std::to_string(velocity.size()) +
             " velocities";
  if (!reason.empty()) return false;
  if (stamp < last_ - kBlink) forget();  // the clock went back, or a replay began again
  if (stamp < last_) reason = "a joint state is older than the one before";
  if (stamp <= last_) return false;
  last_ = stamp;
  if (origin_ == 0) origin_ = stamp;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const int j = order_[i];
    if (j < 0) continue;  // another machine's, or a gripper
    seen_[j] = stamp;
    position_[j] = position[i];
    velocity_[j] = velocity.empty() ? kNotMeasured : velocity[i];
    followTravel(j);
  }
  complete_ = false;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if (seen_[j] == 0)
      reason = "joint " + joints_[j] + " is missing in the joint states";
    else if (static_cast<double>(stamp - seen_[j]) * kNanosecond > settings_.jointAge)
      reason = "no reading of joint " + joints_[j] + " for " +
               std::to_string(static_cast<double>(stamp - seen_[j]) * kNanosecond) + " s";
    if (!reason.empty()) return false;
  }
  complete_ = true;
  return true;
}

bool LiveInputs::take(Logged& logged, std::int64_t stamp, double value) {
  if (stamp <= 0) return false;
  if (stamp < logged.stamp - kBlink) {
    if (++logged.behind < kClockWentBack) return false;
    logged = Logged();
  }
  if (stamp <= logged.stamp) return true;
  logged.behind = 0;
  if (origin_ == 0) origin_ = stamp;
  const bool gap = logged.stamp != 0 &&
                   static_cast<double>(stamp - logged.stamp) * kNanosecond > 10.0 * settings_.sensorAge;
  logged.stamp = stamp;
  logged.value = value;
  if (!std::isfinite(value)) return true;
  std::vector<double>&times = logged.history.time, &values = logged.history.value;
  if (gap) times.clear(), values.clear();  // what happened in between nobody knows
  const double t = static_cast<double>(stamp - origin_) * kNanosecond;
  // The last value moves on with the time until it is far enough from the one before to be kept.
  if (times.size() > 1 && t - times[times.size() - 2] < kDense * kNanosecond)
    times.pop_back(), values.pop_back();
  times.push_back(t);
  values.push_back(value);
  if (times.size() > kHistory) {
    times.erase(times.begin(), times.begin() + kHistory / 4);
    values.erase(values.begin(), values.begin() + kHistory / 4);
  }
  return true;
}

bool LiveInputs::takeTemperature(const std::string& name, std::int64_t stamp, double value) {
  const int sensor = indexOf(sensorNames_, name);
  if (sensor < 0) return true;
  ++revision_;
  return take(sensors_[sensor], stamp, value);
}

bool LiveInputs::takeCovariate(const std::string& name, std::int64_t stamp, double value) {
  const int covariate = indexOf(covariateNames_, name);
  return covariate < 0 || take(covariates_[covariate], stamp, value);
}

LiveInputs::View LiveInputs::watch(const Domain& domain) {
  View view;
  const auto place = [](const std::string& name, std::vector<std::string>& names,
                        std::vector<Logged>& logged) {
    int at = indexOf(names, name);
    if (at >= 0) return at;
    names.push_back(name);
    logged.emplace_back();
    return static_cast<int>(names.size()) - 1;
  };
  for (const std::string& name : domain.sensors) view.sensors.push_back(place(name, sensorNames_, sensors_));
  for (const std::string& name : domain.covariates)
    view.covariates.push_back(place(name, covariateNames_, covariates_));
  view.history = std::make_shared<History>(*this, view.sensors, domain.sensorLower, domain.sensorUpper);
  ++revision_;
  return view;
}

bool LiveInputs::heard(const View& view) const {
  const auto known = [](const std::vector<int>& places, const std::vector<Logged>& logged) {
    return std::all_of(places.begin(), places.end(), [&](int place) { return logged[place].stamp != 0; });
  };
  return known(view.sensors, sensors_) && known(view.covariates, covariates_);
}

double LiveInputs::at(const Logged& logged, std::int64_t stamp) const {
  if (logged.stamp == 0) return kNotMeasured;
  const double age = std::abs(static_cast<double>(stamp - logged.stamp)) * kNanosecond;
  return age > settings_.sensorAge ? kNotMeasured : logged.value;
}

void LiveInputs::fillLogged(const View& view, std::int64_t stamp, MovingState& state) const {
  state.time = zero_ == 0 ? kNotMeasured : static_cast<double>(stamp - zero_) * kNanosecond;
  state.temperature.resize(view.sensors.size());
  for (std::size_t s = 0; s < view.sensors.size(); ++s)
    state.temperature[s] = at(sensors_[view.sensors[s]], stamp);
  state.covariate.resize(view.covariates.size());
  for (std::size_t c = 0; c < view.covariates.size(); ++c)
    state.covariate[c] = at(covariates_[view.covariates[c]], stamp);
  state.history = view.history.get();
  state.travel.resize(travel_.size());
  state.sinceReversal.resize(travel_.size());
  state.back.resize(travel_.size());
  for (std::size_t j = 0; j < travel_.size(); ++j) {
    state.travel[j] = travel_[j].direction();
    const double since = travel_[j].sinceReversal();
    state.sinceReversal[j] = std::isnan(since) ? kFar : since;
    state.back[j] = travel_[j].back();
  }
}

void LiveInputs::fill(const View& view, MovingState& state) const {
  fillLogged(view, last_, state);
  state.position = position_;
  state.velocity = velocity_;
}

void LiveInputs::fill(const View& view, std::int64_t stamp, const std::vector<double>& position,
                      const std::vector<double>& velocity, MovingState& state) const {
  fillLogged(view, stamp, state);
  state.position = position;
  state.velocity = velocity;
  for (std::size_t j = 0; j < velocity.size(); ++j) {
    const double direction = directionOf(velocity[j]);
    if (direction == 0.0 || direction == state.travel[j]) continue;
    state.travel[j] = direction;
    state.sinceReversal[j] = kFar;
    state.back[j] = 0.0;
  }
}

}  // namespace mm
