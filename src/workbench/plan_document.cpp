#include "workbench/plan_document.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "machine/joint_units.h"
#include "report/json_parts.h"
#include "session/plan.h"
#include "workbench/sent_yaml.h"

namespace mm {
namespace {

constexpr std::size_t kMostDrawn = 5000, kMostWay = 30000;

/// Where the tip's centre is (of a laser: its surface point at reading 0), m, workpiece.
Eigen::Vector3d tipAt(const Machine& machine, const std::vector<double>& readings) {
  return machine.nominal(readings.data(), 0.0).position;
}

/// Where the tip stops on its way to the target: at the surface of the ball, else at the target.
Eigen::Vector3d meets(const Plan& plan, const PlanMove& move, const Eigen::Vector3d& from,
                      const Eigen::Vector3d& target) {
  const Feature& feature = plan.artifact.features[static_cast<std::size_t>(move.feature)];
  if (feature.kind != FeatureKind::kBall || !feature.position.allFinite()) return target;
  const double distance = feature.radius + plan.artifact.tipRadius;
  const Eigen::Vector3d to = feature.position - from;
  const Eigen::Vector3d way = target - from;
  if (way.norm() == 0.0 || !std::isfinite(distance)) return target;
  const double along = to.dot(way.normalized()), aside2 = to.squaredNorm() - along * along;
  if (aside2 > distance * distance) return target;
  const double stop = along - std::sqrt(distance * distance - aside2);
  return from + std::clamp(stop, 0.0, way.norm()) * way.normalized();
}

/// s to get from one state to another at the plan's rapid speeds; each joint takes its own time.
double travelTime(const Plan& plan, const Machine& machine, const std::vector<double>& from,
                  const std::vector<double>& to, double speed) {
  double time = 0.0;
  for (std::size_t j = 0; j < to.size(); ++j) {
    const bool rotary = machine.joints()[j].kind == JointKind::kRotary;
    const double rate = rotary ? plan.rapidRotary : speed > 0.0 ? speed : plan.rapid;
    if (rate > 0.0) time = std::max(time, std::abs(to[j] - from[j]) / rate);
  }
  return time;
}

/// The columns of the measurements that are drawn.
class Steps {
 public:
  Steps(const Plan& plan, const Machine& machine) : plan_(plan), machine_(machine) {}

  void add(const PlanMove& move) {
    const Eigen::Vector3d from = tipAt(machine_, move.position);
    if (way_.size() < 3 * kMostWay) append(way_, from);
    if (move.kind == MoveKind::kGo) return;
    if (feature_.size() >= kMostDrawn) {
      ++leftOff_;
      return;
    }
    append(from_, from);
    append(to_,
           move.kind == MoveKind::kTouch ? meets(plan_, move, from, tipAt(machine_, move.target)) : from);
    feature_.push_back(move.feature);
    line_.push_back(move.line);
    for (std::size_t j = 0; j < move.position.size(); ++j)
      readings_.push_back(rounded(move.position[j] / readingUnit(machine_.joints()[j]).factor, kPlaceStep));
  }
  Json take() {
    return {
        {"from_mm", std::move(from_)}, {"to_mm", std::move(to_)},          {"feature", std::move(feature_)},
        {"line", std::move(line_)},    {"readings", std::move(readings_)}, {"way_mm", std::move(way_)},
        {"left_off", leftOff_}};
  }

 private:
  static void append(Json& list, const Eigen::Vector3d& at) {
    for (int k = 0; k < 3; ++k) list.push_back(rounded(at[k] / kMillimetre, kPlaceStep));
  }
  const Plan& plan_;
  const Machine& machine_;
  Json from_ = Json::array(), to_ = Json::array(), feature_ = Json::array(), line_ = Json::array(),
       readings_ = Json::array(), way_ = Json::array();
  std::size_t leftOff_ = 0;
};

}  // namespace

std::string planDocument(const std::string& yaml, const Machine& machine) {
  const Plan plan = Plan::parse(sentPlan(yaml), "plan", {}, machine);
  Steps steps(plan, machine);
  double time = 0.0;
  for (std::size_t i = 0; i < plan.moves.size(); ++i) {
    const PlanMove& move = plan.moves[i];
    const bool touch = move.kind == MoveKind::kTouch;
    if (i > 0)
      time += travelTime(plan, machine, plan.moves[i - 1].position, move.position, touch ? 0.0 : move.speed);
    if (touch) time += 1.5 * travelTime(plan, machine, move.position, move.target, move.speed);  // and back
    time += move.wait;
    steps.add(move);
  }
  const auto feature = [](const Feature& f) -> Json {
    return {{"name", f.name},
            {"ball", f.kind == FeatureKind::kBall},
            {"centre_mm", roundedList(f.position / kMillimetre, kPlaceStep)},
            {"radius_mm", rounded(f.radius / kMillimetre, kPlaceStep)}};
  };
  return jsonLine(jsonObject({{{"text", yaml},
                               {"name", plan.name},
                               {"moves", plan.moves.size()},
                               {"measurements", plan.measurements()},
                               {"features", jsonList(plan.artifact.features, feature)},
                               {"time_s", rounded(time, 1.0)}},
                              steps.take()}));
}

}  // namespace mm
