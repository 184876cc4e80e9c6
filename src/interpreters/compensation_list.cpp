// Beckhoff TF5200 "Axis compensation" and ISG kernel, P-COMP-00001 to 00061: 0.1 µm and 0.0001 degrees.
#include "interpreters/compensation_list.h"

#include <algorithm>
#include <cmath>
#include <regex>

#include "base/text.h"
#include "base/units.h"
#include "interpreters/table_sum.h"

namespace mm {
namespace {

constexpr double kListLength = 1e-4;  // mm, deg

double listUnit(const std::string& joint) { return kListLength * jointUnit(joint); }

bool knownListKey(const std::string& key) {
  static const std::regex known(
      R"(kw\.(ssfk\.(unit|interval|kw_startpos|kw_nr_max|bilateral|modulo|max_points|manual_activation|)"
      R"(table\[\d+\]\.(pos|neg|setpoint))|)"
      R"(crosscomp\.(unit|last_index|slave_ax_nr|master_ax_nr|n_cycles|max_points|manual_activation|)"
      R"(table\[\d+\]\.(setpoint|correction))|)"
      R"(crosscomp2\.(unit|interval|interval_master[12]|last_index_master[12]|start_position_master[12]|)"
      R"(master[12]_ax_nr|n_cycles|max_points|manual_activation|grid_type|table\[\d+\]\[\d+\]\.correction)))");
  return std::regex_match(key, known);
}

void needMetric(const CompensationList& list, const std::string& key) {
  if (list.flag(key, false)) return;
  refuse(list.place(key),
         key + " is not 1: values in increments of the encoder have no length here; give 0.1 um");
}

std::string tableKey(const std::string& table, int i, const char* what) {
  return table + ".table[" + std::to_string(i) + "]." + what;
}

/// Leadscrew error compensation: the values are absolute position errors (actual minus programmed, as the
/// documented example computes them), so they are taken off; the ends hold beyond the table (assumed:
/// documented of the plane).
class LeadscrewCompensation : public ListCompensation {
 public:
  LeadscrewCompensation(const CompensationList& list, std::string joint) : joint_(std::move(joint)) {
    needMetric(list, "kw.ssfk.unit");
    const std::string table = "kw.ssfk";
    const int most = std::max(list.integer("kw.ssfk.max_points", 0, kMostTable, 0), 0);
    const int limit = most == 0 ? 1500 : most;
    const int count = list.integer("kw.ssfk.kw_nr_max", 0, kMostTable, 0);
    if (count < 1 || count >= limit)
      refuse(list.place("kw.ssfk.kw_nr_max"), "kw.ssfk.kw_nr_max: " + std::to_string(count) +
                                                  " is not within 1 to " + std::to_string(limit - 1) +
                                                  " (below max_points)");
    const double interval = list.number("kw.ssfk.interval"), start = list.number("kw.ssfk.kw_startpos");
    if (interval < 0.0) refuse(list.place("kw.ssfk.interval"), "kw.ssfk.interval: is below 0");
    const bool bilateral = list.flag("kw.ssfk.bilateral", false);
    std::vector<double> positions, positive, negative;
    for (int i = 0; i < count; ++i) {
      const std::string key = tableKey(table, i, "setpoint");
      const double position = interval > 0.0 ? start + i * interval : list.number(key);
      if (!positions.empty() && position * listUnit(joint_) <= positions.back())
        refuse(list.place(key),
               key + ": " + std::to_string(position) + " is not above that of the entry before");
      positions.push_back(position * listUnit(joint_));
      positive.push_back(-list.number(tableKey(table, i, "pos")) * listUnit(joint_));
      negative.push_back(bilateral ? -list.number(tableKey(table, i, "neg")) * listUnit(joint_)
                                   : positive.back());
    }
    const double period = list.flag("kw.ssfk.modulo", false) ? 2.0 * kPi : 0.0;
    positive_ = {positions, positive, period};
    negative_ = {positions, negative, period};
  }

