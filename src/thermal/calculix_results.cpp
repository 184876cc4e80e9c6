#include "thermal/calculix_results.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

#include "base/error.h"

namespace mm {
namespace {

/// One printed step.
struct Step {
  double time = 0.0;
  std::map<int, double> temperatures;                                      // by node
  std::map<std::string, std::pair<Eigen::RowVector3d, int>> displacement;  // by set: sum, number of nodes
};

/// The two headings that are read, ` temperatures for set NAME and time 0.72E+02` and ` displacements
/// (vx,vy,vz) for set …`; what other headings announce is passed over.
enum class Block { kNone, kTemperatures, kDisplacements };

class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path) {}

  std::vector<Step> read() {
    std::ifstream file(path_);
    if (!file) throw InputError(path_ + ": cannot be opened; check the path");
    for (std::string line; std::getline(file, line);) {
      ++line_;
      if (line.find(" and time ") != std::string::npos)
        heading(line);
      else
        values(line);
    }
    if (file.bad()) throw InputError(path_ + ": cannot be read to its end; check the disk");
    return std::move(steps_);
  }

  InputError error(const std::string& what) const {
    return InputError(path_ + ":" + std::to_string(line_) + ": " + what + " after " +
                      std::to_string(steps_.size()) + " steps; ccx stopped early or diverged, see its log");
  }

 private:
  double numberOf(const std::string& word) const {
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (word.empty() || *end != '\0' || !std::isfinite(value))
      throw error("'" + word + "' is not a finite number");
    return value;
  }

  void heading(const std::string& line) {
    const auto words = [&](const std::string& before, const std::string& after) {
      const auto begin = line.find(before);
      if (begin == std::string::npos) return std::string();
      std::istringstream rest(line.substr(begin + before.size()));
      std::string word;
      rest >> word;
      return after.empty() || rest.str().find(after) != std::string::npos ? word : std::string();
    };
    const double time = numberOf(words(" and time ", ""));
    if (steps_.empty() || steps_.back().time != time) {
      steps_.emplace_back();
      steps_.back().time = time;
    }
    set_ = words(" for set ", " and time ");
    block_ = line.find("temperatures") != std::string::npos    ? Block::kTemperatures
             : line.find("displacements") != std::string::npos ? Block::kDisplacements
                                                               : Block::kNone;
  }

  void values(const std::string& line) {
    if (block_ == Block::kNone) return;
    std::istringstream cells(line);
    std::vector<double> row;
    for (std::string word; cells >> word;) row.push_back(numberOf(word));
    if (row.empty()) return;
    const std::size_t wanted = block_ == Block::kTemperatures ? 2 : 4;
    if (row.size() != wanted)
      throw error(std::to_string(row.size()) + " numbers where " + std::to_string(wanted) + " are due");
    if (block_ == Block::kTemperatures) {
      steps_.back().temperatures[static_cast<int>(row[0])] = row[1];
    } else {
      auto& [sum, count] =
          steps_.back().displacement.try_emplace(set_, Eigen::RowVector3d::Zero(), 0).first->second;
      sum += Eigen::RowVector3d(row[1], row[2], row[3]);
      ++count;
    }
  }

  std::string path_, set_;
  int line_ = 0;
  Block block_ = Block::kNone;
  std::vector<Step> steps_;
};

/// Whether a step has the nodes and sets of another.
bool sameShape(const Step& a, const Step& b) {
  if (a.temperatures.size() != b.temperatures.size() || a.displacement.size() != b.displacement.size())
    return false;
  for (const auto& [node, value] : a.temperatures)
    if (b.temperatures.count(node) == 0) return false;
  for (const auto& [set, sum] : a.displacement) {
    const auto found = b.displacement.find(set);
    if (found == b.displacement.end() || found->second.second != sum.second) return false;
  }
  return true;
}

}  // namespace

CalculixResults readCalculixResults(const std::string& path) {
  Reader reader(path);
  const std::vector<Step> steps = reader.read();
  if (steps.empty() || steps.front().temperatures.empty())
    throw InputError(path +
                     ": no temperatures; print them in the deck: *NODE PRINT, NSET=<candidates>, then NT");
  CalculixResults results;
  const auto samples = static_cast<Eigen::Index>(steps.size());
  for (const auto& [node, value] : steps.front().temperatures) results.nodes.push_back(node);
  for (const auto& [set, sum] : steps.front().displacement) {
    results.sets.push_back(set);
    results.mean.emplace_back(samples, 3);
  }
  results.temperatures.resize(samples, static_cast<Eigen::Index>(results.nodes.size()));
  for (Eigen::Index s = 0; s < samples; ++s) {
    const Step& step = steps[static_cast<std::size_t>(s)];
    if (!sameShape(steps.front(), step))
      throw InputError(path + ": the step at " + std::to_string(step.time) + " s, " + std::to_string(s + 1) +
                       " of " + std::to_string(samples) +
                       ", is incomplete; ccx stopped early or diverged, see its log");
    results.time.push_back(step.time);
    Eigen::Index column = 0;
    for (const auto& [node, value] : step.temperatures) results.temperatures(s, column++) = value;
    std::size_t set = 0;
    for (const auto& [name, sum] : step.displacement) results.mean[set++].row(s) = sum.first / sum.second;
  }
  return results;
}

}  // namespace mm
