#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimation/drift.h"

namespace mm {

/// The usual time from one row to the next, s; 0 where all are of one time.
double medianSpacing(const std::vector<double>& time);

/// Rows of a linearised session as the noise model sees them: whitened by the stated noise, ascending in
/// time.
struct NoiseRows {
  std::vector<double> time;  // s, a data row
  RowMatrix factors;         // data rows x directions of drift
  Eigen::VectorXd target;    // data rows, then priors: what is to be explained
  RowMatrix base;            // orthonormal columns of what is free without a prior; data rows, then priors
  /// Drift is zero at the first row: constants belong to other unknowns (radius, zero, displacement). Else it
  /// is at rest about an unknown mean.
  bool sinceFirst = false;
  int rows() const { return static_cast<int>(time.size()); }      ///< data rows
  int length() const { return static_cast<int>(target.size()); }  ///< data rows and priors
};

/// Columns whose coefficients are drawn from a normal distribution: the scatter of the balls, the shapes of a
/// cause.
struct RandomBlock {
  RowMatrix columns;   // length x k, each coefficient of standard deviation `ratio`
  double ratio = 0.0;  // in units of the white noise; 0: not there
  double price = 0.0;  // log evidence that it must earn to be there; 0: its ratio may go down to nothing
  bool fixed = false;  // the ratio is known
  double nats = 1.5;   // by which its being there is less likely than its absence, before any data
};

/// On products of orthonormal columns: keeps a direction that a part of the rows does not see from being
/// divided by rounding.
constexpr double kRidge = 1e-9;

/// What takes the memory of the noise out of rows.
inline TimeWhitener whitenerOf(const NoiseRows& rows, const Eigen::VectorXd& variance,
                               const std::vector<DriftTerm>& drift) {
  return {rows.time, rows.factors, variance, drift, rows.sinceFirst};
}

/// White noise, drift and blocks: everything that scatters. Ratios are in units of the white noise.
struct NoiseModel {
  std::vector<DriftTerm> drift;
  Eigen::VectorXd variance;  // a data row: of its white noise, 1 on average; smaller counts more
};

/// What fitting the variances by restricted maximum likelihood (REML, Patterson & Thompson 1971) found.
struct NoiseFitResult {
  NoiseModel noise;
  std::vector<double> ratios;  // of the blocks
  double logEvidence =
      0.0;  // restricted, with the scale of the noise integrated out, less the prices of what is there
  double white = 1.0;     // standard deviation of the white noise, in units of the stated one
  double whiteStd = 0.0;  // its standard uncertainty, drift and blocks as they are
  double freedoms = 1.0;  // rows less the columns that are free
};

struct NoiseFitOptions {
  /// Log evidence that one drift term must earn: each may be one of about twenty (direction and time
  /// constant).
  double driftPrice = 3.0;
  /// That a smooth one must earn: what follows a smooth course is as particular as a cause that has a name,
  /// and must be as likely beside it (ln 100 causes, and 100 to 1).
  double smoothPrice = 9.2;
  bool addDrift = true;   // look for further terms
  bool dropDrift = true;  // try without those that are there
  bool refine = true;     // sizes and time constants of those that are there
};

/// Fits the variances of drift and blocks. Greedy in the terms, by coordinates in sizes and time constants.
class NoiseFit {
 public:
  /// @param rows must outlive the fit.
  NoiseFit(const NoiseRows& rows, std::vector<RandomBlock> blocks);

  NoiseFitResult run(const NoiseModel& start, const NoiseFitOptions& options) const;  ///< REML from `start`
  /// The evidence as it is, nothing fitted but the ratios of blocks that are not fixed.
  NoiseFitResult at(const NoiseModel& noise, const NoiseFitOptions& options) const;
  /// Standard uncertainty of the white noise that was found, in units of the stated one. Drift that lasts but
  /// a few rows looks much like white noise: what else the evidence allows of the shortest counts.
  double whiteStdOf(const NoiseFitResult& found, const NoiseFitOptions& options) const;
  /// Time constants that are asked, s: from the spacing of the rows to the length of the session.
  const std::vector<double>& timeConstants() const { return timeConstants_; }

 private:
  struct Gram;  // of the columns that are there, whitened in time
  /// @param everything blocks of ratio 0, too.
  Gram gramOf(const NoiseModel& noise, const std::vector<double>& ratios, bool everything) const;
  /// Fits the ratios; @return the evidence. @param freedoms, rest: of the scale.
  double value(const Gram& gram, const std::vector<double>& ratios, double* rest) const;
  double fitRatios(const Gram& gram, std::vector<double>& ratios) const;
  double prices(const NoiseModel& noise, const std::vector<double>& ratios,
                const NoiseFitOptions& options) const;
  /// Another noise in the place of the best where it is worth more. @return whether it is.
  bool take(NoiseModel noise, const NoiseFitOptions& options, NoiseFitResult& best) const;
  NoiseFitResult fittedRatios(const NoiseModel& noise, const std::vector<double>& from,
                              const NoiseFitOptions& options) const;
  // What a round of `run` consists of: each changes `best` where that makes it worth more.
  void dropTerms(const NoiseFitOptions& options, NoiseFitResult& best) const;
  void addTerm(const NoiseFitOptions& options, NoiseFitResult& best) const;  // the best of all further ones
  Eigen::VectorXd withoutBlocks(const NoiseFitResult& best) const;
  double shortestOf(int direction) const;
  void refineTerms(int round, const NoiseFitOptions& options, NoiseFitResult& best) const;

  const NoiseRows& rows_;
  std::vector<RandomBlock> blocks_;
  int base_ = 0;
  std::vector<double> timeConstants_;
};

/// At most `most` of so many rows, in stretches of a length spread over the session: neighbours for what
/// lasts from row to row, and the whole session for what is slow.
std::vector<int> stretches(int rows, int most, int length);

/// The fit of a session: one of more rows than `most` is fitted to stretches of its rows, spread over its
/// length.
NoiseFitResult fitNoise(const NoiseRows& rows, std::vector<RandomBlock> blocks, const NoiseModel& start,
                        const NoiseFitOptions& options, int most);

}  // namespace mm
