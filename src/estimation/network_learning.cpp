#include "estimation/network_learning.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "base/format.h"
#include "base/range.h"
#include "base/units.h"
#include "estimation/network_samples.h"
#include "thermal/network_choice.h"
#include "thermal/ridge.h"
#include "thermal/sensor_selection.h"
#include "thermal/thermal_network.h"

namespace mm {
namespace {

constexpr int kSamplesForSets = 30;  // fewer say too little about the information of sets of sensors
constexpr int kGreySensors = 4;      // as many as DFNN takes
constexpr int kLargestSensorSet = 3;
constexpr double kSmallestGain = 0.1;  // of a network that says something of the axis

/// Held-out errors of all that were tried, the chosen one first.
std::string figuresOf(const NetworkChoice& choice, JointKind joint) {
  const bool linear = joint == JointKind::kLinear;
  const double unit = linear ? kMicrometre : kArcsecond;
  const NetworkTrial& chosen = choice.chosen();
  std::string words = format("held out %.3g %s", chosen.heldOutRms / unit, linear ? "um" : "arcsec");
  for (auto trial = choice.trials.rbegin(); trial != choice.trials.rend(); ++trial) {
    if (trial->name == chosen.name) continue;
    words += format("%s %s %.3g", words.find(';') == std::string::npos ? ";" : ",",
                    trial->name == "ridge" ? "ridge-linear" : trial->name.c_str(), trial->heldOutRms / unit);
  }
  return words;
}

/// What works, how large it is, and why it does.
std::string wordsOf(const ThermalNetwork& network, const NetworkWish& wish, const NetworkChoice& choice) {
  std::string words = nameOf(network.kind()) + " active";
  if (network.rules() > 1)
    words += ", " + std::to_string(network.rules()) +
             (network.kind() == NetworkKind::kRbf ? " centres" : " rules");
  if (choice.kind && wish == choice.kind) return words;
  return words + (choice.kind ? ", " : ", kept although ") + choice.reason;
}

/// Held out: of what works, else of what was asked for; of ridge-linear; of none.
void takeFigures(LearnedNetwork& learned, const NetworkWish& wish, const NetworkChoice& choice) {
  learned.heldOut =
      choice.kind || !wish ? choice.chosen().heldOutRms : choice.find(nameOf(*wish))->heldOutRms;
  learned.heldOutRidge = choice.find("ridge")->heldOutRms;
  learned.heldOutNone = choice.find("none")->heldOutRms;
}

/// One network: its axis, its samples, and what is learned from them.
class Learner {
 public:
  Learner(const EffectSpec& spec, const Domain& domain, NetworkSamples samples,
          const CalibrateOptions& options)
      : spec_(spec), domain_(domain), samples_(std::move(samples)), options_(options) {
    axis_ = domain.findJoint(spec.text("axis"));
    wish_ = networkWish(spec.text("network"));
    chooseSensors();
    keepKnown();
  }

  LearnedNetwork run() {
    const auto goOn = [this] { return !(options_.cancelled && options_.cancelled()); };
    const NetworkChoice choice = chooseNetwork(wish_, inputs_, outputs_, {}, goOn);
    LearnedNetwork learned;
    learned.effect = spec_.yaml();
    learned.positions = samples_.positions;
    for (const int s : sensors_) learned.sensors.push_back(domain_.sensors[static_cast<std::size_t>(s)]);
    takeFigures(learned, wish_, choice);
    learned.active = choice.kind.has_value();
    std::unique_ptr<ThermalNetwork> network;
    if (choice.kind) {
      network = makeNetwork(*choice.kind);
      network->fit(inputs_, outputs_);
      learned.numbers = network->toNumbers();
      predicted_ = choice.chosen().predicted - network->evaluateAll(inputs_);
    } else {
      predicted_ = Eigen::MatrixXd::Zero(outputs_.rows(), outputs_.cols());
    }
    learned.summary = summaryOf(learned, choice, network.get());
    return learned;
  }

  /// After run(): held-out minus full prediction at an observation, m or rad; 0 outside the sets.
  double shift(int observation, double reading) const {
    const int set = samples_.setOf[static_cast<std::size_t>(observation)];
    const int row = set < 0 ? -1 : rowOf_[static_cast<std::size_t>(set)];
    return row < 0 ? 0.0 : samples_.at(reading, predicted_.row(row));
  }
  int axis() const { return axis_; }

 private:
  bool varies(int sensor) const {
    Range range;
    for (const double t : samples_.temperatures.col(sensor)) range.add(t);
    return range.size() > 0.0;
  }

