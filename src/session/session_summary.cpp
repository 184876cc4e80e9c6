#include "session/session_summary.h"

#include <algorithm>
#include <map>

#include "base/format.h"
#include "base/range.h"
#include "machine/joint_units.h"
#include "session/copied_rows.h"

namespace mm {
namespace {

std::string number(double value) { return format("%.6g", value); }

std::string rangeText(const Range& range, double unit) {
  const double factor = 1.0 / unit;
  return number(range.lower * factor) + " … " + number(range.upper * factor);
}

std::string counted(std::size_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

std::string observationsLine(const Session& session) {
  std::map<ObservationKind, std::size_t> counts;
  for (const Observation& o : session.observations) ++counts[o.kind];
  std::string text;
  for (const auto& [kind, what] :
       {std::pair(ObservationKind::kContact, session.hasLaser() ? "laser contact" : "contact"),
        std::pair(ObservationKind::kPosition, "reference position"),
        std::pair(ObservationKind::kLength, "length"), std::pair(ObservationKind::kDeviation, "row")})
    if (counts[kind] > 0) text += (text.empty() ? "" : ", ") + counted(counts[kind], what);
  if (counts[ObservationKind::kDeviation] > 0) text += " of deviations";
  if (!session.setups.empty()) text += ", in " + counted(session.setups.size(), "setup");
  return text;
}

std::string featuresLine(const Session& session) {
  std::vector<std::size_t> touched(session.artifact.features.size(), 0);
  for (const Observation& o : session.observations)
    if (o.feature >= 0) ++touched[o.feature];
  const auto has = [&](ObservationKind kind) {
    return std::any_of(session.observations.begin(), session.observations.end(),
                       [&](const Observation& o) { return o.kind == kind; });
  };
  const bool lengths = has(ObservationKind::kLength) && !has(ObservationKind::kContact);
  const std::string measured = lengths ? "length" : "contact";
  std::size_t balls = 0, unused = 0;
  for (std::size_t i = 0; i < touched.size(); ++i) {
    balls += session.artifact.features[i].kind == FeatureKind::kBall;
    unused += touched[i] == 0;
  }
  std::string text = "artifact      " + session.artifact.name + ": " + counted(balls, "ball") + ", " +
                     counted(touched.size() - balls, "point") + ", pose " +
                     (session.artifact.poseKnown ? "known" : "free");
  if (unused > 0) text += "; " + std::to_string(unused) + " never touched";
  const auto [least, most] = std::minmax_element(touched.begin(), touched.end());
  if (!touched.empty())
    text +=
        "; " + (*least == *most ? "" : std::to_string(*least) + " … ") + counted(*most, measured) + " each";
  return text + "\n";
}

std::string column(const std::string& name) {
  return name + std::string(name.size() < 13 ? 13 - name.size() : 0, ' ') + " ";
}

std::string seriesLines(const std::vector<Series>& all) {
  std::string text;
  for (const Series& s : all) {
    Range range;
    for (const double v : s.value) range.add(v);
    text += column(s.name) + rangeText(range, 1.0) + " " + s.unit + " (" + counted(s.value.size(), "value") +
            ")\n";
  }
  return text;
}

}  // namespace

std::string summarize(const Session& session) {
  const double duration = session.observations.back().time - session.observations.front().time;
  const bool timed =
      session.timed(session.observations.front()) || session.timed(session.observations.back());
  std::string text =
      column("session") + observationsLine(session) + (timed ? ", over " + number(duration) + " s\n" : "\n");
  if (!session.artifact.features.empty()) text += featuresLine(session);
  for (std::size_t j = 0; j < session.machine.joints().size(); ++j) {
    const Joint& joint = session.machine.joints()[j];
    Range range;
    bool directed = false;
    for (const Observation& o : session.observations) {
      range.add(o.position[j]);
      directed = directed || o.travel[j] != 0.0;
    }
    const auto [unit, symbol] = readingUnit(joint);
    if (range.lower == range.upper)
      text += column(joint.name) + "stays at " + number(range.lower * (1.0 / unit)) + " " + symbol + "\n";
    else
      text += column(joint.name) + rangeText(range, unit) + " " + symbol +
              (directed ? "" : ", direction of travel not known") + "\n";
  }
  text += seriesLines(session.temperatures) + seriesLines(session.covariates);
  if (session.compensation.stated != ControllerCompensation::Stated::kNot)
    text += "compensation that was active: " + session.compensation.inWords() + "\n";
  const std::string assumed = assumedText(session);
  if (!assumed.empty()) text += assumed + "\n";
  for (const std::string& line : setAsideLines(session)) text += line + "\n";
  if (!session.warning.empty()) text += "warning: " + session.warning + "\n";
  return text;
}

std::string assumedText(const Session& session) {
  std::vector<std::pair<std::string, std::string>> ways;  // how, joints with their shares
  for (const AssumedInput& a : session.assumed) {
    auto way = std::find_if(ways.begin(), ways.end(), [&](const auto& w) { return w.first == a.how; });
    if (way == ways.end()) way = ways.insert(way, {a.how, ""});
    way->second += (way->second.empty() ? "" : ", ") + a.joint + format(" in %.3g %%", 100.0 * a.share);
  }
  std::string text;
  for (const auto& [how, joints] : ways)
    text += (text.empty() ? "assumed, where no motion was recorded: direction of travel" : "") +
            ("\n  " + how) + " (" + joints + ")";
  if (!text.empty()) text += " of the observations";
  const auto& all = session.observations;
  const auto untimed =
      std::count_if(all.begin(), all.end(), [&](const Observation& o) { return !session.timed(o); });
  if (untimed == 0) return text;
  return text + (text.empty() ? "" : "\n") + "assumed, as no times were recorded: the order of " +
         (untimed == static_cast<long>(all.size()) ? std::string("the observations")
                                                   : std::to_string(untimed) + " observations") +
         " is that of the rows; no effect of time can be told";
}

std::string lossText(const Session& session) {
  std::string text = session.warning;
  if (!session.setAside.empty())
    text += (text.empty() ? "" : "; ") + std::to_string(session.setAside.size()) +
            (session.setAside.size() == 1 ? " is set aside: " : " are set aside, first: ") +
            setAsideText(session, session.setAside.front());
  return text;
}

std::string setAsideText(const Session& session, const SetAside& aside) {
  if (aside.field == kCopiedRow) return session.rowText(aside.row, aside.recording) + " " + aside.why;
  if (!aside.observation && !aside.logged) return aside.field + " is set aside: " + aside.why;
  return (aside.row > 0 ? session.rowText(aside.row, aside.recording) + ": " : "") +
         (aside.observation ? "the row is set aside: " : "a value is set aside: ") + aside.field + " = " +
         aside.value + ": " + aside.why;
}

std::vector<std::string> setAsideLines(const Session& session) {
  constexpr std::size_t kCopiesTold = 3;
  std::vector<std::string> lines;
  std::size_t copies = 0;
  for (const SetAside& aside : session.setAside)
    if (aside.field != kCopiedRow || ++copies <= kCopiesTold) lines.push_back(setAsideText(session, aside));
  if (copies > kCopiesTold)
    lines.push_back(std::to_string(copies - kCopiesTold) + " more rows appear twice and are used once");
  return lines;
}

}  // namespace mm
