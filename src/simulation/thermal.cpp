#include "simulation/thermal.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace mm {
namespace {

constexpr double kLongestStep = 5.0;     // s
constexpr double kRecordInterval = 1.0;  // s

}  // namespace

double HeatSchedule::at(double time) const {
  const double t = every > 0.0 && time >= 0.0 ? std::fmod(time, every) : time;
  return t >= from && t < to ? power : 0.0;
}

double Ambient::at(double time) const {
  return start + ramp * time + swing * std::sin(2.0 * kPi * time / period);
}

ThermalModel::ThermalModel(std::vector<Body> bodies, std::vector<Contact> contacts,
                           std::vector<HeatSchedule> heat, Ambient ambient)
    : bodies_(std::move(bodies)), contacts_(std::move(contacts)), heat_(std::move(heat)), ambient_(ambient) {
  temperatures_.assign(bodies_.size() + 1, ambient_.at(0.0));
  record();
}

void ThermalModel::addFollowers(const std::vector<Follower>& followers) {
  for (const Follower& f : followers) {
    followers_.push_back(f);
    temperatures_.push_back(temperatures_[f.body]);
  }
  recordTimes_.clear();
  records_.clear();
  record();
}

std::vector<Body> ThermalModel::usualBodies() {
  return {{"motor", 150.0, 0.15, 4.0, 0.3}, {"frame", 1400.0, 0.5, 0.0, 0.0}, {"bed", 500.0, 0.35, 0.0, 0.0}};
}

std::vector<Contact> ThermalModel::usualContacts() { return {{0, 1, 0.1}, {1, 2, 0.05}}; }

int ThermalModel::findBody(const std::string& name) const {
  const int air = bodyCount() - 1;
  for (int b = 0; b < air; ++b)
    if (bodies_[b].name == name) return b;
  return name == "air" ? air : -1;
}

void ThermalModel::rates(double time, double activity, const std::vector<double>& temperatures,
                         std::vector<double>& out) const {
  const double air = ambient_.at(time);
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    out[b] =
        bodies_[b].idlePower + activity * bodies_[b].motionPower - bodies_[b].toAir * (temperatures[b] - air);
  for (const HeatSchedule& heat : heat_) out[heat.body] += heat.at(time);
  for (const Contact& c : contacts_) {
    const double flow = c.conductance * (temperatures[c.first] - temperatures[c.second]);
    out[c.first] -= flow;
    out[c.second] += flow;
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) out[b] /= bodies_[b].capacity;
}

void ThermalModel::step(double seconds, double activity) {  // Runge-Kutta of fourth order
  const std::size_t n = bodies_.size();
  std::vector<double> leaders;
  for (const Follower& f : followers_) leaders.push_back(temperatures_[f.body]);
  std::vector<double> k1(n), k2(n), k3(n), k4(n), moved = temperatures_;
  const auto move = [&](const std::vector<double>& rate, double by) {
    for (std::size_t b = 0; b < n; ++b) moved[b] = temperatures_[b] + by * rate[b];
  };
  rates(time_, activity, temperatures_, k1);
  move(k1, 0.5 * seconds);
  rates(time_ + 0.5 * seconds, activity, moved, k2);
  move(k2, 0.5 * seconds);
  rates(time_ + 0.5 * seconds, activity, moved, k3);
  move(k3, seconds);
  rates(time_ + seconds, activity, moved, k4);
  for (std::size_t b = 0; b < n; ++b)
    temperatures_[b] += seconds / 6.0 * (k1[b] + 2.0 * k2[b] + 2.0 * k3[b] + k4[b]);
  time_ += seconds;
  temperatures_[n] = ambient_.at(time_);
  for (std::size_t f = 0; f < followers_.size(); ++f) {
    const double before = leaders[f], after = temperatures_[followers_[f].body], lag = followers_[f].lag;
    // exact for a leader that goes straight within the step
    const double slope = (after - before) / seconds, decay = std::exp(-seconds / lag);
    double& value = temperatures_[n + 1 + f];
    value = after - slope * lag + (value - before + slope * lag) * decay;
  }
}

void ThermalModel::advance(double seconds, double activity) {
  double fastest = kLongestStep;
  for (int b = 0; b < bodyCount() - 1; ++b) {
    double conductance = bodies_[b].toAir;
    for (const Contact& c : contacts_)
      if (c.first == b || c.second == b) conductance += c.conductance;
    fastest = std::min(fastest, 0.2 * (bodies_[b].capacity / conductance));  // of its time constant
  }
  while (seconds > 0.0) {
    const double dt = std::min(seconds, fastest);
    step(dt, activity);
    seconds -= dt;
    if (time_ - recordTimes_.back() >= kRecordInterval) record();
  }
}

void ThermalModel::record() {
  recordTimes_.push_back(time_);
  records_.push_back(temperatures_);
}

std::vector<double> ThermalModel::recorded(double time) const {
  if (time <= recordTimes_.front()) return records_.front();
  if (time >= time_) return temperatures_;
  const auto after = std::upper_bound(recordTimes_.begin(), recordTimes_.end(), time);
  const std::size_t i = after - recordTimes_.begin();
  const bool beyond = after == recordTimes_.end();
  const double t0 = recordTimes_[i - 1], t1 = beyond ? time_ : recordTimes_[i];
  const std::vector<double>& a = records_[i - 1];
  const std::vector<double>& b = beyond ? temperatures_ : records_[i];
  std::vector<double> between(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) between[k] = a[k] + (b[k] - a[k]) * (time - t0) / (t1 - t0);
  return between;
}

double TemperatureSensor::read(Random& random) const {
  const double reading = value() + noise_ * random.normal();
  return step_ > 0.0 ? step_ * std::round(reading / step_) : reading;
}

void TemperatureSensor::advance(double seconds, double bodyTemperature) {
  value_ =
      lag_ > 0.0 ? bodyTemperature + (value_ - bodyTemperature) * std::exp(-seconds / lag_) : bodyTemperature;
}

}  // namespace mm
