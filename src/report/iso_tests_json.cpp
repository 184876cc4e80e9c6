#include "report/iso_tests_json.h"

#include "base/units.h"

namespace mm {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kAngleStep = 1e-3;  // deg: a thousand points of a circle are apart by 0.36

Json positioningTestJson(const PositioningTest& test) {
  Json out;
  std::vector<double> at, up, down, sUp, sDown;
  Json runs = Json::array();
  for (const PositioningTarget& t : test.targets) {
    at.push_back(t.at);
    up.push_back(t.meanForward);
    down.push_back(t.meanBackward);
    sUp.push_back(t.sForward);
    sDown.push_back(t.sBackward);
    runs.push_back(Json::array({t.forward, t.backward}));
  }
  out["at"] = roundedList(at, kPlaceStep);
  out["forward"] = roundedList(up, kDeviationStep);
  out["backward"] = roundedList(down, kDeviationStep);
  out["s_forward"] = roundedList(sUp, kDeviationStep);
  out["s_backward"] = roundedList(sDown, kDeviationStep);
  out["runs"] = std::move(runs);
  const PositioningFigures& f = test.figures;
  const auto figure = [](double value) { return rounded(value, kFigureStep); };
  out["figures"] = Json{{"A", figure(f.accuracy)},
                        {"A_forward", figure(f.forward.accuracy)},
                        {"A_backward", figure(f.backward.accuracy)},
                        {"R", figure(f.repeatability)},
                        {"R_forward", figure(f.forward.repeatability)},
                        {"R_backward", figure(f.backward.repeatability)},
                        {"E", figure(f.systematic)},
                        {"E_forward", figure(f.forward.systematic)},
                        {"E_backward", figure(f.backward.systematic)},
                        {"M", figure(f.meanRange)},
                        {"B", figure(f.reversal)},
                        {"B_mean", figure(f.meanReversal)}};
  return out;
}

Json circlePathJson(const CirclePath& path) {
  if (path.angle.empty()) return nullptr;
  std::vector<double> degrees;
  for (const double angle : path.angle) degrees.push_back(angle / kDegree);
  return Json{{"angle_deg", roundedList(degrees, kAngleStep)},
              {"F_um", roundedList(path.radial, kDeviationStep)},
              {"G", rounded(path.circular, kFigureStep)},
              {"F_max", rounded(path.largest, kFigureStep)},
              {"F_min", rounded(path.smallest, kFigureStep)}};
}

Json circleFiguresJson(const CircleFigures& f) {
  return Json{{"counter_clockwise", circlePathJson(f.counterClockwise)},
              {"clockwise", circlePathJson(f.clockwise)},
              {"G_both", rounded(f.bidirectional, kFigureStep)},
              {"D", rounded(f.meanRadial, kFigureStep)},
              {"H", rounded(f.hysteresis, kFigureStep)}};
}

}  // namespace

Json positioningJson(const std::vector<AxisPositioning>& axes) {
  Json out = Json::array();
  for (const AxisPositioning& a : axes) {
    Json one;
    one["axis"] = a.axis;
    one["name"] = a.name;
    one["travel_assumed"] = a.travelAssumed;
    one["unit"] = a.rotary ? "arcsec" : "um";
    one["position_unit"] = a.rotary ? "deg" : "mm";
    one["measured"] = positioningTestJson(a.measured);
    one["calibrated"] = positioningTestJson(a.calibrated);
    Json x = Json::array(), y = Json::array(), left = Json::array(), up = Json::array();
    for (std::size_t i = 0; i < a.runs.size(); ++i) {
      x.push_back(rounded(a.runs[i].at, kPlaceStep));
      y.push_back(rounded(a.runs[i].deviation, kDeviationStep));
      left.push_back(rounded(a.left[i].deviation, kDeviationStep));
      up.push_back(a.runs[i].forward ? 1 : 0);
    }
    one["x"] = std::move(x);
    one["y"] = std::move(y);
    one["left"] = std::move(left);
    one["up"] = std::move(up);
    out.push_back(std::move(one));
  }
  return out;
}

Json circlesJson(const std::vector<CircleTest>& tests) {
  Json out = Json::array();
  for (const CircleTest& t : tests)
    out.push_back(Json{{"first", t.first},
                       {"second", t.second},
                       {"setup", t.setup},
                       {"radius_mm", rounded(t.radius, kPlaceStep)},
                       {"measured", circleFiguresJson(t.measured)},
                       {"calibrated", circleFiguresJson(t.calibrated)}});
  return out;
}

}  // namespace mm
