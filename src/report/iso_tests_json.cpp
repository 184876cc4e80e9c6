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

Json axisJson(const AxisPositioning& a) {
  using Run = PositioningRun;
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

constexpr double kHourStep = 1e-5;         // h: 0.04 s
constexpr double kTemperatureStep = 1e-4;  // degC: below the noise of any sensor

Json driftFigureJson(const DriftFigure& f) {
  return {{"value", rounded(f.value, kFigureStep)},
          {"std", rounded(f.std, kFigureStep)},
          {"noise", rounded(f.noise, kFigureStep)}};
}

Json driftFiguresJson(const DriftFigures& f) {
  return {{"range", driftFigureJson(f.range)},
          {"hour", driftFigureJson(f.hour)},
          {"first_hour", driftFigureJson(f.firstHour)},
          {"heated", driftFigureJson(f.heated)},
          {"recovery", driftFigureJson(f.recovery)}};
}

/// The error motion of an axis that moved which a course is; empty: it is none.
std::string symbolOfCourse(const ThermalTest& test, const ThermalCourse& course,
                           const ErrorSymbols& symbols) {
  if (test.joint.empty() || course.between) return {};
  EffectSpec motion(course.direction == test.joint ? "scale" : "straightness");
  motion.set("axis", test.joint);
  if (course.direction != test.joint) motion.set("direction", course.direction).set("degree", "2");
  return symbols.of(motion);
}

Json thermalTestJson(const ThermalTestFigures& figures, const ErrorSymbols& symbols) {
  constexpr std::array<const char*, 4> kKinds = {"etve", "spindle", "linear_axis", "rotary_axis"};
  const ThermalTest& test = figures.test;
  Json courses = Json::array();
  for (std::size_t i = 0; i < test.courses.size(); ++i) {
    const ThermalCourse& c = test.courses[i];
    const std::string symbol = symbolOfCourse(test, c, symbols);
    courses.push_back(jsonObject({{{"name", c.name}, {"direction", c.direction}},
                                  entryIf(!symbol.empty(), "iso230", symbol),
                                  {{"at", rounded(c.at, kPlaceStep)},
                                   {"between", c.between},
                                   {"hours", roundedList(c.measured.hours, kHourStep)},
                                   {"measured", roundedList(c.measured.value, kDeviationStep)},
                                   {"left", roundedList(c.left, kDeviationStep)},
                                   {"measured_figures", driftFiguresJson(figures.measured[i])},
                                   {"left_figures", driftFiguresJson(figures.left[i])}}}));
  }
  return {{"test", "iso230-3"},
          {"kind", kKinds[static_cast<std::size_t>(test.kind)]},
          {"in_words", inWords(test)},
          {"axis", test.joint},
          {"spindle", test.spindle},
          {"setup", test.setup},
          {"unit", nameOfUnit(test.angular)},
          {"position_unit", test.rotary ? "deg" : "mm"},
          {"hours", {rounded(test.from, kHourStep), rounded(test.to, kHourStep)}},
          {"heated_hours", {rounded(test.heated.from, kHourStep), rounded(test.heated.to, kHourStep)}},
          {"courses", courses}};
}

}  // namespace

Json positioningJson(const std::vector<AxisPositioning>& axes) { return jsonList(axes, axisJson); }

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

Json diagonalsJson(const std::vector<DiagonalTest>& tests) {
  return jsonList(tests, [](const DiagonalTest& t) {
    const bool named = t.setup.empty() || t.setup == t.name;
    return axisJson({t.name,
                     t.name + (named ? "" : ", setup " + t.setup),
                     {},
                     false,
                     t.measured,
                     t.left,
                     t.runs,
                     t.leftRuns});
  });
}

Json rotationJson(const RotationTest& test) {
  if (test.angle.empty()) return nullptr;
  return {{"radius_mm", rounded(test.radius, kPlaceStep)},
          {"angle_deg", roundedList(test.angle, kAngleStep, [](double angle) { return angle / kDegree; })},
          {"radial_um", roundedList(test.radial, kDeviationStep)},
          {"axial_um", roundedList(test.axial, kDeviationStep)},
          {"radial_error_um", rounded(test.radialError, kFigureStep)},
          {"axial_error_um", rounded(test.axialError, kFigureStep)}};
}

Json lengthsJson(const std::vector<LengthLineTest>& tests) {
  return jsonList(tests, [](const LengthLineTest& t) -> Json {
    return {{"name", t.name},
            {"setup", t.setup},
            {"lengths", t.lengths},
            {"length_mm", roundedList(t.errors, kPlaceStep, &LengthError::length)},
            {"E_um", roundedList(t.errors, kDeviationStep, &LengthError::error)},
            {"left_um", roundedList(t.errors, kDeviationStep, &LengthError::left)},
            {"largest_um", rounded(t.largest, kFigureStep)},
            {"largest_left_um", rounded(t.largestLeft, kFigureStep)}};
  });
}

Json thermalJson(const ThermalReport& report, const Machine& machine) {
  const ErrorSymbols symbols(machine);
  const auto test = [&](const ThermalTestFigures& t) { return thermalTestJson(t, symbols); };
  const auto temperature = [](const TemperatureCourse& c) -> Json {
    return {{"sensor", c.sensor},
            {"range", rounded(c.range, kTemperatureStep)},
            {"hours", roundedList(c.hours, kHourStep)},
            {"temperature", roundedList(c.temperature, kTemperatureStep)}};
  };
  return {{"tests", jsonList(report.tests, test)},
          {"temperatures", jsonList(report.temperatures, temperature)}};
}

}  // namespace mm
