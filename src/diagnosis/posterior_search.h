#pragma once
#include "diagnosis/diagnose.h"
#include "diagnosis/search.h"
#include "posterior/slots.h"

namespace mm {

/// What the posterior over sets of causes says of a session.
struct PosteriorAnswer {
  PosteriorSample sample;
  std::vector<Slot> slots;     // likeliest first; causes are groups of the questions
  std::vector<int> likeliest;  // a group: its shape of most probability, -1: none was visited
  Explanation found;           // the leaders of the named slots, refitted
};

/// Draws from the posterior. @param variance of the white noise, a data row. @param statedFreedoms how many
/// degrees of freedom the stated noise is worth.
PosteriorAnswer explainByPosterior(const Questions& questions, const Eigen::VectorXd& variance,
                                   double statedFreedoms, std::uint64_t seed);
/// Degrees of freedom that the repeatability of a fit is worth.
double statedFreedomsOf(const CalibrationResult& fitted);

/// Odds, rivals and what may act beside drift, as the sample has them.
void takeOdds(const Questions& questions, const PosteriorAnswer& answer, Diagnosis& out);

}  // namespace mm
