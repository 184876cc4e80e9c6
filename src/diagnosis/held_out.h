#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "diagnosis/search.h"

namespace mm {

/// Standard uncertainties by which what is told must lower the error of rows that were not seen: one in ten
/// that predicts nothing does so by chance.
constexpr double kPredicts = 1.28;

/// What an explanation is worth on rows that it has not seen. Blocks of time are held out with a gap on
/// either side; in each fold its members are fitted to the other rows, the noise being that of all; drift is
/// predicted from its neighbours. What only the rows of a block can determine, such as the centre of a ball
/// that was measured in no other, is fitted to them.
class HeldOut {
 public:
  /// @param found the explanation of all rows, in the order in which its members are told.
  HeldOut(const Search& search, const Explanation& found);

  /// RMS over the rows, in units of the stated noise times `unit`, m or rad.
  double before() const;                   // with nothing found, drift predicted
  double with(std::size_t members) const;  // with the first members
  double all() const;                      // with everything that was found
  /// With one group alone, at its best.
  double withGroup(int group) const;
  /// With these members, fitted to the rows of each fold.
  double withMembers(const std::vector<Member>& members) const;
  /// How much a member lowers the sum of squared errors beside others, over the standard uncertainty that the
  /// errors left give it, blocks of rows being independent; what predicts nothing is about 0. What acts in
  /// one block alone (a jump, a heater that was switched off once) is as sure as what acts in all.
  double worthOf(const Member& member, const std::vector<Member>& beside) const;

 private:
  struct Fold {
    std::vector<char> held;    // a data row: judged in this fold
    std::vector<char> unused;  // judged, or in the gap
    Eigen::MatrixXd own;       // orthonormal: what of the free columns only the judged rows determine
    std::shared_ptr<const Evidence> evidence;
  };
  /// Errors of the judged rows of a fold, what only they determine taken out.
  Eigen::VectorXd errorsOf(const Fold& fold, const std::vector<Member>& members) const;
  double rmsOf(const std::function<std::vector<Member>(const Fold&)>& members) const;

  const Search& search_;
  const Explanation& found_;
  std::vector<Fold> folds_;
};

}  // namespace mm
