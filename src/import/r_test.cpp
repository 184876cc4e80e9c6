#include "import/r_test.h"

#include <Eigen/Core>
#include <cmath>

#include "base/dense.h"
#include "base/error.h"
#include "base/format.h"
#include "base/text.h"
#include "base/units.h"
#include "import/record_table.h"
#include "import/unit.h"

namespace mm {
namespace {

class RTestReader {
 public:
  explicit RTestReader(ImportContext& context) : context_(context), table_(context) {}

  void read() {
    if (context_.artifact != nullptr) {
      context_.faults.add(name() + ": an R-test brings its own artifact (the ball); leave --artifact out");
      return;
    }
    const auto& joints = context_.machine.joints();
    std::vector<int> columns;
    int rotary = 0;
    for (const Joint& joint : joints) {
      columns.push_back(table_.column({lower(joint.name)}));
      rotary += joint.kind == JointKind::kRotary && columns.back() >= 0;
    }
    if (rotary == 0) {
      context_.faults.add(
          name() +
          ": no column is a rotary joint of this machine; an R-test turns one (name it as the machine "
          "does, e.g. b [deg])");
      return;
    }
    int d[3];
    for (int k = 0; k < 3; ++k)
      d[k] = table_.column({std::string("d") + "xyz"[k], std::string("delta") + "xyz"[k]});
    if (d[0] < 0 || d[1] < 0 || d[2] < 0) {
      context_.faults.add(
          context_.file.place(std::max<std::size_t>(1, table_.layout().headerLine)) +
          "an R-test's rows need all of dx, dy and dz; name the columns so, with their unit: dx [um]");
      return;
    }
    for (std::size_t j = 0; j < joints.size(); ++j)
      table_.show(columns[j], "reading of joint " + joints[j].name,
                  joints[j].kind == JointKind::kRotary ? "deg" : "mm");
    for (const int column : d) table_.show(column, "displacement of the ball in workpiece", "");
    rows(columns, d);
  }

 private:
  std::string name() const { return context_.file.path().string(); }

  void rows(const std::vector<int>& columns, const int d[3]) {
    const auto& joints = context_.machine.joints();
    Session session = emptySession(context_);
    const int time = table_.column({"time", "t", "zeit"});
    double seconds = 0.0;
    std::vector<Eigen::Vector3d> tips;
    for (const auto& row : table_.rows()) {
      Observation o = blankRow(context_, ObservationKind::kContact, row.line, seconds);
      bool whole = true;
      for (std::size_t j = 0; j < joints.size(); ++j) {
        if (columns[j] < 0) continue;
        const bool linear = joints[j].kind == JointKind::kLinear;
        o.position[j] = table_.value(row, columns[j], linear ? UnitKind::kLength : UnitKind::kAngle,
                                     linear ? "mm" : "deg");
        if (std::isnan(o.position[j])) whole = missing(row.line, joints[j].name);
      }
      Eigen::Vector3d moved;
      for (int k = 0; k < 3; ++k) {
        moved[k] = table_.value(row, d[k], UnitKind::kLength, context_.mapping.setting("unit"));
        if (std::isnan(moved[k])) whole = missing(row.line, std::string("d") + "xyz"[k]);
      }
      const double t = table_.value(row, time, UnitKind::kTime, "s");
      if (!std::isnan(t)) o.time = t;
      seconds = o.time + 1.0;
      if (!whole) continue;
      tips.push_back(session.machine.nominal(o.position.data(), kNotMeasured).position);
      shift(session.machine, moved, o);
      o.feature = 0;
      session.observations.push_back(std::move(o));
    }
    if (!context_.faults.empty() || tips.empty() || !stays(tips)) return;
    Feature ball;
    ball.kind = FeatureKind::kPoint;
    ball.name = "ball";
    ball.known = false;
    ball.position = tips.front();
    session.artifact = Artifact();
    session.artifact.name = "r_test";
    session.artifact.features.push_back(ball);
    context_.imported.notes.push_back(
        "each row says where the tip was against one ball whose place is free; the readings are those at "
        "which it would have "
        "been on the ball");
    finishImport(context_, std::move(session));
  }

  bool missing(std::size_t line, const std::string& column) {
    context_.faults.add(context_.file.place(line) + "'" + column +
                        "' is empty; an R-test reads all of its columns at once: leave "
                        "the row out");
    return false;
  }

  /// The readings at which the tip would have been on the ball: moved back by what was read, by the linear
  /// joints.
  static void shift(const Machine& machine, const Eigen::Vector3d& moved, Observation& o) {
    Eigen::MatrixXd linear = machine.jacobian(o.position.data(), kNotMeasured).topRows<3>();
    for (int j = 0; j < machine.jointCount(); ++j)
      if (machine.joints()[j].kind == JointKind::kRotary) linear.col(j).setZero();
    const Eigen::VectorXd by = shortestLeastSquares(linear, moved);
    for (int j = 0; j < machine.jointCount(); ++j) o.position[j] -= by[j];
  }

  /// The machine holds the tip at the ball; if it does not, the linear axes were not written down.
  bool stays(const std::vector<Eigen::Vector3d>& tips) {
    constexpr double kNear = 2e-3;  // m: an R-test's probes reach about a millimetre
    double farthest = 0.0;
    for (const auto& tip : tips) farthest = std::max(farthest, (tip - tips.front()).norm());
    if (farthest < kNear) return true;
    context_.faults.add(
        name() +
        format(": the nominal machine does not hold the tip at one place: it moves %.4g mm between the "
               "rows (at most 2 mm can be); are the linear joints (columns x, y, z) in the file, and "
               "is the URDF that machine?",
               farthest / kMillimetre));
    return false;
  }

  ImportContext& context_;
  RecordTable table_;
};

}  // namespace

bool isRTest(const TextFile& file) {
  if (headHas(file, {"r-test", "rtest", "r test"})) return true;
  constexpr std::size_t kLooked = 20;
  for (std::size_t i = 0; i < std::min(kLooked, file.lines().size()); ++i) {
    std::string remark;
    const std::string_view line = file.lines()[i];
    const auto words = wordsOf(takeRemark(line, remark) ? remark : std::string(line));
    int found = 0, rotary = 0;
    for (const std::string& w : words) {
      found += w == "dx" || w == "dy" || w == "dz";
      rotary += w == "a" || w == "b" || w == "c";
    }
    if (found == 3 && rotary > 0) return true;
  }
  return false;
}

void readRTest(ImportContext& context) { RTestReader(context).read(); }

}  // namespace mm
