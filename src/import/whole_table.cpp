#include "import/whole_table.h"

#include <algorithm>
#include <cmath>

#include "base/format.h"
#include "base/text.h"
#include "import/column_words.h"
#include "import/meaning.h"
#include "import/unit.h"
#include "machine/joint_units.h"
#include "session/csv_cells.h"

namespace mm {
namespace {

/// What may hold the measurement of a table in which nothing says so: the column left out that is in the
/// smallest unit of length, else one of a few words, else the last.
ColumnRemedy guessed(const TableLayout& layout, const std::vector<ColumnSample>& samples,
                     const Machine& machine, const TableForm& form) {
  std::size_t best = layout.names.size(), words = best, last = 0;
  Unit least;
  int joint = 0;
  for (std::size_t i = 0; i < layout.names.size(); ++i) {
    const CsvColumn& c = form.columns[i];
    if (c.role == CsvRole::kPosition) joint = c.index;
    if (c.role != CsvRole::kIgnored) continue;
    const NameAndUnit split = splitUnit(layout.names[i]);
    const auto unit = parseUnit(split.unitText.empty() ? layout.units[i] : split.unitText, UnitKind::kLength);
    if (samples[i].numbers > 0 && unit && (best == layout.names.size() || unit->factor < least.factor))
      best = i, least = *unit;
    last = i;
    if (samples[i].numbers == 0 && samples[i].texts > 0) words = i;
  }
  if (best < layout.names.size()) {
    const std::string of = machine.joints()[joint].name + "_" + least.symbol;
    return {best, "deviation_" + of, " (true minus indicated; error_" + of + " for the other sign)"};
  }
  return {words < layout.names.size() ? words : last, "feature", ""};
}

/// Without a column that says what was touched it may be the only ball that there is.
void onlyFeature(const ImportContext& context, const TableLayout& layout,
                 const std::vector<ColumnSample>& samples, TableForm& form, ColumnFaults& faults) {
  const Artifact* artifact = context.artifact;
  if (artifact != nullptr && artifact->features.size() == 1) {
    form.onlyFeature = 0;
    context.note("no column names the feature: '" + artifact->features.front().name +
                 "', the only one of the artifact");
    return;
  }
  ColumnRemedy remedy = guessed(layout, samples, context.machine, form);
  if (artifact == nullptr) remedy.after += ", or give an --artifact of one ball";
  faults.add(faults.place() +
                 "no column holds a measurement: a ball (feature), a true position (reference_x_mm), a "
                 "length (length_mm) or a deviation (deviation_x_um)",
             remedy);
}

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

std::size_t columnOf(const TableForm& form, CsvRole role, int joint) {
  for (std::size_t i = 0; i < form.columns.size(); ++i)
    if (form.columns[i].role == role && form.columns[i].index == joint) return i;
  return kNone;
}

/// What a table says of one joint in three columns, and how well they agree.
class Comparison {
 public:
  Comparison(const TableForm& form, std::size_t target, std::size_t measured, std::size_t deviation)
      : form_(form), target_(target), measured_(measured), deviation_(deviation) {}

  void look(std::size_t line, const std::vector<std::string_view>& cells) {
    double t = 0.0, m = 0.0, d = 0.0;
    double stepT = 0.0;
    if (!read(cells, target_, t, stepT) || !read(cells, measured_, m, stepM_) ||
        !read(cells, deviation_, d, stepD_))
      return;
    const double same = std::abs(d - (m - t)), opposite = std::abs(d + (m - t));
    if (same > same_) same_ = same, line_ = line, says_ = d, is_ = m - t;
    opposite_ = std::max(opposite_, opposite);
  }
  /// Half a step of what is rounded, and a little for the arithmetic. Targets are what was commanded.
  double tolerance() const { return 0.51 * (2.0 * stepM_ + stepD_); }
  bool same() const { return same_ <= tolerance(); }
  bool opposite() const { return opposite_ <= tolerance(); }
  bool deviationIsFiner() const { return stepD_ < 0.9 * stepM_; }
  std::size_t line() const { return line_; }
  double says() const { return says_; }
  double is() const { return is_; }

