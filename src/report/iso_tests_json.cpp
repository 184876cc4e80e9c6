#include "report/iso_tests_json.h"

#include <array>

#include "base/quantity_words.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr double kAngleStep = 1e-3;  // deg: a thousand points of a circle are apart by 0.36

Json positioningFigures(PositioningFigures figures) {
  constexpr std::array<const char*, 12> kNames = {"A",          "A_forward",  "A_backward", "R",
                                                  "R_forward",  "R_backward", "E",          "E_forward",
                                                  "E_backward", "M",          "B",          "B_mean"};
  const std::array<double*, 12> values = eachFigure(figures);
  Json json;
  for (std::size_t k = 0; k < kNames.size(); ++k) json[kNames[k]] = rounded(*values[k], kFigureStep);
  return json;
}

Json positioningTestJson(const PositioningTest& test) {
  using Target = PositioningTarget;
  const auto runs = [](const Target& t) { return Json::array({t.forward, t.backward}); };
  return {{"at", roundedList(test.targets, kPlaceStep, &Target::at)},
          {"forward", roundedList(test.targets, kDeviationStep, &Target::meanForward)},
          {"backward", roundedList(test.targets, kDeviationStep, &Target::meanBackward)},
          {"s_forward", roundedList(test.targets, kDeviationStep, &Target::sForward)},
          {"s_backward", roundedList(test.targets, kDeviationStep, &Target::sBackward)},
          {"runs", jsonList(test.targets, runs)},
          {"figures", positioningFigures(test.figures)},
          {"std", positioningFigures(test.std)}};
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