  void chooseSensors() {
    if (const EffectSpec::Value* listed = spec_.find("sensors"); listed != nullptr && listed->list) {
      for (const std::string& name : listed->items) {
        sensors_.push_back(domain_.findSensor(name));
        if (!varies(sensors_.back()))
          throw InputError(
              "effect " + spec_.yaml() + ": temperature " + name +
              " does not vary in this session, so the network cannot be trained on it; check the sensor, or "
              "omit it");
      }
      return;
    }
    std::vector<int> candidates;
    for (int s = 0; s < static_cast<int>(domain_.sensors.size()); ++s)
      if (varies(s) && samples_.temperatures.col(s).allFinite()) candidates.push_back(s);
    if (candidates.empty())
      throw InputError("effect " + spec_.yaml() +
                       ": no temperature of the session varies and is known throughout; log the temperatures "
                       "of the parts that warm up, or list the sensors");
    const Eigen::MatrixXd x = samples_.temperatures(Eigen::all, candidates);
    std::vector<int> chosen;
    grey_ = spec_.text("sensors") == "grey_grade" || x.rows() < kSamplesForSets;
    if (grey_) {
      const Eigen::VectorXd grade = greyRelationalGrade(x, samples_.error);
      chosen.resize(candidates.size());
      std::iota(chosen.begin(), chosen.end(), 0);
      std::stable_sort(chosen.begin(), chosen.end(), [&](int a, int b) { return grade[a] > grade[b]; });
      if (chosen.size() > kGreySensors) chosen.resize(kGreySensors);
    } else {
      SelectionSettings settings;
      settings.largestSize = kLargestSensorSet;
      settings.threads = options_.threads;
      settings.seed = options_.seed;
      const SensorSelection selection = selectSensors(x, samples_.mainError(), settings);
      chosen = selection.sets[selection.recommended].sensors;
    }
    std::sort(chosen.begin(), chosen.end());
    for (const int c : chosen) sensors_.push_back(candidates[static_cast<std::size_t>(c)]);
  }

  /// Sets of which every chosen temperature is known.
  void keepKnown() {
    std::vector<int> rows;
    rowOf_.assign(static_cast<std::size_t>(samples_.temperatures.rows()), -1);
    for (int k = 0; k < static_cast<int>(rowOf_.size()); ++k) {
      const bool known = std::all_of(sensors_.begin(), sensors_.end(),
                                     [&](int s) { return std::isfinite(samples_.temperatures(k, s)); });
      if (!known) continue;
      rowOf_[static_cast<std::size_t>(k)] = static_cast<int>(rows.size());
      rows.push_back(k);
    }
    if (static_cast<int>(rows.size()) < kFewestSets)
      throw InputError("effect " + spec_.yaml() + ": its temperatures are known in " +
                       std::to_string(rows.size()) + " sets of measurements only; training needs at least " +
                       std::to_string(kFewestSets));
    inputs_ = samples_.temperatures(rows, sensors_);
    outputs_ = rowsOf(samples_.error, rows);
  }

  std::string summaryOf(const LearnedNetwork& l, const NetworkChoice& choice,
                        const ThermalNetwork* network) const {
    std::string summary = figuresOf(choice, domain_.joints[static_cast<std::size_t>(axis_)].kind) + "; " +
                          std::to_string(outputs_.rows()) + " sets, " + std::to_string(l.positions.size()) +
                          (l.positions.size() == 1 ? " position, from " : " positions, from ");
    for (std::size_t s = 0; s < l.sensors.size(); ++s) summary += (s == 0 ? "" : ", ") + l.sensors[s];
    if (spec_.find("sensors") == nullptr || !spec_.find("sensors")->list)
      summary += grey_ ? " (highest grey grade)" : " (by prediction)";
    return (network != nullptr
                ? wordsOf(*network, wish_, choice)
                : (wish_ ? nameOf(*wish_) : std::string("network")) + " not activated, " + choice.reason) +
           ": " + summary;
  }

