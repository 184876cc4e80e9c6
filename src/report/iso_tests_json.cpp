#include "report/iso_tests_json.h"

#include "base/quantity_words.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr double kAngleStep = 1e-3;  // deg: a thousand points of a circle are apart by 0.36

Json positioningTestJson(const PositioningTest& test) {
  using Target = PositioningTarget;
  const PositioningFigures& f = test.figures;
  const auto figure = [](double value) { return rounded(value, kFigureStep); };
  const auto runs = [](const Target& t) { return Json::array({t.forward, t.backward}); };
  return {{"at", roundedList(test.targets, kPlaceStep, &Target::at)},
          {"forward", roundedList(test.targets, kDeviationStep, &Target::meanForward)},
          {"backward", roundedList(test.targets, kDeviationStep, &Target::meanBackward)},
          {"s_forward", roundedList(test.targets, kDeviationStep, &Target::sForward)},
          {"s_backward", roundedList(test.targets, kDeviationStep, &Target::sBackward)},
          {"runs", jsonList(test.targets, runs)},
          {"figures",
           {{"A", figure(f.accuracy)},
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
            {"B_mean", figure(f.meanReversal)}}}};
}

Json circlePathJson(const CirclePath& path) {
  if (path.angle.empty()) return nullptr;
  return {{"angle_deg", roundedList(path.angle, kAngleStep, [](double angle) { return angle / kDegree; })},
          {"F_um", roundedList(path.radial, kDeviationStep)},
          {"G", rounded(path.circular, kFigureStep)},
          {"F_max", rounded(path.largest, kFigureStep)},
          {"F_min", rounded(path.smallest, kFigureStep)}};
}

Json circleFiguresJson(const CircleFigures& f) {
  return {{"counter_clockwise", circlePathJson(f.counterClockwise)},
          {"clockwise", circlePathJson(f.clockwise)},
          {"G_both", rounded(f.bidirectional, kFigureStep)},
          {"D", rounded(f.meanRadial, kFigureStep)},
          {"H", rounded(f.hysteresis, kFigureStep)}};
}

}  // namespace

Json positioningJson(const std::vector<AxisPositioning>& axes) {
  using Run = PositioningRun;
  return jsonList(axes, [](const AxisPositioning& a) -> Json {
    return {{"axis", a.axis},
            {"name", a.name},
            {"travel_assumed", a.travelAssumed},
            {"unit", nameOfUnit(a.rotary)},
            {"position_unit", a.rotary ? "deg" : "mm"},
            {"measured", positioningTestJson(a.measured)},
            {"calibrated", positioningTestJson(a.calibrated)},
            {"x", roundedList(a.runs, kPlaceStep, &Run::at)},
            {"y", roundedList(a.runs, kDeviationStep, &Run::deviation)},
            {"left", roundedList(a.left, kDeviationStep, &Run::deviation)},
            {"up", jsonList(a.runs, [](const Run& run) { return run.forward ? 1 : 0; })}};
  });
}

Json circlesJson(const std::vector<CircleTest>& tests) {
  return jsonList(tests, [](const CircleTest& t) -> Json {
    return {{"first", t.first},
            {"second", t.second},
            {"setup", t.setup},
            {"radius_mm", rounded(t.radius, kPlaceStep)},
            {"measured", circleFiguresJson(t.measured)},
            {"calibrated", circleFiguresJson(t.calibrated)}};
  });
}

}  // namespace mm
