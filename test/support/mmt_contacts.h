#pragma once
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

namespace mm_test {

/// The experiment of MMT: a ball of R + r = 7.937 mm in 70 positions (14 spindle angles, five distances along
/// Y), 233 contacts each, within 75 deg of -Y. A machine of 21 constants, three of them zero by convention;
/// metres throughout.
struct MmtContacts {
  static constexpr double kDistance = 7.937e-3, kLead = 1e-3, kReach = 20e-3;
  static constexpr std::size_t kBalls = 70, kContactsPerBall = 233, kConstants = 21;

  std::vector<Eigen::Vector3d> readings;
  std::vector<std::size_t> ball;
  std::vector<Eigen::Vector3d> nominalCentres, trueCentres;
  std::array<double, kConstants>
      truth{};  // of axis i, from 7 i: C1, S, K, C of the two others, alpha of the two others

  /// Factors of the seven constants of an axis at a reading: MMT (13) with n = 2, a = 1, argument 2 pi X /
  /// Pr.
  static std::array<double, 7> factors(int axis, const Eigen::Vector3d& q) {
    const int b = axis == 0 ? 1 : 0, c = axis == 2 ? 1 : 2;
    const double angle = 2.0 * M_PI * q[axis] / kLead;
    return {q[axis], q[axis] * std::sin(angle), q[axis] * std::cos(angle), q[b] * q[b], q[c] * q[c], -q[b],
            -q[c]};
  }
  /// alpha_xy, alpha_xz and alpha_yz are zero by convention.
  static bool fixed(std::size_t constant) { return constant == 12 || constant == 19 || constant == 20; }
  /// Half the range of a constant whose effect over the volume is `size`.
  static double half(std::size_t constant, double size) {
    const std::size_t kind = constant % 7;
    return kind == 3 || kind == 4 ? size / (kReach * kReach) : size / kReach;
  }
  Eigen::Vector3d deviation(const Eigen::Vector3d& q, const double* constants) const {
    Eigen::Vector3d d = Eigen::Vector3d::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      const auto factor = factors(axis, q);
      for (std::size_t k = 0; k < 7; ++k)
        d[axis] += constants[7 * static_cast<std::size_t>(axis) + k] * factor[k];
    }
    return d;
  }

  /// `size`: largest effect of a constant over the volume; `noise`: of a contact, along its normal.
  MmtContacts(unsigned seed, double size, double noise) {
    std::mt19937_64 generator(seed);
    std::uniform_real_distribution<double> even(-1.0, 1.0);
    std::normal_distribution<double> normal;
    for (std::size_t k = 0; k < kConstants; ++k)
      truth[k] = fixed(k) ? 0.0 : (k % 7 == 1 || k % 7 == 2 ? 0.3 : 1.0) * half(k, size) * even(generator);
    for (std::size_t b = 0; b < kBalls; ++b) {
      const double angle = 2.0 * M_PI * static_cast<double>(b % 14) / 14.0;
      const Eigen::Vector3d nominal(6e-3 * std::cos(angle), 11e-3 + 2e-3 * static_cast<double>(b / 14),
                                    6e-3 * std::sin(angle));
      nominalCentres.push_back(nominal);
      trueCentres.push_back(nominal +
                            50e-6 * Eigen::Vector3d(even(generator), even(generator), even(generator)));
      for (std::size_t i = 0; i < kContactsPerBall; ++i) {
        const double part = (static_cast<double>(i) + 0.5) / static_cast<double>(kContactsPerBall);
        const double along = 1.0 - part * (1.0 - std::cos(75.0 * M_PI / 180.0)),
                     across = std::sqrt(1.0 - along * along);
        const double turn = 2.39996322972865 * static_cast<double>(i);
        const Eigen::Vector3d n(across * std::cos(turn), -along, across * std::sin(turn));
        const Eigen::Vector3d tip = trueCentres[b] + (kDistance + noise * normal(generator)) * n;
        Eigen::Vector3d reading = tip;  // true = reading + deviation(reading)
        for (int k = 0; k < 50; ++k) reading = tip - deviation(reading, truth.data());
        readings.push_back(reading);
        ball.push_back(b);
      }
    }
  }
};

}  // namespace mm_test