  EffectSpec spec_;
  const Domain& domain_;
  NetworkSamples samples_;
  const CalibrateOptions& options_;
  int axis_ = 0;
  NetworkWish wish_;
  bool grey_ = false;
  std::vector<int> sensors_;          // of the domain
  std::vector<int> rowOf_;            // a set: its row below, -1: a temperature is not known
  Eigen::MatrixXd inputs_, outputs_;  // sets x sensors, degC; sets x positions, m or rad
  Eigen::MatrixXd predicted_;         // after run(): held-out minus full prediction
};

}  // namespace

bool hasToLearn(const Model& model) {
  return std::any_of(model.effects().begin(), model.effects().end(),
                     [&](const EffectPtr& e) { return e->nature().learned && e->network() == nullptr; });
}

LearnedModel learnNetworks(const Session& session, const Model& model, const CalibrateOptions& options,
                           const Eigen::VectorXd& start) {
  // the physical effects first, with all rows: what they do not explain is no outlier yet
  std::vector<EffectPtr> physical;
  std::vector<double> given;
  for (std::size_t e = 0; e < model.effects().size(); ++e) {
    const EffectPtr& effect = model.effects()[e];
    if (effect->nature().learned) continue;
    physical.push_back(effect);
    for (int k = 0; k < effect->parameterCount(); ++k)
      given.push_back(start.size() == model.parameterCount()
                          ? start[model.offset(static_cast<int>(e)) + k]
                          : effect->parameters()[static_cast<std::size_t>(k)].start);
  }
  CalibrateOptions first = options;
  first.method = Method::kLeastSquares;
  if (first.weights.size() == 0) first.rejectOutliers = false;
  const auto report = [&](double share) {
    if (options.cancelled && options.cancelled()) throw Cancelled("stopped before the networks had learned");
    if (options.progress) options.progress("networks", share);
  };
  first.progress = {};
  const Domain& domain = model.domain();
  report(0.0);
  CalibrationResult fitted =
      calibrate(session, Model(model.machine(), domain, physical), first,
                Eigen::Map<const Eigen::VectorXd>(given.data(), static_cast<Eigen::Index>(given.size())));
  if (fitted.cancelled) throw Cancelled("stopped before the networks had learned");
  const Linearisation at = linearise(*fitted.problem, fitted.x);

  const auto& observations = session.observations;
  Eigen::MatrixXd shift = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(observations.size()),
                                                static_cast<Eigen::Index>(domain.joints.size()));
  Eigen::VectorXd residuals = fitted.residuals;
  std::vector<EffectPtr> effects;
  std::vector<double> values;
  int taken = 0, learnedSoFar = 0;
  const auto networks = std::count_if(model.effects().begin(), model.effects().end(),
                                      [](const EffectPtr& e) { return e->nature().learned; });
  for (const EffectPtr& effect : model.effects()) {
    if (!effect->nature().learned) {
      effects.push_back(effect);
      for (int k = 0; k < effect->parameterCount(); ++k) values.push_back(fitted.x[taken++]);
      continue;
    }
    report(static_cast<double>(learnedSoFar++) / static_cast<double>(networks));
    Learner learner(
        effect->spec(), fitted.problem->model().domain(),
        gatherNetworkSamples(at, residuals, fitted.weight, domain.findJoint(effect->spec().text("axis"))),
        options);
    effects.push_back(effect->taught(learner.run(), domain));
    if (!effects.back()->network()->active) continue;
    values.push_back(1.0);
    for (std::size_t o = 0; o < observations.size(); ++o)
      shift(static_cast<Eigen::Index>(o), learner.axis()) += learner.shift(
          static_cast<int>(o), observations[o].position[static_cast<std::size_t>(learner.axis())]);
    const double one = 1.0;  // the next network learns what this one leaves
    const Eigen::MatrixXd columns = at.effectColumns(*effects.back(), {one});
    for (Eigen::Index i = 0; i < residuals.size(); ++i)
      if (std::isfinite(columns(i, 0))) residuals[i] += columns(i, 0);
  }
  report(1.0);
  LearnedModel learned{
      Model(model.machine(), domain, effects),
      Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())),
      std::move(shift)};
  return learned;
}

