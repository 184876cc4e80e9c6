#include "import/redundant_deviation.h"

#include <algorithm>
#include <cmath>

#include "base/format.h"
#include "base/text.h"
#include "base/units.h"
#include "session/csv_cells.h"

namespace mm {
namespace {

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

std::size_t columnOf(const UnderstoodTable& table, CsvRole role, int joint) {
  for (std::size_t i = 0; i < table.form.columns.size(); ++i)
    if (table.form.columns[i].role == role && table.form.columns[i].index == joint) return i;
  return kNone;
}

/// What a table says of one joint in three columns, and how well they agree.
class Comparison {
 public:
  Comparison(const TableLayout& layout, const UnderstoodTable& table, std::size_t target,
             std::size_t measured, std::size_t deviation)
      : layout_(layout), table_(table), target_(target), measured_(measured), deviation_(deviation) {}

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
    const CsvColumn& c = table_.form.columns[i];
    if (i >= cells.size()) return false;
    const std::string_view cell = withoutUnit(cells[i], c.suffix);
    if (!parseNumber(cell, layout_.decimalComma, value)) return false;
    value *= c.factor;
    const std::size_t mark = cell.rfind(layout_.decimalComma ? ',' : '.');
    const auto decimals = mark == std::string_view::npos ? 0 : static_cast<int>(cell.size() - mark - 1);
    const double written = std::abs(c.factor) * std::pow(10.0, -decimals);
    step = step == 0.0 ? written : std::min(step, written);
    return true;
  }

  const TableLayout& layout_;
  const UnderstoodTable& table_;
  std::size_t target_, measured_, deviation_, line_ = 0;
  double same_ = 0.0, opposite_ = 0.0, says_ = 0.0, is_ = 0.0;
  double stepM_ = 0.0, stepD_ = 0.0;
};

void setAside(UnderstoodTable& table, std::size_t i, const std::string& why) {
  table.form.columns[i].role = CsvRole::kIgnored;
  table.columns[i].meaning = "left out: " + why;
}

}  // namespace

void settleRedundant(const TextFile& file, const TableLayout& layout, UnderstoodTable& table,
                     const Machine& machine, ColumnFaults& faults) {
  for (int j = 0; j < machine.jointCount(); ++j) {
    const std::size_t measured = columnOf(table, CsvRole::kMeasured, j);
    const std::size_t deviation = columnOf(table, CsvRole::kDeviation, j),
                      target = columnOf(table, CsvRole::kPosition, j);
    if (measured == kNone || deviation == kNone || target == kNone) continue;
    Comparison comparison(layout, table, target, measured, deviation);
    eachRow(file, layout, [&](std::size_t n, std::string_view, const Cells& cells) {
      if (!sumsUp(cells)) comparison.look(n, cells);
    });
    const std::string joint = machine.joints()[j].name;
    if (comparison.same() && !comparison.opposite() && comparison.deviationIsFiner()) {
      setAside(table, measured, "target plus deviation, which is finer");
    } else if (comparison.same()) {
      setAside(table, deviation, "measured minus target");
    } else if (comparison.opposite()) {
      setAside(table, deviation, "target minus measured, the deviation with its sign changed");
    } else {
      const bool linear = machine.joints()[j].kind == JointKind::kLinear;
      const double unit = linear ? kMicrometre : kArcsecond;
      const char* symbol = linear ? "um" : "arcsec";
      faults.add(file.place(comparison.line()) + "column " + faults.called(deviation) +
                 format(" says %.6g %s, but ", comparison.says() / unit, symbol) + faults.called(measured) +
                 " minus " + faults.called(target) + format(" is %.6g %s; ", comparison.is() / unit, symbol) +
                 faults.remedy(deviation, "ignore") + " (or " + faults.key(measured) +
                 "), or correct the unit of one");
    }
  }
}

}  // namespace mm
