#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace mm {

/// How the information between temperatures and a displacement is estimated.
enum class InformationEstimator {
  kKsg,         // Kraskov, Stoegbauer, Grassberger, Phys. Rev. E 69 (2004) 066138, eq. (8)
  kHistogram,   // SENSORS (1) and (2)
  kCorrelation  // -1/2 log(1 - R^2), R the (multiple) correlation: exact for jointly normal quantities
};

/// What is subtracted from the histogram's estimate, which is too large where there are few samples a cell.
enum class BiasCorrection {
  kNone,
  kMillerMadow,   // by the number of occupied cells
  kShuffle,       // mean over displacements in random order
  kCircularShift  // mean over displacements shifted in time, which keeps their slow drift
};

struct InformationSettings {
  InformationEstimator estimator = InformationEstimator::kKsg;
  int neighbours = 5;         // KSG: k
  int temperatureBins = 30;   // histogram: N of the paper
  int displacementBins = 30;  // histogram: M of the paper
  bool commonRange =
      true;  // histogram: one range of temperature for all sensors, as printed; else one a sensor
  BiasCorrection correction = BiasCorrection::kNone;
  int surrogates = 20;  // of the shuffle and circular shift corrections
  std::uint64_t seed =
      1;  // of the surrogates, and of the tie-breaking of KSG (1e-10 of a standard deviation)
};

/// Mutual information in nat between a displacement and any subset of the sensors of one series.
/// Const after construction: joint() may be called from several threads.
/// Neighbours are found by comparing all samples: KSG also counts those within the radius in each projection,
/// for which every distance is needed, and that of the displacement is kept for all subsets of the sensors; a
/// tree of neighbours would save neither.
class SensorInformation {
 public:
  /// `temperatures`: samples x sensors; `displacement`: samples; any units.
  /// Throws InputError for unequal lengths, values that are not finite, too few samples or settings out of
  /// range.
  SensorInformation(const Eigen::MatrixXd& temperatures, const Eigen::VectorXd& displacement,
                    const InformationSettings& settings);

  int samples() const { return static_cast<int>(temperatures_.rows()); }  ///< rows
  int sensors() const { return static_cast<int>(temperatures_.cols()); }  ///< columns
  /// I(Y; T_1 ... T_m) in nat for the sensors of these indices; 0 for none.
  double joint(const std::vector<int>& sensors) const;
  /// Absolute correlation of one sensor with the displacement; 0 when one of them does not vary.
  double correlation(int sensor) const;

 private:
  double ksg(const std::vector<int>& sensors) const;
  double histogram(const std::vector<int>& sensors) const;
  double gaussian(const std::vector<int>& sensors) const;

  InformationSettings settings_;
  Eigen::MatrixXd temperatures_;                    // standardised
  Eigen::VectorXd displacement_;                    // standardised
  Eigen::MatrixXd jittered_;                        // standardised, ties broken
  Eigen::MatrixXd displacementDistance_;            // KSG: between all samples
  Eigen::VectorXd digamma_;                         // of 1, 2, ... samples
  Eigen::MatrixXi bins_;                            // histogram: samples x sensors
  std::vector<std::vector<int>> displacementBins_;  // histogram: as measured, then the surrogates
};

}  // namespace mm