namespace {

/// Widens the ranges of the sensors by those of other samples.
void widen(Domain& domain, const Eigen::MatrixXd& temperatures) {
  for (Eigen::Index s = 0; s < temperatures.cols(); ++s)
    for (Eigen::Index k = 0; k < temperatures.rows(); ++k) {
      double &low = domain.sensorLower[static_cast<std::size_t>(s)],
             &high = domain.sensorUpper[static_cast<std::size_t>(s)];
      low = std::fmin(low, temperatures(k, s));
      high = std::fmax(high, temperatures(k, s));
    }
}

/// Samples of two sessions, the older ones first.
Eigen::MatrixXd below(const Eigen::MatrixXd& first, const Eigen::MatrixXd& second) {
  Eigen::MatrixXd both(first.rows() + second.rows(), first.cols());
  both << first, second;
  return both;
}

/// The old network taught new sets, or, where another kind is to work, one that learns all sets.
std::unique_ptr<ThermalNetwork> taught(const ThermalNetwork& old, NetworkKind kind, const Eigen::MatrixXd& x,
                                       const Eigen::MatrixXd& y) {
  if (kind == old.kind()) {
    std::unique_ptr<ThermalNetwork> network = networkFromNumbers(old.toNumbers());
    network->update(x, y);
    return network;
  }
  std::unique_ptr<ThermalNetwork> network = makeNetwork(kind);
  network->fit(below(old.sampleInputs(), x), below(old.sampleOutputs(), y));
  return network;
}

/// What an update with all blocks but one leaves of that one; of a single set, what the old network leaves.
Eigen::MatrixXd heldOutUpdate(const ThermalNetwork& old, NetworkKind kind, const Eigen::MatrixXd& x,
                              const Eigen::MatrixXd& y) {
  if (x.rows() < 2) return old.evaluateAll(x) - y;
  Eigen::MatrixXd left(y.rows(), y.cols());
  for (const Fold& fold : blockedFolds(static_cast<int>(x.rows()), std::min(10, static_cast<int>(x.rows()))))
    left.middleRows(fold.test.front(), static_cast<Eigen::Index>(fold.test.size())) =
        taught(old, kind, rowsOf(x, fold.train), rowsOf(y, fold.train))->evaluateAll(rowsOf(x, fold.test)) -
        rowsOf(y, fold.test);
  return left;
}

}  // namespace

UpdatedNetworks updateNetworks(const CalibrationResult& held) {
  const Problem& problem = *held.problem;
  const Model& model = problem.model();
  UpdatedNetworks updated;
  updated.domain = model.domain();
  updated.networks = model.networks();
  const Linearisation at = linearise(problem, held.x);
  double squares[3] = {0.0, 0.0, 0.0};
  Eigen::Index values = 0;
  for (std::size_t e = 0; e < model.effects().size(); ++e) {
    const EffectSpec& spec = model.effects()[e]->spec();
    for (LearnedNetwork& learned : updated.networks) {
      if (learned.effect != spec.yaml() || !learned.active) continue;
      const double gain = held.x[model.offset(static_cast<int>(e))];
      if (!(std::abs(gain) > kSmallestGain))
        throw InputError("effect " + learned.effect + ": its gain is " + std::to_string(gain) +
                         ", so the network has almost no effect; calibrate again");
      const NetworkSamples samples = gatherNetworkSamples(
          at, held.residuals, held.weight, model.domain().findJoint(spec.text("axis")), learned.positions);
      std::vector<int> sensors;
      for (const std::string& name : learned.sensors) sensors.push_back(model.domain().findSensor(name));
      const Eigen::MatrixXd x = samples.temperatures(Eigen::all, sensors);
      const std::unique_ptr<ThermalNetwork> network = networkFromNumbers(learned.numbers);
      if (!x.allFinite())
        throw InputError(problem.session().source + ": effect " + learned.effect +
                         ": one of its temperatures is not known throughout; log all of them");
      const Eigen::MatrixXd y = network->evaluateAll(x) + samples.error / gain;
      squares[0] += samples.error.squaredNorm();
      // which kind works is asked again, of the sets of all sessions
      const NetworkWish wish = networkWish(spec.text("network"));
      const NetworkChoice choice =
          chooseNetwork(wish, below(network->sampleInputs(), x), below(network->sampleOutputs(), y));
      const NetworkKind kind = choice.kind.value_or(network->kind());
      squares[2] += (gain * heldOutUpdate(*network, kind, x, y)).squaredNorm();
      const std::unique_ptr<ThermalNetwork> now = taught(*network, kind, x, y);
      squares[1] += (gain * (now->evaluateAll(x) - y)).squaredNorm();
      values += y.size();
      learned.numbers = now->toNumbers();
      takeFigures(learned, wish, choice);
      const int axis = model.domain().findJoint(spec.text("axis"));
      learned.summary += "; updated with " + std::to_string(x.rows()) + " sets of " +
                         problem.session().source + ": " + wordsOf(*now, wish, choice) + ", all " +
                         std::to_string(now->samples()) + " sets " +
                         figuresOf(choice, model.domain().joints[static_cast<std::size_t>(axis)].kind);
      updated.effects.push_back(learned.effect);
      updated.sets += static_cast<int>(x.rows());
      widen(updated.domain, samples.temperatures);
    }
  }
  if (updated.effects.empty())
    throw InputError("the calibration has no active thermal_network to update; add one (mm add)");
  const double n = static_cast<double>(values);
  updated.before = std::sqrt(squares[0] / n);
  updated.after = std::sqrt(squares[1] / n);
  updated.heldOut = std::sqrt(squares[2] / n);
  return updated;
}

}  // namespace mm
