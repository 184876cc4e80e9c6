#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "base/format.h"
#include "base/text.h"
#include "base/units.h"
#include "import/record_table.h"
#include "machine/joint_units.h"
#include "machine/linear_inverse.h"

namespace mm {
namespace {

class RTestReader {
 public:
  explicit RTestReader(ImportContext& context) : context_(context), table_(context) {}

  void read() {
    if (!table_.bringsArtifact("an R-test", "the ball")) return;
    const auto& joints = context_.machine.joints();
    int rotary = 0;
    for (const Joint& joint : joints) {
      columns_.push_back(table_.column(lower(joint.name)));
      rotary += joint.kind == JointKind::kRotary && columns_.back() >= 0;
    }
    if (rotary == 0) {
      context_.refuse(
          "no column is a rotary joint of this machine; an R-test needs one (name it as the machine does, "
          "e.g. b [deg])");
      return;
    }
    for (const char* words : {"dx deltax", "dy deltay", "dz deltaz"}) d_.push_back(table_.column(words));
    if (*std::min_element(d_.begin(), d_.end()) < 0) {
      table_.refuseHead("R-test data need dx, dy and dz; name the columns with their unit: dx [um]");
      return;
    }
    for (std::size_t j = 0; j < joints.size(); ++j)
      table_.show(columns_[j], "reading of joint " + joints[j].name, readingUnit(joints[j]).symbol);
    for (const int column : d_) table_.show(column, "displacement of the ball in workpiece", "");
    rows();
  }

 private:
  void rows() {
    const auto& joints = context_.machine.joints();
    Session session = ownArtifact(context_, "r_test", {FeatureKind::kPoint, "ball"});
    const int time = table_.column("time t zeit");
    if (time < 0) session.timesAssumed = kTimesInOrder;
    double seconds = 0.0;
    std::vector<Eigen::Vector3d> tips;
    for (const auto& row : table_.rows()) {
      Observation o = blankRow(context_, ObservationKind::kContact, row.line, seconds);
      bool whole = true;
      for (std::size_t j = 0; j < joints.size(); ++j) {
        if (columns_[j] < 0) continue;
        o.position[j] = table_.value(row, columns_[j], unitKindOf(context_.machine, static_cast<int>(j)),
                                     readingUnit(joints[j]).symbol);
        if (std::isnan(o.position[j])) whole = missing(row.line, joints[j].name);
      }
      Eigen::Vector3d moved;
      for (int k = 0; k < 3; ++k) {
        moved[k] = table_.value(row, d_[static_cast<std::size_t>(k)], UnitKind::kLength);
        if (std::isnan(moved[k])) whole = missing(row.line, std::string("d") + "xyz"[k]);
      }
      const double t = table_.value(row, time, UnitKind::kTime);
      if (!std::isnan(t)) o.time = t;
      seconds = o.time + 1.0;
      if (!whole) continue;
      tips.push_back(session.machine.nominal(o.position.data(), kNotMeasured).position);
      shift(session.machine, moved, o);
      o.feature = 0;
      session.observations.push_back(std::move(o));
    }
    if (!context_.faults.empty() || tips.empty() || !stays(tips)) return;
    session.artifact.features[0].position = tips.front();
    context_.note(
        "each row gives the tip position relative to one ball whose position is free; the readings are those "
        "at which the tip would have been at the ball");
    finishImport(context_, std::move(session));
  }

  bool missing(std::size_t line, const std::string& column) {
    context_.refuse(
        line, "'" + column + "' is empty; an R-test reads all of its columns at once: leave the row out");
    return false;
  }

  /// The readings at which the tip would have been on the ball: moved back by what was read, by the linear
  /// joints.
  static void shift(const Machine& machine, const Eigen::Vector3d& moved, Observation& o) {
    const Eigen::VectorXd by = linearMotion(machine, o.position.data(), kNotMeasured, moved).change;
    for (int j = 0; j < machine.jointCount(); ++j) o.position[j] -= by[j];
  }

  /// The machine holds the tip at the ball; if it does not, the linear axes were not written down.
  bool stays(const std::vector<Eigen::Vector3d>& tips) {
    constexpr double kNear = 2e-3;  // m: an R-test's probes reach about a millimetre
    double farthest = 0.0;
    for (const auto& tip : tips) farthest = std::max(farthest, (tip - tips.front()).norm());
    if (farthest < kNear) return true;
    context_.refuse(format(
        "on the nominal machine the tip does not stay at one position: it moves %.4g mm between the rows (at "
        "most 2 mm is allowed); does the file contain the linear joints (columns x, y, z), and is the URDF "
        "that of this machine?",
        farthest / kMillimetre));
    return false;
  }

  ImportContext& context_;
  RecordTable table_;
  std::vector<int> columns_, d_;  // of each joint, -1: none; of dx, dy, dz
};

}  // namespace

bool isRTest(const TextFile& file) {
  if (headHas(file, "r-test|rtest|r test")) return true;
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
