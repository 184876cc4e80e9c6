#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "diagnosis/residual_space.h"
#include "effects/effect.h"

namespace mm {

/// One effect that is not in the model, at one value of its nonlinear parameters (a period, a time constant).
struct Atom {
  int candidate = 0;              // index of the family member it belongs to
  std::vector<double> nonlinear;  // SI, in the order of Effect::nonlinearParameters()
  int first = 0, count = 0;       // its columns in CandidateSet::columns
  Eigen::VectorXd norms;          // of its columns before they were made of length 1
};

/// An effect to be tried, and whether this session can show it.
struct Candidate {
  EffectSpec spec;
  EffectPtr effect;
  std::vector<int> linear;  // parameters that give columns
  int freeParameters = 0;   // linear and nonlinear
  Eigen::VectorXd raw;      // norms of the linear parameters' columns before the model absorbs its part
  /// What its parameters cost, in log-likelihood: 1/2 ln N for the combination that the session shows best
  /// and for each nonlinear one, less for the others, the less the session shows of them (their likely sizes
  /// are alike: the Occam factor of a prior as wide in each), and nothing for what it does not show.
  double cost = 0.0;
  bool tried = false;
  std::string why;        // why it is not tried
  double logTried = 0.0;  // log of the number of values searched for its nonlinear parameters
};

/// All candidates of a session with their projected columns.
struct CandidateSet {
  std::vector<Candidate> candidates;
  std::vector<Atom> atoms;
  Eigen::MatrixXd columns;  // length x all columns of all atoms, projected, each of length 1
  double logTried = 0.0;    // log of the number of atoms: what significance pays for

  /// Projected columns of an atom in units of the parameters' scale.
  Eigen::MatrixXd columnsOf(const Atom& atom) const {
    return columns.middleCols(atom.first, atom.count) * atom.norms.asDiagonal();
  }
  /// Projected columns of one candidate at other values of its nonlinear parameters.
  Eigen::MatrixXd columnsAt(const ResidualSpace& space, int candidate,
                            const std::vector<double>& nonlinear) const;
};

/// The effects of the model are no candidates again with the same keys; composites are none. A screw whose
/// period the model has may also err at its harmonics: these are candidates.
/// @param extra further ones.
CandidateSet makeCandidates(const ResidualSpace& space, const std::vector<EffectSpec>& extra = {});

}  // namespace mm
