#include "thermal/numbers.h"

#include <string>

#include "base/error.h"

namespace mm {
namespace {

[[noreturn]] void damaged(const char* what) {
  throw InputError(std::string("stored thermal network: ") + what + "; calibrate again");
}

}  // namespace

void NetworkNumbers::operator()(double& value) {
  if (!reads_) return numbers_.push_back(value);
  if (next_ >= numbers_.size()) damaged("the numbers end too early");
  value = numbers_[next_++];
}

void NetworkNumbers::operator()(bool& value) {
  double number = value ? 1.0 : 0.0;
  (*this)(number);
  value = number != 0.0;
}

void NetworkNumbers::operator()(int& value) {
  double number = value;
  (*this)(number);
  value = static_cast<int>(number);
}

void NetworkNumbers::finish() const {
  if (next_ != numbers_.size()) damaged("there are numbers too many");
}

void NetworkNumbers::writeMatrix(const Eigen::MatrixXd& matrix) {
  numbers_.push_back(static_cast<double>(matrix.rows()));
  numbers_.push_back(static_cast<double>(matrix.cols()));
  numbers_.insert(numbers_.end(), matrix.data(), matrix.data() + matrix.size());
}

Eigen::MatrixXd NetworkNumbers::readMatrix(Eigen::Index rows, Eigen::Index columns) {
  double r = 0.0, c = 0.0;
  (*this)(r);
  (*this)(c);
  if (!(r >= 0.0 && c >= 0.0 && r * c <= static_cast<double>(numbers_.size() - next_)))
    damaged("a table does not fit its numbers");
  const auto storedRows = static_cast<Eigen::Index>(r), storedColumns = static_cast<Eigen::Index>(c);
  if ((rows >= 0 && storedRows != rows) || (columns >= 0 && storedColumns != columns))
    damaged("a table has another size than it should");
  const Eigen::MatrixXd matrix =
      Eigen::Map<const Eigen::MatrixXd>(numbers_.data() + next_, storedRows, storedColumns);
  if (!matrix.allFinite()) damaged("a value is not a finite number");
  next_ += static_cast<std::size_t>(matrix.size());
  return matrix;
}

}  // namespace mm
