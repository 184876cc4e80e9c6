#include "design/moves.h"

#include "base/format.h"
#include "base/units.h"
#include "session/plan_writer.h"

namespace mm {
namespace {

std::string number(double v) { return format("%.9g", v); }

}  // namespace

std::string movesYaml(const std::vector<Move>& moves, const Session& session) {
  if (moves.empty()) return "";
  std::string text = kMovesBegin;
  if (!session.artifact.features.empty()) text += "artifact:\n" + artifactYaml(session.artifact, 2);
  if (session.hasLaser()) text += "probe: laser\n";
  std::string placements;
  for (const Move& move : moves) {
    std::string name;
    for (const auto& [key, word] : move.words)
      if (key == "placement") name = word;
    const std::string begin = "  - {name: \"" + name + "\"";
    if (name.empty() || placements.find(begin + ",") != std::string::npos) continue;
    placements += begin + ", turn_deg: " + number(move.turn / kDegree) + ", shift_mm: [" +
                  number(move.shift.x() / kMillimetre) + ", " + number(move.shift.y() / kMillimetre) + ", " +
                  number(move.shift.z() / kMillimetre) + "]}\n";
  }
  if (!placements.empty()) text += "placements:\n" + placements;
  text += "moves:\n";
  for (const Move& move : moves) {
    std::string entry;
    const auto add = [&](const std::string& key, const std::string& value) {
      entry += (entry.empty() ? "" : ", ") + key + ": " + value;
    };
    for (const auto& [key, value] : move.values) add(key, number(value));
    for (const auto& [key, value] : move.words) add(key, "\"" + value + "\"");
    if (move.approach.size() == 3)
      add("approach", "[" + number(move.approach[0]) + ", " + number(move.approach[1]) + ", " +
                          number(move.approach[2]) + "]");
    for (const auto& [joint, side] : move.from) add("from", "{" + joint + ": " + number(side) + "}");
    text += "  - {" + entry + "}\n";
  }
  return text;
}

}  // namespace mm