  double added(const CommandedState& command) const override {
    const double position = commanded(command, joint_);
    return byDirection(command, joint_, positive_.at(position), negative_.at(position));
  }

  void addTo(JointPoints& points) const override {
    addPoints(joint_, positive_, points);
    addPoints(joint_, negative_, points);
  }

  static constexpr int kMostTable = 1000000;

 private:
  std::string joint_;
  Curve positive_, negative_;
};

std::string masterAxis(const CompensationList& list, const std::string& key,
                       const std::map<int, std::string>& axes) {
  const int number = list.integer(key, 1, 1000, 0);
  const auto found = axes.find(number);
  if (found == axes.end())
    refuse(list.place(key), key + ": axis " + std::to_string(number) +
                                " has no list here; give one with its kopf.log_achs_nr");
  return found->second;
}

/// Cross compensation: what is added to this axis by the command of another (corrections relative to the
/// command of the slave: added as they are; the documents give no example with a sign).
class CrossCompensation : public ListCompensation {
 public:
  CrossCompensation(const CompensationList& list, const std::string& slave,
                    const std::map<int, std::string>& axes) {
    needMetric(list, "kw.crosscomp.unit");
    const bool named = list.has("kw.crosscomp.master_ax_nr");
    master_ = masterAxis(list, named ? "kw.crosscomp.master_ax_nr" : "kw.crosscomp.slave_ax_nr", axes);
    const int most = list.integer("kw.crosscomp.max_points", 0, LeadscrewCompensation::kMostTable, 0);
    const int limit = most == 0 ? 1001 : most;
    const int last = list.integer("kw.crosscomp.last_index", 0, limit - 1, 0);
    std::vector<double> positions, values;
    for (int i = 0; i <= last; ++i) {
      const std::string key = tableKey("kw.crosscomp", i, "setpoint");
      const double position = list.number(key) * listUnit(master_);
      if (!positions.empty() && position <= positions.back())
        refuse(list.place(key), key + ": is not above that of the entry before");
      positions.push_back(position);
      values.push_back(list.number(tableKey("kw.crosscomp", i, "correction")) * listUnit(slave));
    }
    curve_ = {positions, values};
  }
  double added(const CommandedState& command) const override {
    return curve_.at(commanded(command, master_));
  }
  void addTo(JointPoints& points) const override { addPoints(master_, curve_, points); }

 private:
  std::string master_;
  Curve curve_;
};

/// Plane compensation: linear between the four points of a square, the margin beyond (documented).
class PlaneCompensation : public ListCompensation {
 public:
  PlaneCompensation(const CompensationList& list, const std::string& slave,
                    const std::map<int, std::string>& axes)
      : first_(masterAxis(list, "kw.crosscomp2.master1_ax_nr", axes)),
        second_(masterAxis(list, "kw.crosscomp2.master2_ax_nr", axes)) {
    const std::string name = "kw.crosscomp2";
    needMetric(list, name + ".unit");
    const int most = list.integer(name + ".max_points", 0, LeadscrewCompensation::kMostTable, 0);
    const int limit = most == 0 ? 10201 : most;
    const int lastFirst = list.integer(name + ".last_index_master1", 0, limit, 0),
              lastSecond = list.integer(name + ".last_index_master2", 0, limit, 0);
    if (static_cast<long>(lastFirst + 1) * (lastSecond + 1) > limit)
      refuse(list.place(name + ".last_index_master1"), name + ": " + std::to_string(lastFirst + 1) + " x " +
                                                           std::to_string(lastSecond + 1) +
                                                           " points are more than " + std::to_string(limit));
    std::vector<double> along = grid(list, first_, "1", lastFirst),
                        across = grid(list, second_, "2", lastSecond);
    for (int j = 0; j <= lastSecond; ++j) {
      std::vector<double> row;
      for (int i = 0; i <= lastFirst; ++i)
        row.push_back(
            list.number(name + ".table[" + std::to_string(j) + "][" + std::to_string(i) + "].correction") *
            listUnit(slave));
      rows_.emplace_back(along, row);
    }
    across_ = std::move(across);
  }

