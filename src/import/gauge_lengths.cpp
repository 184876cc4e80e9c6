#include <cmath>
#include <set>

#include "import/record_table.h"
#include "import/unit.h"

namespace mm {
namespace {

class GaugeReader {
 public:
  explicit GaugeReader(ImportContext& context) : context_(context), table_(context) {}

  void read() {
    const std::string axis = table_.said({"axis", "achse", "line", "measuring line", "orientation"}, "axis");
    const int joint = jointOf(context_.machine, axis);
    if (!axis.empty() && joint < 0) {
      context_.refuse(
          "the gauge was aligned along '" + axis +
          "', which is not a joint of this machine: a length across several axes needs a separate pose for "
          "each placement, but a session has one artifact with one pose; import the placements along single "
          "axes (axis: " +
          context_.machine.joints().front().name + "), or measure balls");
      return;
    }
    if (table_.joint(axis, "axis") < 0) return;
    if (context_.machine.joints()[joint].kind != JointKind::kLinear) {
      context_.refuse("axis '" + axis + "' is rotary; a gauge measures along a linear one");
      return;
    }
    origin_ = blankRow(context_, ObservationKind::kDeviation, 0, 0.0).position;
    if (table_.place({"start", "start position", "position", "first face", "face 0"}, "position_mm",
                     "the gauge (machine reading at its first face)", {joint}, origin_))
      rows(joint);
  }

 private:
  void rows(int joint) {
    const int calibrated = table_.column("calibrated nominal certified true kalibriert reference cal");
    const int indicated = table_.column("indicated measured reading gemessen meas indication");
    const int error = table_.column("error e el e0 fehler");
    const int placement = table_.column("placement bar gauge setup position run line");
    const int label = placement == calibrated || placement == indicated ? -1 : placement;
    if (calibrated < 0 || (indicated < 0 && error < 0)) {
      table_.refuseHead(
          "gauge data need the calibrated and the indicated length (or the error of indication); name the "
          "columns calibrated [mm] and indicated [mm]");
      return;
    }
    table_.show(calibrated, "calibrated length", "");
    table_.show(indicated, "indicated length", "");
    if (indicated < 0) table_.show(error, "error of indication, indicated minus calibrated", "");
    table_.show(label, "placement or bar", "");
    const auto length = [&](const RecordTable::Row& row, int column) {
      return table_.value(row, column, UnitKind::kLength);
    };
    Session session = emptySession(context_);
    session.timesAssumed = kTimesInOrder;
    std::set<std::string> zeros;  // placements whose first face was read
    for (const auto& row : table_.rows())
      if (length(row, calibrated) == 0.0) zeros.insert(table_.text(row, label));
    std::set<std::string> begun;
    double time = 0.0;
    for (const auto& row : table_.rows()) {
      const double is = length(row, calibrated);
      const double read = indicated < 0 ? is + length(row, error) : length(row, indicated);
      if (std::isnan(is) || std::isnan(read)) continue;
      const std::string text = table_.text(row, label), setup = "gauge " + (text.empty() ? "1" : text);
      if (zeros.count(text) == 0 && begun.insert(text).second)
        add(session, row.line, time++, joint, 0.0, 0.0, setup);
      add(session, row.line, time++, joint, read, is - read, setup);
    }
    if (!context_.faults.empty()) return;
    if (!begun.empty())
      context_.note(
          "lengths count from the first face, which is a separate row with deviation 0; each placement or "
          "bar has its own unknown zero, so its lengths are used but not its position");
    context_.note("deviation = calibrated minus indicated length (true minus indicated)");
    finishImport(context_, std::move(session));
  }

  void add(Session& session, std::size_t line, double time, int joint, double length, double deviation,
           const std::string& setup) const {
    Observation o = blankRow(context_, ObservationKind::kDeviation, line, time);
    o.position = origin_;
    o.position[joint] += length;
    o.deviation[joint] = deviation;
    o.setup = setupIndex(session, setup);
    session.observations.push_back(std::move(o));
  }

  ImportContext& context_;
  RecordTable table_;
  std::vector<double> origin_;  // readings at the first face
};

}  // namespace

bool isGaugeLengths(const TextFile& file) {
  return headHas(file,
                 "step gauge|step-gauge|stepgauge|length bar|gauge block|iso 10360|iso10360|stufenendma");
}

void readGaugeLengths(ImportContext& context) { GaugeReader(context).read(); }

}  // namespace mm
