#include "base/distributions.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace mm {
namespace {

using boost::math::chi_squared, boost::math::fisher_f, boost::math::normal, boost::math::students_t;

}  // namespace

double normalBelow(double value) { return cdf(normal(), value); }

double normalQuantile(double probability) { return quantile(normal(), probability); }

double studentTail(double t, double freedoms) { return cdf(complement(students_t(freedoms), t)); }

double studentLimit(double chance, double freedoms) {
  return quantile(complement(students_t(freedoms), chance));
}

double fisherTail(double f, double freedomsAbove, double freedomsBelow) {
  return cdf(complement(fisher_f(freedomsAbove, freedomsBelow), f));
}

double fisherLimit(double chance, double freedomsAbove, double freedomsBelow) {
  return quantile(complement(fisher_f(freedomsAbove, freedomsBelow), chance));
}

double chiSquaredTail(double value, double freedoms) { return cdf(complement(chi_squared(freedoms), value)); }

double chiSquaredQuantile(double probability, double freedoms) {
  return quantile(chi_squared(freedoms), probability);
}

}  // namespace mm
