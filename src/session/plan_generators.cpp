#include "session/plan_generators.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/rotation.h"
#include "base/units.h"
#include "machine/joint_units.h"

namespace mm {
namespace {

const double kGoldenAngle = kPi * (3.0 - std::sqrt(5.0));
constexpr double kGoldenRatio = 0.6180339887498949;

/// Point k of n on a cap around `pole`: equal areas, azimuths by the golden angle, within [from, to] (rad) of
/// azimuth.
Eigen::Vector3d onCap(const Eigen::Vector3d& pole, double cone, int k, int n, double from, double to,
                      double turn) {
  const double height = 1.0 - (1.0 - std::cos(cone)) * (k + 0.5) / n;
  double azimuth = std::fmod(k * kGoldenAngle + turn, 2.0 * kPi);
  azimuth = from + azimuth / (2.0 * kPi) * (to - from);
  const double across = std::sqrt(std::max(0.0, 1.0 - height * height));
  const Eigen::Vector3d first = std::abs(pole.x()) < 0.9
                                    ? (Eigen::Vector3d::UnitX() - pole * pole.x()).normalized()
                                    : (Eigen::Vector3d::UnitY() - pole * pole.y()).normalized();
  const Eigen::Vector3d second = pole.cross(first);
  return height * pole + across * (std::cos(azimuth) * first + std::sin(azimuth) * second);
}

/// A number in SI, within bounds as written; `otherwise` where it is not given.
double numberOr(const YamlMapping& map, const char* key, double factor, double lower, double upper,
                double otherwise) {
  return map.has(key) ? map.number(key, factor, lower, upper) : otherwise;
}

/// How many, at least one.
int countOr(const YamlMapping& map, const char* key, int otherwise) {
  return map.has(key) ? map.count(key, 1) : otherwise;
}

/// Indices of the features that a key names: `all` or a list. @throw InputError
std::vector<int> featuresOf(const YamlMapping& map, const std::string& key, const Plan& plan) {
  std::vector<int> features;
  if (map.has(key) && !(map.node(key).IsScalar() && map.text(key) == "all")) {
    for (const std::string& name : map.texts(key)) {
      features.push_back(plan.artifact.findFeature(name));
      if (features.back() < 0)
        map.fail(key, "names '" + name + "', which is not in artifact '" + plan.artifact.name + "'");
    }
    return features;
  }
  for (std::size_t f = 0; f < plan.artifact.features.size(); ++f)
    if (plan.artifact.features[f].kind == FeatureKind::kBall) features.push_back(static_cast<int>(f));
  if (features.empty()) map.fail("", "needs balls; the artifact has none");
  return features;
}

struct TouchPlan {
  std::vector<int> features;
  int points = 75, repeats = 1, pauseEvery = 0;
  double cone = 75.0 * kDegree, tilt = 0.0, azimuthFrom = 0.0, azimuthTo = 2.0 * kPi, pause = 0.0, wait = 0.0;
  Eigen::Vector3d pole = Eigen::Vector3d::UnitZ(), approach = Eigen::Vector3d::Zero();
  bool interleaved = false;
  std::vector<double> speeds;
  std::vector<double> rotary;
};

TouchPlan readTouch(const YAML::Node& node, PlanBuilder& builder) {
  std::vector<std::string> known = {"features", "points",      "cone_deg",  "pole",        "approach",
                                    "tilt_deg", "azimuth_deg", "order",     "speeds_mm_s", "repeats",
                                    "wait_s",   "pause",       "placement", "stylus"};
  for (const std::string& key : jointKeys(builder.machine())) known.push_back(key);
  const YamlMapping map(node, builder.plan().source, "touch", known);
  builder.at(map.line(), "touch");
  TouchPlan t;
  t.features = featuresOf(map, "features", builder.plan());
  t.points = countOr(map, "points", t.points);
  t.cone = numberOr(map, "cone_deg", kDegree, 1.0, 120.0, t.cone);
  t.tilt = numberOr(map, "tilt_deg", kDegree, 0.0, 70.0, t.tilt);
  if (map.has("pole")) t.pole = map.vector("pole", 1.0);
  if (t.pole.norm() < kNoDirection) map.fail("pole", "must not be zero");
  t.pole.normalize();
  if (map.has("approach") && !(map.node("approach").IsScalar() && map.text("approach") == "radial")) {
    t.approach = map.vector("approach", 1.0);
    if (t.approach.norm() < kNoDirection)
      map.fail("approach", "must be radial or a direction that is not zero");
    t.approach.normalize();
  }
  if (map.has("azimuth_deg")) {
    const std::vector<double> range = map.numbers("azimuth_deg", kDegree);
    if (range.size() != 2 || range[1] <= range[0])
      map.fail("azimuth_deg", "must be two angles, [from, to], from below to");
    t.azimuthFrom = range[0];
    t.azimuthTo = range[1];
  }
  if (map.has("order")) {
    const std::string order = map.text("order");
    if (order != "by_ball" && order != "interleaved") map.fail("order", "must be by_ball or interleaved");
    t.interleaved = order == "interleaved";
  }
  t.speeds = map.has("speeds_mm_s") ? map.numbers("speeds_mm_s", kMillimetre)
                                    : std::vector<double>{builder.approachSpeed};
  for (const double speed : t.speeds)
    if (speed <= 0.0) map.fail("speeds_mm_s", "must be above 0");
  t.repeats = countOr(map, "repeats", t.repeats);
  t.wait = numberOr(map, "wait_s", 1.0, 0.0, 1e6, t.wait);
  if (map.has("pause")) {
    const YamlMapping pause(map.node("pause"), map.source(), "pause", {"every", "wait_s"});
    t.pauseEvery = pause.count("every", 1);
    t.pause = pause.number("wait_s", 1.0, 0.0, 1e6);
  }
  t.rotary = readingsOf(map, builder.machine(), builder.current());
  return t;
}

/// Every second approach is leant towards the pole, the others away from it, as far as it still pushes on the
/// surface.
Eigen::Vector3d lean(const Eigen::Vector3d& normal, const Eigen::Vector3d& pole, double tilt, int k) {
  const Eigen::Vector3d about = normal.cross(pole);
  constexpr double kAlong = 1e-6;  // sine: along the normal there is nothing to tilt about
  if (tilt == 0.0 || about.norm() < kAlong) return -normal;
  return Eigen::AngleAxisd(k % 2 == 0 ? -tilt : 0.3 * tilt, about.normalized()) * -normal;
}

/// Point to be touched k-th of n: neighbours on the ball are far apart in time, so that neither height nor
/// azimuth of the approach goes with the time or with the temperatures.
int shuffled(int k, int n) {
  int stride = std::max(1, static_cast<int>(std::lround(kGoldenRatio * n)));
  while (std::gcd(stride, n) != 1) ++stride;
  return static_cast<int>(static_cast<long>(k) * stride % n);
}

void touchOne(const TouchPlan& t, std::size_t ball, int k, int index, PlanBuilder& builder) {
  const int feature = t.features[ball];
  const double distance = builder.contactDistance(feature);
  const Eigen::Vector3d normal = onCap(t.pole, t.cone, k, t.points, t.azimuthFrom, t.azimuthTo, 0.7 * ball);
  const Eigen::Vector3d approach = t.approach.isZero(0.0) ? lean(normal, t.pole, t.tilt, k) : t.approach;
  if (approach.dot(normal) > -0.15)
    builder.fail(
        "with this 'approach' the probe would not press on the ball at every point; reduce 'cone_deg', or "
        "let 'pole' point against 'approach'");
  const double speed = t.speeds[index % t.speeds.size()];
  builder.touchAt(feature, builder.centre(feature) + distance * normal, approach, speed, t.rotary, {},
                  t.wait);
  if (t.pauseEvery > 0 && (index + 1) % t.pauseEvery == 0) builder.go(builder.current(), 0.0, t.pause);
}

}  // namespace

std::vector<YAML::Node> entriesOf(const YAML::Node& node) {
  if (!node.IsSequence()) return {node};
  return std::vector<YAML::Node>(node.begin(), node.end());
}

std::vector<std::string> jointKeys(const Machine& machine) {
  std::vector<std::string> keys;
  for (const Joint& joint : machine.joints()) keys.push_back(joint.name + "_" + readingUnit(joint).symbol);
  return keys;
}

std::vector<double> readingsOf(const YamlMapping& map, const Machine& machine, std::vector<double> readings) {
  const std::vector<std::string> keys = jointKeys(machine);
  for (std::size_t j = 0; j < keys.size(); ++j)
    if (map.has(keys[j])) readings[j] = map.number(keys[j], readingUnit(machine.joints()[j]).factor);
  return readings;
}

void expandTouch(const YAML::Node& list, PlanBuilder& builder) {
  for (const YAML::Node& node : entriesOf(list)) {
    const TouchPlan t = readTouch(node, builder);
    int index = 0;
    for (int repeat = 0; repeat < t.repeats; ++repeat) {
      const std::size_t balls = t.features.size(), points = static_cast<std::size_t>(t.points);
      for (std::size_t i = 0; i < balls * points; ++i) {
        const std::size_t ball = t.interleaved ? i % balls : i / points;
        const std::size_t k = t.interleaved ? i / balls : i % points;
        touchOne(t, ball, shuffled(static_cast<int>(k), t.points), index++, builder);
      }
    }
  }
}

void expandPostures(const YAML::Node& list, PlanBuilder& builder) {
  const std::vector<std::string> joints = jointKeys(builder.machine());
  for (const YAML::Node& node : entriesOf(list)) {
    const YamlMapping map(node, builder.plan().source, "postures",
                          {"feature", "points", "cone_deg", "readings_mm", "wait_s", "repeats", "at"});
    builder.at(map.line(), "postures");
    const std::vector<int> features = featuresOf(map, "feature", builder.plan());
    const int points = countOr(map, "points", 30);
    const double cone = numberOr(map, "cone_deg", kDegree, 1.0, 85.0, 45.0 * kDegree);
    std::vector<double> readings =
        map.has("readings_mm") ? map.numbers("readings_mm", kMillimetre) : std::vector<double>{0.0};
    if (readings.size() > 2) map.fail("readings_mm", "must be one reading, or two, [from, to]");
    const double wait = numberOr(map, "wait_s", 1.0, 0.0, 1e6, 0.5);
    const int repeats = countOr(map, "repeats", 1);
    if (!map.node("at").IsSequence())
      map.fail("at", "must be a list of postures such as {b_deg: 0, a_deg: 90}");
    for (int repeat = 0; repeat < repeats; ++repeat)
      for (const YAML::Node& posture : map.node("at")) {
        const YamlMapping one(posture, map.source(), "a posture", joints);
        builder.at(one.line(), "a posture");
        const std::vector<double> pose = readingsOf(one, builder.machine(), builder.current());
        const Eigen::Vector3d beam = builder.beam(pose);
        for (const int feature : features)
          for (int k = 0; k < points; ++k) {
            const Eigen::Vector3d normal = onCap(-beam, cone, k, points, 0.0, 2.0 * kPi, 0.0);
            const double part = std::fmod((k + 0.5) * kGoldenRatio, 1.0);
            const double reading = readings.front() + part * (readings.back() - readings.front());
            const double radius = builder.plan().artifact.features[feature].radius;
            builder.readLaser(feature,
                              builder.reach(builder.centre(feature) + radius * normal - reading * beam, pose),
                              wait);
          }
      }
  }
}

void expandReference(const YAML::Node& list, PlanBuilder& builder) {
  const std::vector<std::string> joints = jointKeys(builder.machine());
  for (const YAML::Node& node : entriesOf(list)) {
    const YamlMapping map(node, builder.plan().source, "reference",
                          {"joint", "positions_mm", "positions_deg", "from_mm", "to_mm", "from_deg", "to_deg",
                           "points", "runs", "directions", "dwell_s", "speed_mm_s", "setup", "at"});
    builder.at(map.line(), "reference");
    const int joint = builder.machine().findJoint(map.text("joint"));
    if (joint < 0)
      map.fail("joint",
               "'" + map.text("joint") + "' is not a joint of machine '" + builder.machine().name() + "'");
    const bool linear = builder.machine().joints()[joint].kind == JointKind::kLinear;
    const auto [unit, symbol] = readingUnit(builder.machine().joints()[joint]);
    const std::string suffix = std::string("_") + symbol, others = linear ? "_deg" : "_mm";
    for (const char* key : {"positions", "from", "to"})
      if (map.has(key + others))
        map.fail(key + others, std::string("is for a ") + (linear ? "rotary" : "linear") + " joint");
    std::vector<double> positions;
    if (map.has("positions" + suffix)) {
      positions = map.numbers("positions" + suffix, unit);
    } else {
      const double from = map.number("from" + suffix, unit), to = map.number("to" + suffix, unit);
      const int points = map.count("points", 2);
      for (int i = 0; i < points; ++i) positions.push_back(from + (to - from) * i / (points - 1.0));
    }
    std::sort(positions.begin(), positions.end());
    const int runs = countOr(map, "runs", 5);
    const double dwell = numberOr(map, "dwell_s", 1.0, 0.0, 1e6, 3.0);
    const double speed = numberOr(map, "speed_mm_s", kMillimetre, 1e-3, 1e4, 0.0);
    const std::string directions = map.has("directions") ? map.text("directions") : "both";
    if (directions != "both" && directions != "up" && directions != "down")
      map.fail("directions", "must be both, up or down");
    const std::string setup = map.has("setup") ? map.text("setup") : "";
    std::vector<double> at = builder.current();
    if (map.has("at"))
      at = readingsOf(YamlMapping(map.node("at"), map.source(), "at", joints), builder.machine(), at);

    std::vector<int> sides(at.size(), 0);
    for (int run = 0; run < runs; ++run)
      for (const int travel : {1, -1}) {
        if ((travel > 0 && directions == "down") || (travel < 0 && directions == "up")) continue;
        std::vector<double> order = positions;
        if (travel < 0) std::reverse(order.begin(), order.end());
        sides[joint] = -travel;
        at[joint] = order.front();
        builder.comeFrom(sides, at);
        for (const double position : order) {
          at[joint] = position;
          builder.reference(MoveKind::kDeviation, joint, at, speed, dwell, setup);
        }
      }
  }
}

}  // namespace mm
