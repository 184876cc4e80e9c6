#include "thermal/numbers.h"

#include <string>

#include "base/error.h"

namespace mm {
namespace {

[[noreturn]] void damaged(const char* what) {
  throw InputError(std::string("stored thermal network: ") + what + "; calibrate again");
}

}  // namespace

void writeMatrix(std::vector<double>& numbers, const Eigen::MatrixXd& matrix) {
  numbers.push_back(static_cast<double>(matrix.rows()));
  numbers.push_back(static_cast<double>(matrix.cols()));
  numbers.insert(numbers.end(), matrix.data(), matrix.data() + matrix.size());
}

double readNumber(const double*& next, const double* end) {
  if (next >= end) damaged("the numbers end too early");
  return *next++;
}

Eigen::MatrixXd readMatrix(const double*& next, const double* end, Eigen::Index rows, Eigen::Index columns) {
  const double r = readNumber(next, end), c = readNumber(next, end);
  if (!(r >= 0.0 && c >= 0.0 && r * c <= static_cast<double>(end - next)))
    damaged("a table does not fit its numbers");
  const auto storedRows = static_cast<Eigen::Index>(r), storedColumns = static_cast<Eigen::Index>(c);
  if ((rows >= 0 && storedRows != rows) || (columns >= 0 && storedColumns != columns))
    damaged("a table has another size than it should");
  const Eigen::MatrixXd matrix = Eigen::Map<const Eigen::MatrixXd>(next, storedRows, storedColumns);
  if (!matrix.allFinite()) damaged("a value is not a finite number");
  next += storedRows * storedColumns;
  return matrix;
}

}  // namespace mm