 private:
  /// @param step gets the least step that is written, in SI.
  bool read(const std::vector<std::string_view>& cells, std::size_t i, double& value, double& step) {
    const CsvColumn& c = form_.columns[i];
    if (i >= cells.size()) return false;
    const std::string_view cell = withoutUnit(cells[i], c.suffix);
    if (!parseNumber(cell, form_.decimalComma, value)) return false;
    value *= c.factor;
    const std::size_t mark = cell.rfind(form_.decimalComma ? ',' : '.');
    const auto decimals = mark == std::string_view::npos ? 0 : static_cast<int>(cell.size() - mark - 1);
    const double written = std::abs(c.factor) * std::pow(10.0, -decimals);
    step = step == 0.0 ? written : std::min(step, written);
    return true;
  }

  const TableForm& form_;
  std::size_t target_, measured_, deviation_, line_ = 0;
  double same_ = 0.0, opposite_ = 0.0, says_ = 0.0, is_ = 0.0;
  double stepM_ = 0.0, stepD_ = 0.0;
};

/// A table may give target, measured position and deviation of one joint: the deviation is measured minus
/// target, or the opposite. The finer of the two is kept, the other set aside with the reason; where they
/// disagree by more than they are written to, that is a fault.
void settleRedundant(const ImportContext& context, const TableLayout& layout, TableForm& form,
                     ColumnFaults& faults) {
  const Machine& machine = context.machine;
  const auto setAside = [&](std::size_t i, const std::string& why) {
    form.columns[i].role = CsvRole::kIgnored;
    context.imported.columns[i].meaning = "left out: " + why;
  };
  for (int j = 0; j < machine.jointCount(); ++j) {
    const std::size_t measured = columnOf(form, CsvRole::kMeasured, j);
    const std::size_t deviation = columnOf(form, CsvRole::kDeviation, j),
                      target = columnOf(form, CsvRole::kPosition, j);
    if (measured == kNone || deviation == kNone || target == kNone) continue;
    Comparison comparison(form, target, measured, deviation);
    eachRow(context.file, layout, [&](std::size_t n, std::string_view, const Cells& cells) {
      if (!sumsUp(cells)) comparison.look(n, cells);
    });
    const std::string joint = machine.joints()[j].name;
    if (comparison.same() && !comparison.opposite() && comparison.deviationIsFiner()) {
      setAside(measured, "target plus deviation, which is finer");
    } else if (comparison.same()) {
      setAside(deviation, "measured minus target");
    } else if (comparison.opposite()) {
      setAside(deviation, "target minus measured, the deviation with its sign changed");
    } else {
      const auto [unit, symbol] = errorUnit(machine.joints()[j]);
      faults.add(context.file.place(comparison.line()) + "column " + faults.called(deviation) +
                     format(" says %.6g %s, but ", comparison.says() / unit, symbol) +
                     faults.called(measured) + " minus " + faults.called(target) +
                     format(" is %.6g %s", comparison.is() / unit, symbol),
                 {deviation, "ignore", " (or " + faults.key(measured) + "), or correct the unit of one"});
    }
  }
}

}  // namespace

void completeTable(const ImportContext& context, const TableLayout& layout,
                   const std::vector<ColumnSample>& samples, TableForm& form, ColumnFaults& faults) {
  const Machine& machine = context.machine;
  if (!faults.empty()) return;
  settleRedundant(context, layout, form, faults);
  if (form.hasAny({CsvRole::kFeature}) && context.artifact == nullptr)
    faults.add(faults.place() +
               "the file names features; give the artifact that defines them, with --artifact");
  if (!form.hasAny({CsvRole::kFeature, CsvRole::kReference, CsvRole::kDeviation, CsvRole::kMeasured}))
    onlyFeature(context, layout, samples, form, faults);
  if (!form.hasAny({CsvRole::kPosition}) && faults.empty() && form.fixed.empty())
    faults.add(
        faults.place() + "no column is a reading of a joint of this machine (" + jointNames(machine) + ")",
        {0, machine.joints().front().name + "_mm", ""});
  if (!form.hasAny({CsvRole::kTime, CsvRole::kDate}))
    context.note("no time column: rows are taken in their order; no effect of time can be told");
}

}  // namespace mm
