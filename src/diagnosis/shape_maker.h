#pragma once
#include <string>
#include <vector>

#include "diagnosis/groups.h"
#include "estimation/noise_fit.h"
#include "estimation/residual_space.h"

namespace mm {

/// Columns of one shape as its effects give them, before anything is known of what the model's unknowns
/// leave.
struct DraftShape {
  struct Part {
    int first, count;
    double share;
  };
  Shape shape;
  std::vector<Part> parts;  // the first has the main columns
  RowMatrix raw;            // length x all
  std::string why;          // not empty: it cannot be shown
};

/// A shape with its columns as they are asked.
struct MadeShape {
  Shape shape;
  RowMatrix columns;
  std::string why;  // not empty: it cannot be shown
};

/// How the size of a cause changes along the joints of Nature::variesAlong, where it does.
enum class SizeAlong { kSlowly, kAsACurve };

/// Makes shapes in two steps: each is drafted alone, and several are finished together, as what the model's
/// unknowns leave is one product for all of their columns.
class ShapeMaker {
 public:
  explicit ShapeMaker(const ResidualSpace& space)
      : space_(space), problem_(space.problem()), domain_(problem_.model().domain()) {}  ///< outlives it

  /// Why the session cannot show an effect, for reasons that need no columns; empty: it may.
  std::string notTried(const Effect& effect) const;
  /// @param nonlinear values of its nonlinear parameters, SI.
  DraftShape draft(const EffectPtr& effect, const std::vector<double>& nonlinear,
                   SizeAlong along = SizeAlong::kSlowly) const;
  /// In the order of the drafts.
  std::vector<MadeShape> finished(const std::vector<DraftShape>& drafts) const;

  const Domain& domain() const { return domain_; }     ///< of the model
  const Problem& problem() const { return problem_; }  ///< of the space

 private:
  MadeShape finish(const DraftShape& draft, const Eigen::VectorXd& left) const;
  static bool isSeen(const Eigen::Ref<const RowMatrix, 0, Eigen::OuterStride<>>& raw, double sine,
                     double cosine, double both);
  RowMatrix columnsOf(const Effect& effect, const std::vector<double>& nonlinear, std::string& why) const;
  bool settlesAtOnce(const Effect& effect, const std::vector<double>& nonlinear,
                     const RowMatrix& columns) const;
  double scaleOf(const Eigen::Ref<const RowMatrix, 0, Eigen::OuterStride<>>& raw, const Eigen::VectorXd& left,
                 std::string& why) const;
  void weightByPriors(const Effect& effect, Eigen::VectorXd left, MadeShape& made) const;

  const ResidualSpace& space_;
  const Problem& problem_;
  const Domain& domain_;
};

/// The position of a joint at each observation, as its number among those that are further apart than
/// rounding: 0 the lowest.
std::vector<int> positionNumbers(const Problem& problem, int joint);
/// How many there are.
int distinctPositions(const Problem& problem, int joint);

/// Makes the columns of a shape at other values of its nonlinear parameters.
class GroupColumns {
 public:
  explicit GroupColumns(const ResidualSpace& space) : maker_(space), space_(space) {}  ///< outlives it
  /// @return length x k, weighted; no columns where nothing is seen.
  RowMatrix operator()(const EffectPtr& effect, const std::vector<double>& nonlinear) const;

 private:
  ShapeMaker maker_;
  const ResidualSpace& space_;
};

/// How much the size of a cause changes over the travel of a joint along which it is known to change.
constexpr double kVariation = 0.15;

/// Columns of an effect (a row for each of `rows`), from minus themselves at one end of a joint's travel to
/// themselves at the other; zero where it never moved.
void varyAlong(const Problem& problem, const std::vector<int>& rows, int joint, RowMatrix& columns);

/// The same from the beginning of a session to its end.
void varyInTime(const Problem& problem, const std::vector<int>& rows, RowMatrix& columns);

/// Columns of an effect, each times the functions of a curve along a joint: more at one end, in the middle,
/// or where the machine works most. Each as large as it usually is beside the first.
RowMatrix curveAlong(const Problem& problem, const std::vector<int>& rows, int joint,
                     const RowMatrix& columns);

}  // namespace mm
