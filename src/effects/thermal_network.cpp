#include "thermal/thermal_network.h"

#include <algorithm>
#include <array>

#include "base/error.h"
#include "effects/catalogue_effect.h"
#include "effects/quantity.h"
#include "effects/special_laws.h"

namespace mm {
namespace {

constexpr std::size_t kMostOutputs = 64;  // as many positions as a Domain keeps
constexpr std::size_t kMostInputs = 64;

class ThermalNetworkEffect : public CatalogueEffect {
 public:
  explicit ThermalNetworkEffect(SpecReader& read)
      : CatalogueEffect(read, Stage::kAxis), axis_(read.joint("axis")) {
    std::vector<std::string> listed;
    if (read.isList("sensors"))
      for (const int sensor : read.sensorList("sensors")) listed.push_back(read.domain().sensors[sensor]);
    else
      read.choice("sensors", {"auto", "grey_grade"});
    read.choice("network", {"auto", "dfnn", "rbf", "ridge"});
    if (listed.size() > kMostInputs) read.fail("at most 64 sensors");
    if (read.domain().sensors.empty())
      read.fail("the session has no temperatures; log them (columns <sensor>_degC), or leave the effect out");
    nature_.composite = nature_.learned = true;
    nature_.shapeKeys = {"network"};
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    if (!network_) return;
    const int slot = layout_.axis(axis_);
    std::array<double, kMostInputs> x;
    std::array<double, kMostOutputs> y;
    bool known = true;
    for (std::size_t i = 0; i < sensors_.size(); ++i) {
      x[i] = state.temperature[sensors_[i]];
      known = known && x[i] == x[i];
    }
    if (!known) return sink.add(slot, 0, p[0], kUnknown);
    network_->evaluate(x.data(), y.data());
    const double q = state.position[axis_];
    const auto after = std::upper_bound(positions_.begin(), positions_.end(), q);
    const std::size_t i = static_cast<std::size_t>(after - positions_.begin());
    if (i == 0) return sink.add(slot, 0, p[0], y[0]);
    if (i == positions_.size()) return sink.add(slot, 0, p[0], q == q ? y[i - 1] : kUnknown);
    const double share = (q - positions_[i - 1]) / (positions_[i] - positions_[i - 1]);
    sink.add(slot, 0, p[0], (1.0 - share) * y[i - 1] + share * y[i]);
  }

  const LearnedNetwork* network() const override { return learned_.get(); }
  EffectPtr taught(const LearnedNetwork& learned, const Domain& domain) const override {
    auto effect = std::make_shared<ThermalNetworkEffect>(*this);
    effect->learned_ = std::make_shared<const LearnedNetwork>(learned);
    effect->network_.reset();
    effect->parameters_.clear();
    effect->sensors_.clear();
    if (learned.active) effect->adoptNetwork(learned, domain);
    return effect;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError("effect " + spec().yaml() + ": " + what);
  }

  void adoptNetwork(const LearnedNetwork& learned, const Domain& domain) {
    try {
      network_ = networkFromNumbers(learned.numbers);
    } catch (const InputError& e) {
      fail(e.what());
    }
    for (const std::string& name : learned.sensors) {
      sensors_.push_back(domain.findSensor(name));
      if (sensors_.back() < 0)
        fail("its sensor '" + name + "' is not among the temperatures; there are: " + listOfSensors(domain) +
             "; was it renamed? Calibrate again");
    }
    positions_ = learned.positions;
    const bool fits = network_->inputs() == static_cast<int>(sensors_.size()) && !sensors_.empty() &&
                      sensors_.size() <= kMostInputs && !positions_.empty() &&
                      positions_.size() <= kMostOutputs &&
                      network_->outputs() == static_cast<int>(positions_.size()) &&
                      std::is_sorted(positions_.begin(), positions_.end());
    if (!fits) fail("the stored network does not fit its sensors and positions; calibrate again");
    parameters_ = {parameter("gain", Unit{"1", 1.0}, 1.0, 10.0)};
  }

  static std::string listOfSensors(const Domain& domain) {
    std::string text;
    for (const std::string& s : domain.sensors) text += (text.empty() ? "" : ", ") + s;
    return text;
  }

  int axis_;
  std::shared_ptr<const LearnedNetwork> learned_;  // null before it learned
  std::shared_ptr<const ThermalNetwork> network_;  // null where it gives nothing
  std::vector<int> sensors_;                       // of the Domain
  std::vector<double> positions_;                  // m or rad, ascending
};

}  // namespace

EffectType thermalNetworkType() {
  return effectType<ThermalNetworkEffect>(
      "thermal_network", {"axis", "sensors", "network"}, nullptr, true,
      {EffectSpec("thermal_network").set("axis", "x").setList("sensors", {"bed", "frame"}),
       EffectSpec("thermal_network").set("axis", "x")});
}

}  // namespace mm
