#pragma once
#include <Eigen/Core>
#include <vector>

namespace mm {

/// Networks are stored as plain numbers, a matrix as its two sizes and then its columns. What a network
/// consists of is told once, in one order: this writes what it is shown, or fills it with what was written.
class NetworkNumbers {
 public:
  NetworkNumbers() = default;                                                                     ///< writes
  explicit NetworkNumbers(const std::vector<double>& stored) : numbers_(stored), reads_(true) {}  ///< reads

  bool reads() const { return reads_; }                            ///< else it writes
  const std::vector<double>& written() const { return numbers_; }  ///< all of them
  /// @throw InputError: there are numbers that nothing has read.
  void finish() const;

  /// One number, a flag or a count too. @throw InputError at the end of what was stored.
  void operator()(double& value);
  void operator()(bool& value);
  void operator()(int& value);
  /// One matrix. @param rows, columns that a stored one must have; -1: any. @throw InputError: it has not, or
  /// is cut short.
  template <typename Matrix>
  void operator()(Matrix& matrix, Eigen::Index rows, Eigen::Index columns) {
    if (reads_)
      matrix = readMatrix(rows, columns);
    else
      writeMatrix(matrix);
  }

 private:
  void writeMatrix(const Eigen::MatrixXd& matrix);
  Eigen::MatrixXd readMatrix(Eigen::Index rows, Eigen::Index columns);

  std::vector<double> numbers_;
  std::size_t next_ = 0;  // to be read
  bool reads_ = false;
};

}  // namespace mm
