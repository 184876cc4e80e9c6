#pragma once
#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "posterior/problem.h"

namespace mm {

/// A made-up problem, small enough to sum over all of its states: three causes, two shapes the last.
struct SmallProblem {
  static constexpr int kRows = 40;
  PosteriorProblem problem;

  explicit SmallProblem(unsigned seed, double acts = 0.6, int column = 0) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    NoiseRows& rows = problem.rows;
    rows.factors = RowMatrix::Ones(kRows, 1);
    rows.target.resize(kRows);
    rows.base = RowMatrix::Constant(kRows, 1, 1.0 / std::sqrt(kRows));
    problem.columns.resize(kRows, 7);
    for (int i = 0; i < kRows; ++i) {
      rows.time.push_back(3.0 * i);
      rows.target[i] = normal(random);
      for (int k = 0; k < 7; ++k) problem.columns(i, k) = normal(random);
    }
    problem.columns.col(6) =
        0.9 * problem.columns.col(0) + 0.4 * problem.columns.col(6);  // two that resemble
    rows.target += acts * problem.columns.col(column);
    problem.scatter.push_back({RowMatrix::Random(kRows, 2), 0.0, 0.0, false});
    const int counts[] = {2, 1, 3, 1}, causes[] = {0, 1, 2, 2};
    int first = 0;
    for (int s = 0; s < 4; ++s) {
      CauseShape shape;
      shape.cause = causes[s];
      shape.first = first;
      shape.count = counts[s];
      shape.logPrior = Sizes::Constant(-std::log(double(kSizes) * (causes[s] == 2 ? 2 : 1)));
      first += counts[s];
      problem.shapes.push_back(shape);
    }
    problem.causes = {{std::log(0.3), 0, 1}, {std::log(0.3), 1, 2}, {std::log(0.2), 2, 4}};
    problem.statedFreedoms = 4.0;
  }

  NoiseState plain() const {
    NoiseState s;
    s.scatter = {0.0};
    s.variance = Eigen::VectorXd::Constant(kRows, 1.0);
    return s;
  }
  NoiseState walking() const {
    NoiseState s = plain();
    s.drift = {{0, 0.5, 40.0}};
    s.scatter = {0.4};
    return s;
  }

  /// Log density by dense matrices.
  double brute(const NoiseState& noise, const ActingSet& set) const {
    const NoiseRows& rows = problem.rows;
    Eigen::MatrixXd v = noise.variance.asDiagonal();
    for (const DriftTerm& t : noise.drift)
      for (int i = 0; i < kRows; ++i)
        for (int j = 0; j < kRows; ++j)
          v(i, j) += t.ratio * t.ratio * std::exp(-std::abs(rows.time[i] - rows.time[j]) / t.tau);
    const RowMatrix& z = problem.scatter[0].columns;
    v += noise.scatter[0] * noise.scatter[0] * z * z.transpose();
    double prior = noise.logPrior(problem);
    for (const Acting& a : set) {
      const CauseShape& s = problem.shapes[a.shape];
      const auto h = problem.columns.middleCols(s.first, s.count);
      v += sizeGrid()[a.size] * sizeGrid()[a.size] * h * h.transpose();
      prior += problem.causes[s.cause].logPriorOdds + s.logPrior[a.size];
    }
    const Eigen::MatrixXd inverse = v.inverse();
    const double information = (rows.base.transpose() * inverse * rows.base)(0, 0);
    const Eigen::VectorXd by = inverse * rows.base;
    const double rest =
        rows.target.dot(inverse * rows.target) - std::pow(by.dot(rows.target), 2) / information;
    const double freedoms = kRows - 1 + problem.statedFreedoms;
    return prior - 0.5 * std::log(v.determinant()) - 0.5 * std::log(information) -
           0.5 * freedoms * std::log(rest + problem.statedFreedoms);
  }
};

}  // namespace mm
