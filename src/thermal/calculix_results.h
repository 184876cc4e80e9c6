#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

namespace mm {

/// What a CalculiX run printed of its node sets (*NODE PRINT, NT and U, to `<job>.dat`), one sample a step.
struct CalculixResults {
  std::vector<double> time;           // s
  std::vector<int> nodes;             // of all sets whose temperatures were printed
  Eigen::MatrixXd temperatures;       // samples x nodes, as the deck has them
  std::vector<std::string> sets;      // whose displacements were printed, as CalculiX writes them
  std::vector<Eigen::MatrixXd> mean;  // of a set's nodes, a set: samples x 3, unit of length of the deck

  int samples() const { return static_cast<int>(time.size()); }  ///< points of time
};

/// @throw InputError naming file, line and what to do: no temperatures, a cell that is no finite number, a
/// step that lacks what the first has (ccx stopped early or diverged).
CalculixResults readCalculixResults(const std::string& path);

}  // namespace mm