  double added(const CommandedState& command) const override {
    std::vector<double> column;
    for (const Curve& row : rows_) column.push_back(row.at(commanded(command, first_)));
    return Curve(across_, column).at(commanded(command, second_));
  }
  void addTo(JointPoints& points) const override {
    addPoints(first_, rows_.front(), points);
    addPoints(second_, across_, points);
  }

 private:
  static std::vector<double> grid(const CompensationList& list, const std::string& joint,
                                  const std::string& which, int last) {
    const std::string own = "kw.crosscomp2.interval_master" + which;
    const std::string key = list.has(own) ? own : "kw.crosscomp2.interval";
    const double interval = list.number(key);
    if (!(interval > 0.0)) refuse(list.place(key), key + ": " + std::to_string(interval) + " is not above 0");
    const double start = list.number("kw.crosscomp2.start_position_master" + which);
    std::vector<double> positions;
    for (int i = 0; i <= last; ++i) positions.push_back((start + i * interval) * listUnit(joint));
    return positions;
  }

  std::string first_, second_;
  std::vector<Curve> rows_;
  std::vector<double> across_;
};

}  // namespace

void CompensationList::read(const std::filesystem::path& file) {
  if (file_.empty()) file_ = file;
  for (const TextLine& line : textLines(file)) {
    const std::string_view text = trim(std::string_view(line.text).substr(0, line.text.find('#')));
    if (text.empty() || text == ":" || text == "...") continue;
    const std::vector<std::string> words = wordsBetweenBlanks(text);
    if (words.size() < 2) refuse(line.place, "'" + words[0] + "' has no value");
    if (startsWith(words[0], "kw.") && !knownListKey(words[0]))
      refuse(line.place, "'" + words[0] + "' is no parameter of a compensation value list");
    values_[words[0]] = {words[1], line.place};
  }
}

bool CompensationList::hasAny(const std::string& start) const {
  const auto found = values_.lower_bound(start);
  return found != values_.end() && startsWith(found->first, start);
}

FilePlace CompensationList::place(const std::string& key) const {
  const auto found = values_.find(key);
  return found == values_.end() ? FilePlace{file_, 0} : found->second.place;
}

double CompensationList::number(const std::string& key, double missing) const {
  const auto found = values_.find(key);
  return found == values_.end() ? missing : tableNumber(found->second.text, found->second.place, key);
}

int CompensationList::integer(const std::string& key, int lower, int upper, int missing) const {
  const auto found = values_.find(key);
  return found == values_.end() ? missing
                                : tableInteger(found->second.text, found->second.place, key, lower, upper);
}

bool CompensationList::flag(const std::string& key, bool missing) const {
  const auto found = values_.find(key);
  return found == values_.end() ? missing : tableFlag(found->second.text, found->second.place, key);
}

std::vector<std::unique_ptr<ListCompensation>> listCompensations(const CompensationList& list,
                                                                 const std::string& slave,
                                                                 const std::map<int, std::string>& axes) {
  std::vector<std::unique_ptr<ListCompensation>> found;
  if (list.hasAny("kw.ssfk.") && list.flag("lr_param.ssfk", true))
    found.push_back(std::make_unique<LeadscrewCompensation>(list, slave));
  if (list.hasAny("kw.crosscomp.") && list.flag("lr_param.crosscomp", true))
    found.push_back(std::make_unique<CrossCompensation>(list, slave, axes));
  if (list.hasAny("kw.crosscomp2.") && list.flag("lr_param.crosscomp2", true))
    found.push_back(std::make_unique<PlaneCompensation>(list, slave, axes));
  return found;
}

}  // namespace mm
