#pragma once
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace mm {

/// One of NIST's nonlinear regression problems, as its file states it.
struct NistProblem {
  std::vector<double> start1, start2, certified, std;
  double residualSum = 0.0;
  std::vector<double> y;
  std::vector<std::vector<double>> x;  // an observation: its predictors
};

inline NistProblem readNist(const std::filesystem::path& file) {
  std::ifstream in(file);
  NistProblem p;
  bool data = false;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    if (data) {
      std::vector<double> row;
      for (double v; words >> v;) row.push_back(v);
      if (row.size() < 2) continue;
      p.y.push_back(row.front());
      p.x.emplace_back(row.begin() + 1, row.end());
      continue;
    }
    std::string name, equals;
    double start1, start2, certified, std;
    if (line.rfind("Residual Sum of Squares:", 0) == 0) p.residualSum = std::stod(line.substr(24));
    if (line.rfind("Data:", 0) == 0 && line.find('y') != std::string::npos && !p.certified.empty())
      data = true;
    if (words >> name >> equals && name[0] == 'b' && equals == "=" &&
        words >> start1 >> start2 >> certified >> std) {
      p.start1.push_back(start1);
      p.start2.push_back(start2);
      p.certified.push_back(certified);
      p.std.push_back(std);
    }
  }
  if (p.certified.empty() || p.y.empty() || !(p.residualSum > 0.0))
    throw std::runtime_error(file.string() + ": not a file of NIST's regression problems");
  return p;
}

}  // namespace mm
