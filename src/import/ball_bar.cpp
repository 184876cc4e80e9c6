#include <cmath>
#include <utility>

#include "base/format.h"
#include "base/text.h"
#include "base/units.h"
#include "import/record_table.h"
#include "import/unit.h"

namespace mm {
namespace {

constexpr double kLeastTime = 1e-3;  // s between two rows

/// +1 counter-clockwise, -1 clockwise, 0: not said.
double turnOf(const std::string& text) {
  for (const std::string& word : wordsOf(text)) {
    if (isOneOf(word, "ccw|counterclockwise|anticlockwise|counter|anti|g3|g03")) return 1.0;
    if (isOneOf(word, "cw|clockwise|g2|g02")) return -1.0;
  }
  return text == "+" ? 1.0 : text == "-" ? -1.0 : 0.0;
}

class BallBarReader {
 public:
  explicit BallBarReader(ImportContext& context) : context_(context), table_(context) {}

  void read() {
    if (!table_.bringsArtifact("a ball bar", "the ball at its centre")) return;
    const bool plane = readPlane(), head = readHead();
    if (plane && head) rows();
  }

 private:
  bool readPlane() {
    std::string plane = lower(table_.said({"plane", "ebene"}, "plane"));
    if (plane.empty()) {
      context_.refuse("the plane of the circle is not stated; " + context_.ask("plane", "xy"));
      return false;
    }
    for (const auto& [other, name] : {std::pair("g17", "xy"), std::pair("g18", "zx"), std::pair("g19", "yz"),
                                      std::pair("xz", "zx"), std::pair("zy", "yz")})
      if (plane == other) plane = name;
    for (std::size_t k = 0; k < 2 && plane.size() == 2; ++k)
      plane_[k] = jointOf(context_.machine, plane.substr(k, 1));
    const auto linear = [&](int j) {
      return j >= 0 && context_.machine.joints()[j].kind == JointKind::kLinear;
    };
    if (linear(plane_[0]) && linear(plane_[1]) && plane_[0] != plane_[1]) return true;
    context_.refuse("plane '" + shownText(plane) + "' is not a plane of two linear joints of this machine; " +
                    context_.ask("plane", "xy"));
    return false;
  }

  bool readHead() {
    const std::size_t before = context_.faults.count();
    if (!table_.number({"radius", "nominal radius", "bar length", "ballbar length", "length"}, "radius_mm",
                       UnitKind::kLength, "mm", radius_) &&
        context_.faults.count() == before)
      context_.refuse("the nominal radius is not stated; " + context_.ask("radius_mm", "100"));
    if (context_.faults.count() == before && radius_ <= 0.0)
      context_.refuse("the nominal radius must be above 0");
    if (table_.number({"feed", "feedrate", "feed rate", "vorschub"}, "feed_mm_min", UnitKind::kSpeed,
                      "mm/min", feed_) &&
        feed_ <= 0.0)
      context_.refuse("the feed must be above 0");
    turn_ = turnOf(table_.said({"direction", "rotation", "sense", "richtung"}, "direction"));
    centre_ = blankRow(context_, ObservationKind::kContact, 0, 0.0).position;
    table_.place({"centre", "center", "circle centre", "circle center", "centre position", "mittelpunkt"},
                 "centre_mm", "the circle (machine reading at its centre)", plane_, centre_);
    return context_.faults.count() == before;
  }

  void rows() {
    const int angle = table_.column("angle phi theta winkel position");
    const int time = table_.column("time t zeit");
    const int radius = table_.column("radius radial r deviation error dev dr abweichung");
    const int turn = table_.column("direction dir sense rotation");
    double start = 0.0;
    table_.number({"start angle", "start"}, "start_deg", UnitKind::kAngle, "deg", start);
    if (radius < 0 || (angle < 0 && (time < 0 || feed_ <= 0.0))) {
      table_.refuseHead(
          "ball bar data need an angle, or a time and the feed, and a radius or its deviation; name the "
          "columns angle [deg] and deviation [um]");
      return;
    }
    const bool isRadius = radiusColumn(radius);
    table_.show(angle, "angle in the plane", "deg");
    table_.show(time, "time", "s");
    table_.show(radius, isRadius ? "radius" : "deviation of the radius", "");
    Feature ball{FeatureKind::kBall, "centre"};
    ball.radius = radius_;
    ball.position = context_.machine.nominal(centre_.data(), kNotMeasured).position;
    Session session = ownArtifact(context_, "ball_bar", ball);
    if (time < 0 && feed_ <= 0.0) session.timesAssumed = kTimesInOrder;
    double seconds = 0.0, lastAngle = kNotMeasured;
    auto next = table_.between().begin();
    for (std::size_t i = 0; i < table_.rows().size(); ++i) {
      const auto& row = table_.rows()[i];
      for (; next != table_.between().end() && next->first < row.line; ++next) {
        const auto& [key, value] = next->second;
        if (const double said = turnOf(value); said != 0.0 && isOneOf(key, "direction|run|sense"))
          turn_ = said, lastAngle = kNotMeasured;
      }
      const double r = table_.value(row, radius, UnitKind::kLength);
      double phi = table_.value(row, angle, UnitKind::kAngle);
      const double t = table_.value(row, time, UnitKind::kTime);
      if (turn >= 0) turn_ = turnOf(table_.text(row, turn));
      const double way = turnAt(i, angle);
      if (angle < 0) phi = start + way * feed_ * t / radius_;
      if (std::isnan(r) || std::isnan(phi)) continue;
      if (!std::isnan(t))
        seconds = t;
      else if (i > 0)
        seconds += feed_ > 0.0 && std::isfinite(lastAngle)
                       ? std::max(kLeastTime, std::abs(phi - lastAngle) * radius_ / feed_)
                       : 1.0;
      lastAngle = phi;
      add(session, row.line, seconds, phi, isRadius ? r - radius_ : r, way);
    }
    if (!context_.faults.empty()) return;
    notes();
    finishImport(context_, std::move(session));
  }

