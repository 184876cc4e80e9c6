#pragma once
#include <Eigen/Core>
#include <type_traits>

namespace mm {

/// Rows in one piece of memory: one observation after the other, as they come in time.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Dense decompositions of matrices whose size is known at run time. They are compiled here, once: Eigen's
// templates cost 3 to 12 s of compile time in every source that uses them.

namespace dense {
template <typename B>
using Like = std::conditional_t<B::ColsAtCompileTime == 1, Eigen::VectorXd, Eigen::MatrixXd>;

// Each: of the function of that name below, for one column and for several.
void leastSquares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, Eigen::VectorXd& x);
void leastSquares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, Eigen::MatrixXd& x);
void shortest(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double threshold, Eigen::VectorXd& x);
void shortest(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double threshold, Eigen::MatrixXd& x);
void solveSymmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, Eigen::VectorXd& x);
void solveSymmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, Eigen::MatrixXd& x);
}  // namespace dense

/// x with the least |a x - b|, of each column of b, by QR with column pivots.
template <typename B>
dense::Like<B> leastSquares(const Eigen::MatrixXd& a, const Eigen::MatrixBase<B>& b) {
  dense::Like<B> x;
  dense::leastSquares(a, dense::Like<B>(b.derived()), x);
  return x;
}

/// The shortest of all x with the least |a x - b|. @param threshold below which a pivot is 0, of the largest;
/// 0: rounding.
template <typename B>
dense::Like<B> shortestLeastSquares(const Eigen::MatrixXd& a, const Eigen::MatrixBase<B>& b,
                                    double threshold = 0.0) {
  dense::Like<B> x;
  dense::shortest(a, dense::Like<B>(b.derived()), threshold, x);
  return x;
}

/// x with a x = b, of a symmetric matrix that is positive or negative semidefinite, by LDLᵀ.
template <typename B>
dense::Like<B> solveSymmetric(const Eigen::MatrixXd& a, const Eigen::MatrixBase<B>& b) {
  dense::Like<B> x;
  dense::solveSymmetric(a, dense::Like<B>(b.derived()), x);
  return x;
}

/// Inverse of a symmetric matrix that is positive definite.
Eigen::MatrixXd inverseOfSymmetric(const Eigen::MatrixXd& a);

/// Eigenvalues of a symmetric matrix, ascending, and its eigenvectors, a column each. Its lower triangle
/// counts.
struct SymmetricEigen {
  explicit SymmetricEigen(const Eigen::MatrixXd& a);  ///< decomposes it
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/// Rank by QR with column pivots, and orthonormal columns that span what the columns of `a` do.
/// @param threshold below which a pivot is 0, of the largest; 0: rounding.
Eigen::Index rankOf(const Eigen::MatrixXd& a, double threshold = 0.0);
Eigen::MatrixXd spanOf(const Eigen::MatrixXd& a, double threshold = 0.0);

/// The Moore-Penrose inverse.
Eigen::MatrixXd pseudoInverse(const Eigen::MatrixXd& a);

/// r of a = q r with orthonormal columns of q, its first rows only, by QR without pivots.
Eigen::MatrixXd triangleOf(Eigen::MatrixXd a);

/// qᵀ b of a = q r with orthonormal columns of q, by QR without pivots.
Eigen::MatrixXd orthogonalParts(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Singular values, descending, and all right singular vectors, a column each.
struct RightSingular {
  explicit RightSingular(const Eigen::MatrixXd& a);  ///< decomposes it
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/// The rotation r with the largest trace of rᵀ a: of a = Σ to fromᵀ it turns `from` into `to` by least
/// squares (B. K. P. Horn, J. Opt. Soc. Am. A 4 (1987) 629: its quaternion is the eigenvector of the largest
/// eigenvalue).
Eigen::Matrix3d nearestRotation(const Eigen::Matrix3d& a);

/// l with l lᵀ = a, of a symmetric matrix that is positive definite. Its lower triangle counts.
class Cholesky {
 public:
  Cholesky() = default;
  explicit Cholesky(const Eigen::MatrixXd& a);  ///< decomposes it

  const Eigen::MatrixXd& lower() const { return lower_; }  ///< l; zero above its diagonal
  double logDeterminant() const;                           ///< of a
  Eigen::VectorXd solveLower(Eigen::VectorXd b) const;     ///< x with l x = b
  Eigen::VectorXd solveUpper(Eigen::VectorXd b) const;     ///< x with lᵀ x = b
  void solveLowerInPlace(Eigen::MatrixXd& b) const;        ///< of each column of b
  void solveLowerInPlace(RowMatrix& b) const;              ///< of each column of b
  Eigen::MatrixXd inverse() const;                         ///< of a

 private:
  Eigen::MatrixXd lower_;
};

}  // namespace mm
