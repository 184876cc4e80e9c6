#include "thermal/series.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "base/dense.h"
#include "base/error.h"
#include "base/read_file.h"
#include "base/text.h"

namespace mm {
namespace {

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> result;
  std::size_t begin = 0;
  for (;;) {
    const std::size_t end = line.find(',', begin);
    const std::string_view cell =
        std::string_view(line).substr(begin, end == std::string::npos ? end : end - begin);
    result.emplace_back(trim(cell, " \t\r\""));
    if (end == std::string::npos) return result;
    begin = end + 1;
  }
}

}  // namespace

int SampledSeries::column(const std::string& name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  std::string list;
  constexpr std::size_t kListed = 12;
  for (std::size_t i = 0; i < std::min(kListed, names.size()); ++i) list += (i > 0 ? ", " : "") + names[i];
  if (names.size() > kListed) list += " and " + std::to_string(names.size() - kListed) + " more";
  throw InputError("there is no column '" + name + "'; the columns are: " + list);
}

SampledSeries readSeries(const std::string& path) {
  std::istringstream file(readWholeFile(path, "check the path"));
  SampledSeries series;
  std::vector<double> numbers;
  std::string line;
  int lineNumber = 0;
  while (std::getline(file, line)) {
    ++lineNumber;
    if (lineNumber == 1 && line.compare(0, 3, "\xEF\xBB\xBF") == 0) line.erase(0, 3);
    const std::string_view content = trim(line);
    if (content.empty() || content[0] == '#') continue;
    const std::string where = path + ":" + std::to_string(lineNumber) + ": ";
    const std::vector<std::string> row = cells(line);
    if (series.names.empty()) {
      for (const std::string& name : row) {
        if (name.empty())
          throw InputError(where + "a column has no name; name every column in the first line");
        if (std::find(series.names.begin(), series.names.end(), name) != series.names.end())
          throw InputError(where + "column '" + name + "' appears twice; give every column its own name");
        series.names.push_back(name);
      }
      continue;
    }
    if (row.size() != series.names.size())
      throw InputError(where + std::to_string(row.size()) + " values for " +
                       std::to_string(series.names.size()) +
                       " columns; all series must have the same length");
    for (std::size_t i = 0; i < row.size(); ++i) {
      char* end = nullptr;
      const double value = std::strtod(row[i].c_str(), &end);
      if (row[i].empty() || *end != '\0' || !std::isfinite(value))
        throw InputError(where + "column '" + series.names[i] + "': '" + row[i] +
                         "' is not a finite number; fill the gap or leave the row out");
      numbers.push_back(value);
    }
  }
  if (series.names.empty()) throw InputError(path + ": is empty; the first line must name the columns");
  const auto columns = static_cast<Eigen::Index>(series.names.size());
  series.values = Eigen::Map<const RowMatrix>(numbers.data(),
                                              static_cast<Eigen::Index>(numbers.size()) / columns, columns);
  return series;
}

bool isTimeColumn(const std::string& name) {
  return name == "t" || name == "time" || name.rfind("time_", 0) == 0;
}

double micrometresPerUnit(const std::string& name) {
  if (endsWith(name, "_nm")) return 1e-3;
  if (endsWith(name, "_mm")) return 1e3;
  if (endsWith(name, "_m")) return 1e6;
  return 1.0;
}

}  // namespace mm