  /// A radius is near the nominal one; its deviation is far less.
  bool radiusColumn(int column) {
    double sum = 0.0;
    int count = 0;
    for (const auto& row : table_.rows()) {
      const double r = table_.value(row, column, UnitKind::kLength);
      if (!std::isnan(r)) sum += r, ++count;
    }
    const double mean = count > 0 ? sum / count : 0.0;
    if (std::abs(mean - radius_) < 0.05 * radius_) return true;
    if (std::abs(mean) > 0.05 * radius_ && context_.faults.empty())
      table_.refuseHead(
          format("the radii are about %.4g mm, which is neither close to the nominal %.4g mm nor a deviation "
                 "from it; is the unit right?",
                 mean / kMillimetre, radius_ / kMillimetre));
    return false;
  }

  /// Direction of the circle: said, or seen from the order of the angles.
  double turnAt(std::size_t i, int angle) {
    if (turn_ != 0.0) return turn_;
    if (angle < 0 || table_.rows().size() < 2) return 0.0;
    const std::size_t a = i > 0 ? i - 1 : i, b = i > 0 ? i : i + 1;
    const double step = table_.value(table_.rows()[b], angle, UnitKind::kAngle) -
                        table_.value(table_.rows()[a], angle, UnitKind::kAngle);
    seen_ = true;
    if (std::abs(step) > kPi) return step > 0.0 ? -1.0 : 1.0;  // 359 to 0
    return step > 0.0 ? 1.0 : step < 0.0 ? -1.0 : 0.0;
  }

  /// The tip was at the nominal radius + deviation where the machine indicated the nominal circle: the
  /// reading at which it would have been at the nominal radius is nearer by the deviation. So each row is a
  /// contact with a ball of that radius about the centre. The error of the machine is taken a deviation away
  /// from where it was: nothing.
  void add(Session& session, std::size_t line, double time, double phi, double deviation, double turn) const {
    Observation o = blankRow(context_, ObservationKind::kContact, line, time);
    o.feature = 0;
    o.position = centre_;
    o.position[plane_[0]] += (radius_ - deviation) * std::cos(phi);
    o.position[plane_[1]] += (radius_ - deviation) * std::sin(phi);
    const double along[2] = {-std::sin(phi) * turn, std::cos(phi) * turn};
    for (int k = 0; k < 2; ++k) {
      const int j = plane_[static_cast<std::size_t>(k)];
      if (feed_ > 0.0 && turn != 0.0) o.velocity[j] = feed_ * along[k];
      constexpr double kTurning = 1e-6;  // at the reversal the direction is not known
      if (turn != 0.0 && std::abs(along[k]) > kTurning) o.travel[j] = along[k] > 0.0 ? 1.0 : -1.0;
    }
    if (feed_ > 0.0 && turn != 0.0)
      for (std::size_t j = 0; j < o.velocity.size(); ++j)
        if (std::isnan(o.velocity[j])) o.velocity[j] = 0.0;  // the other joints stood still
    session.observations.push_back(std::move(o));
  }

  void notes() {
    context_.note(
        format("nominal radius %.6g mm, plane %s%s", radius_ / kMillimetre,
               context_.machine.joints()[plane_[0]].name.c_str(),
               context_.machine.joints()[plane_[1]].name.c_str()) +
        (feed_ > 0.0 ? format(", feed %.6g mm/min", feed_ / kMillimetre * 60.0) : ", feed not stated"));
    context_.note(
        "each row is a contact with the ball 'centre' of the nominal radius; its centre is free, and if the "
        "bar was not calibrated so is its radius ({type: ball_radius, ball: centre})");
    if (seen_) context_.note("direction of the circle from the order of the angles");
  }

  ImportContext& context_;
  RecordTable table_;
  std::vector<int> plane_ = {-1, -1};  // its joints
  double radius_ = 0.0, feed_ = 0.0, turn_ = 0.0;
  bool seen_ = false;
  std::vector<double> centre_;  // readings at it
};

}  // namespace

bool isBallBar(const TextFile& file) { return headHas(file, "ball bar|ballbar|ball-bar|iso 230-4|iso230-4"); }

void readBallBar(ImportContext& context) { BallBarReader(context).read(); }

}  // namespace mm
