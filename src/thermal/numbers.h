#pragma once
#include <Eigen/Core>
#include <vector>

namespace mm {

// Networks are stored as plain numbers: a matrix is its two sizes and then its columns.

/// Appends rows, columns and the values column by column.
void writeMatrix(std::vector<double>& numbers, const Eigen::MatrixXd& matrix);
/// Takes one number. Throws InputError at the end.
double readNumber(const double*& next, const double* end);
/// Takes one matrix. Throws InputError when it is cut short or its size is not the expected one (-1: any).
Eigen::MatrixXd readMatrix(const double*& next, const double* end, Eigen::Index rows, Eigen::Index columns);

}  // namespace mm
