#include "uncertainty/measurement_task.h"

#include <cmath>
#include <functional>

#include "base/error.h"
#include "base/format.h"
#include "base/nearest_name.h"
#include "base/number_text.h"
#include "base/text.h"
#include "base/tiny.h"
#include "base/units.h"
#include "uncertainty/fitted_feature.h"
#include "uncertainty/task_shapes.h"

namespace mm {
namespace {

constexpr double kLargest = 1e5;        // mm: no machine measures farther
constexpr double kShortestTask = 1e-6;  // mm
constexpr int kBallContacts = 25, kRingContacts = 24, kSquareContacts = 25, kLineContacts = 15;
constexpr const char* kTaskWords[] = {"distance", "position", "ball",         "circle",     "roundness",
                                      "plane",    "flatness", "straightness", "iso10360-2", "iso230-2"};

MeasurementTask distanceTask(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double length = (b - a).norm();
  return {{{a, {0, 0, 0}, -1, 0.0}, {b, {0, 0, 0}, -1, 0.0}},
          {{"distance", length, false, length}},
          [](const MeasurementTask::Places& measured, double* values) {
            values[0] = (measured[1] - measured[0]).norm();
          }};
}

TaskQuantity coordinateOf(const Eigen::Vector3d& at, int k) {
  return {std::string(1, "xyz"[k]), at[k], false, 0.0};
}

MeasurementTask positionTask(const Eigen::Vector3d& at) {
  return {{{at, {0, 0, 0}, -1, 0.0}},
          {coordinateOf(at, 0), coordinateOf(at, 1), coordinateOf(at, 2)},
          [](const MeasurementTask::Places& measured, double* values) {
            for (int k = 0; k < 3; ++k) values[k] = measured[0][k];
          }};
}

/// A feature that is associated with the points: diameter and centre of a ball or ring, or the place of a
/// plane along its normal; behind these, or alone, its form.
/// @param form name of that figure. @param alone it is the only one.
MeasurementTask featureTask(FittedFeature::Kind kind, const Eigen::Vector3d& centre,
                            const Eigen::Vector3d& normal, double radius, std::vector<TaskPoint> points,
                            const char* form, bool alone) {
  using Found = FittedFeature::Found;
  std::vector<TaskQuantity> quantities;
  std::vector<std::function<double(const Found&)>> figures;
  const auto add = [&](TaskQuantity quantity, std::function<double(const Found&)> figure) {
    quantities.push_back(std::move(quantity));
    figures.push_back(std::move(figure));
  };
  if (!alone && radius > 0.0) {
    add({"diameter", 2.0 * radius, false, 2.0 * radius},
        [=](const Found& found) { return 2.0 * (radius + found.radius); });
    for (int k = 0; k < 3;
         ++k)  // the measured circle lies in its own plane: along the normal nothing is found
      if (kind == FittedFeature::Kind::kSphere || std::abs(normal[k]) < 1.0 - kOfAWhole)
        add(coordinateOf(centre, k), [=](const Found& found) { return centre[k] + found.centre[k]; });
  } else if (!alone) {
    add({"place", centre.dot(normal), false, 0.0},
        [=](const Found& found) { return (centre + found.centre).dot(normal); });
  }
  add({form, 0.0, true, 0.0}, [](const Found& found) { return found.form; });
  const FittedFeature fit(kind, centre, normal, radius, placesOf(points));
  return {std::move(points), std::move(quantities),
          [fit, figures](const MeasurementTask::Places& measured, double* values) {
            const Found found = fit.fit(measured);
            for (const auto& figure : figures) *values++ = figure(found);
          }};
}

std::vector<std::string> splitAt(const std::string& text, char mark) {
  std::vector<std::string> parts = {""};
  for (const char c : text)
    if (c == mark)
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

/// The text of a task, taken apart.
class TaskReader {
 public:
  TaskReader(const std::string& text, const TaskOptions& options)
      : text_(text), options_(options), parts_(splitAt(text, ':')) {}

  [[noreturn]] void refuse(const std::string& why) const {
    throw InputError("--task '" + text_ + "': " + why + "; " + usage());
  }
  const std::string& word() const { return parts_.front(); }
  /// Refuses another number of parts after the word.
  void expect(std::size_t parts) const {
    if (parts_.size() != parts + 1)
      refuse("has " + std::to_string(parts_.size() - 1) + " parts after '" + word() + "', it needs " +
             std::to_string(parts));
  }
  const std::string& part(std::size_t index) const { return parts_[index]; }

  std::vector<double> numbers(std::size_t index, std::size_t fewest, std::size_t most) const {
    std::vector<double> values;
    for (const std::string& text : splitAt(parts_[index], ',')) {
      const std::string one(trim(text));
      double value = 0.0;
      if (!parseNumber(one, value) || !(std::abs(value) <= kLargest))
        refuse("'" + one + "' is not a number from -100000 to 100000 mm");
      values.push_back(value);
    }
    if (values.size() < fewest || values.size() > most)
      refuse("'" + parts_[index] + "' has " + std::to_string(values.size()) + " numbers, it needs " +
             std::to_string(fewest) + (most > fewest ? " or " + std::to_string(most) : ""));
    return values;
  }
  Eigen::Vector3d place(std::size_t index) const {
    const std::vector<double> v = numbers(index, 3, 3);
    return Eigen::Vector3d(v[0], v[1], v[2]) * kMillimetre;
  }
  Eigen::Vector3d direction(std::size_t index) const {
    const std::vector<double> v = numbers(index, 3, 3);
    const Eigen::Vector3d d(v[0], v[1], v[2]);
    if (!(d.norm() > kShortestTask)) refuse("'" + part(index) + "' is not a direction: its length is zero");
    return d.normalized();
  }
  double length(double value, const char* what) const {
    if (!(value > kShortestTask)) refuse(format("%s %.6g mm is not above zero", what, value));
    return value * kMillimetre;
  }
  double lengthOf(std::size_t index, const char* what) const { return length(numbers(index, 1, 1)[0], what); }
  void expectApart(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const {
    if (!((a - b).norm() > kShortestTask * kMillimetre))
      refuse("both points are the same: the length is zero");
  }
  int points(int usual, int fewest) const {
    if (options_.points != 0 && options_.points < fewest)
      refuse("--points " + std::to_string(options_.points) + " is fewer than the " + std::to_string(fewest) +
             " that it needs");
    return options_.points != 0 ? options_.points : usual;
  }

 private:
  std::string usage() const {
    const std::string help = taskHelp();
    const std::size_t at = help.find("  " + word() + (word() == "iso10360-2" ? "" : ":"));
    if (at == std::string::npos) return "a task is " + listOf({std::begin(kTaskWords), std::end(kTaskWords)});
    const std::size_t end = help.find("  ", at + 2);
    return "write " + help.substr(at + 2, end - at - 2) + " in mm";
  }

  std::string text_;
  TaskOptions options_;
  std::vector<std::string> parts_;
};

MeasurementTask roundTask(const TaskReader& read, const Model& model) {
  if (read.word() == "ball") {
    read.expect(1);
    const std::vector<double> v = read.numbers(1, 3, 4);
    const Eigen::Vector3d centre = Eigen::Vector3d(v[0], v[1], v[2]) * kMillimetre;
    const double radius = v.size() == 4 ? read.length(v[3], "radius") : usualBallRadius(model.domain());
    return featureTask(FittedFeature::Kind::kSphere, centre, Eigen::Vector3d::UnitZ(), radius,
                       ballPoints(centre, radius, read.points(kBallContacts, 5)), "form", false);
  }
  read.expect(3);
  const Eigen::Vector3d centre = read.place(1), normal = read.direction(2);
  const double radius = read.lengthOf(3, "radius");
  return featureTask(FittedFeature::Kind::kCircle, centre, normal, radius,
                     ringPoints(centre, normal, radius, read.points(kRingContacts, 4)), "roundness",
                     read.word() != "circle");
}

MeasurementTask flatTask(const TaskReader& read) {
  read.expect(3);
  const Eigen::Vector3d centre = read.place(1);
  if (read.word() == "straightness") {
    const Eigen::Vector3d end = read.place(2), normal = read.direction(3);
    read.expectApart(centre, end);
    if (std::abs(normal.dot((end - centre).normalized())) > 0.99)
      read.refuse("the normal '" + read.part(3) + "' lies along the line");
    return featureTask(FittedFeature::Kind::kLine, 0.5 * (centre + end), normal, 0.0,
                       linePoints(centre, end, normal, read.points(kLineContacts, 3)), "straightness", true);
  }
  const Eigen::Vector3d normal = read.direction(2);
  const double side = read.lengthOf(3, "side");
  return featureTask(FittedFeature::Kind::kPlane, centre, normal, 0.0,
                     squarePoints(centre, normal, side, read.points(kSquareContacts, 4)), "flatness",
                     read.word() == "flatness");
}

MeasurementTask taskOf(const TaskReader& read, const TaskOptions& options, const Model& model) {
  const std::string& word = read.word();
  if (word == "distance") {
    read.expect(2);
    const Eigen::Vector3d a = read.place(1), b = read.place(2);
    read.expectApart(a, b);
    return distanceTask(a, b);
  }
  if (word == "position") {
    read.expect(1);
    return positionTask(read.place(1));
  }
  if (word == "ball" || word == "circle" || word == "roundness") return roundTask(read, model);
  if (word == "plane" || word == "flatness" || word == "straightness") return flatTask(read);
  if (word == "iso10360-2") {
    read.expect(0);
    return lengthTestTask(model, options.permissible);
  }
  if (word == "iso230-2") {
    read.expect(1);
    return positioningTask(read.part(1), options.points, model);
  }
  const std::vector<std::string> known(std::begin(kTaskWords), std::end(kTaskWords));
  read.refuse("'" + word + "' is not a task" + didYouMean(word, known));
}

}  // namespace

std::unique_ptr<MeasurementTask> makeTask(const std::string& text, const TaskOptions& options,
                                          const Model& model) {
  auto task = std::make_unique<MeasurementTask>(taskOf(TaskReader(text, options), options, model));
  task->text = text;
  return task;
}

std::string taskHelp() {
  return "  distance:x,y,z:x,y,z                 of two points\n"
         "  position:x,y,z                       of a point\n"
         "  ball:x,y,z[,radius]                  diameter, centre, form\n"
         "  circle:x,y,z:nx,ny,nz:radius         diameter, centre, roundness; n is its normal\n"
         "  roundness:x,y,z:nx,ny,nz:radius      of such a circle\n"
         "  plane:x,y,z:nx,ny,nz:side            place along the normal, flatness; of a square\n"
         "  flatness:x,y,z:nx,ny,nz:side         of such a square\n"
         "  straightness:x,y,z:x,y,z:nx,ny,nz    of a line on a surface with the normal n\n"
         "  iso10360-2                           lengths in seven positions, and a ball\n"
         "  iso230-2:axis                        accuracy of positioning of an axis\n";
}

}  // namespace mm
