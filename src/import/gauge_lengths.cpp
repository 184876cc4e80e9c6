#include "import/gauge_lengths.h"

#include <cmath>
#include <set>
#include <sstream>

#include "base/error.h"
#include "base/format.h"
#include "base/units.h"
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
      context_.faults.add(
          name() + ": the gauge stood along '" + axis +
          "', which is no joint of this machine: a length across several axes needs a pose of its own for "
          "each "
          "placement, and a session has one artifact with one pose; import the placements along single axes "
          "(axis: " +
          context_.machine.joints().front().name + "), or measure balls");
      return;
    }
    if (table_.joint(axis, "axis") < 0) return;
    if (context_.machine.joints()[joint].kind != JointKind::kLinear) {
      context_.faults.add(name() + ": axis '" + axis + "' is rotary; a gauge measures along a linear one");
      return;
    }
    if (!start(joint)) return;
    rows(joint);
  }

 private:
  std::string name() const { return context_.file.path().string(); }

  /// What the machine read at the first face.
  bool start(int joint) {
    origin_ = blankRow(context_, ObservationKind::kDeviation, 0, 0.0).position;
    std::string text =
        table_.said({"start", "start position", "position", "first face", "face 0"}, "position_mm");
    for (char& c : text)
      if (c == ',' || c == ';' || c == '[' || c == ']') c = ' ';
    std::istringstream in(text);
    std::vector<double> values;
    for (std::string word; in >> word;) {
      double v = 0.0;
      if (parseNumber(word, false, v)) values.push_back(v * kMillimetre);
    }
    if (values.size() == 1) {
      origin_[joint] = values[0];
    } else if (values.size() == 3) {
      for (int k = 0; k < 3; ++k)
        if (const int j = jointOf(context_.machine, std::string(1, "xyz"[k])); j >= 0) origin_[j] = values[k];
    } else {
      context_.faults.add(
          name() +
          ": where the gauge began, as the machine reads it at the first face, is not said; write into "
          "the mapping (--columns): position_mm: [0, 0, 0]");
      return false;
    }
    return true;
  }

  void rows(int joint) {
    const int calibrated =
        table_.column({"calibrated", "nominal", "certified", "true", "kalibriert", "reference", "cal"});
    const int indicated =
        table_.column({"indicated", "measured", "reading", "gemessen", "meas", "indication"});
    const int error = table_.column({"error", "e", "el", "e0", "fehler"});
    const int placement = table_.column({"placement", "bar", "gauge", "setup", "position", "run", "line"});
    const int label = placement == calibrated || placement == indicated ? -1 : placement;
    if (calibrated < 0 || (indicated < 0 && error < 0)) {
      context_.faults.add(context_.file.place(std::max<std::size_t>(1, table_.layout().headerLine)) +
                          "a gauge's rows need the calibrated length and the indicated one (or the error of "
                          "indication); name "
                          "the columns calibrated [mm] and indicated [mm]");
      return;
    }
    table_.show(calibrated, "calibrated length", "");
    table_.show(indicated, "indicated length", "");
    if (indicated < 0) table_.show(error, "error of indication, indicated minus calibrated", "");
    table_.show(label, "placement or bar", "");
    const std::string unit = context_.mapping.setting("unit");
    Session session = emptySession(context_);
    std::set<std::string> zeros;  // placements whose first face was read
    for (const auto& row : table_.rows())
      if (table_.value(row, calibrated, UnitKind::kLength, unit) == 0.0)
        zeros.insert(table_.text(row, label));
    std::set<std::string> begun;
    double time = 0.0;
    for (const auto& row : table_.rows()) {
      const double length = table_.value(row, calibrated, UnitKind::kLength, unit);
      double read = table_.value(row, indicated, UnitKind::kLength, unit);
      if (indicated < 0) read = length + table_.value(row, error, UnitKind::kLength, unit);
      if (std::isnan(length) || std::isnan(read)) continue;
      const std::string text = table_.text(row, label), setup = "gauge " + (text.empty() ? "1" : text);
      if (zeros.count(text) == 0 && begun.insert(text).second)
        add(session, row.line, time++, joint, 0.0, 0.0, setup);
      add(session, row.line, time++, joint, read, length - read, setup);
    }
    if (!context_.faults.empty()) return;
    if (!begun.empty())
      context_.imported.notes.push_back(
          "lengths count from the first face, which is a row of its own with deviation 0; each placement or "
          "bar has an unknown "
          "zero of its own, so its lengths count and not where it stood");
    context_.imported.notes.push_back("deviation = calibrated minus indicated length (true minus indicated)");
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
  return headHas(file, {"step gauge", "step-gauge", "stepgauge", "length bar", "gauge block", "iso 10360",
                        "iso10360", "stufenendma"});
}

void readGaugeLengths(ImportContext& context) { GaugeReader(context).read(); }

}  // namespace mm
