#pragma once
#include "estimation/genetic_sphere_fitness.h"
#include "mmt_contacts.h"

namespace mm_test {

/// The 21 constants of the 18 genes; those fixed by convention are zero.
inline void scatterGenes(const double* genes, double* constants) {
  for (std::size_t k = 0; k < MmtContacts::kConstants; ++k)
    constants[k] = MmtContacts::fixed(k) ? 0.0 : *genes++;
}

/// The fitness of the contacts with the centres unknown; `ranges`: each constant within `size` over the
/// volume.
inline mm::SphereFitness mmtFitness(const MmtContacts& data, double size, mm::CentreRule rule,
                                    mm::GeneticRanges& ranges) {
  mm::SphereContacts contacts;
  std::vector<std::size_t> constants;  // of each gene
  for (std::size_t k = 0; k < MmtContacts::kConstants; ++k) {
    if (MmtContacts::fixed(k)) continue;
    contacts.displacement[k / 7].push_back({constants.size(), {}});
    constants.push_back(k);
    ranges.low.push_back(-MmtContacts::half(k, size));
    ranges.high.push_back(MmtContacts::half(k, size));
  }
  for (const Eigen::Vector3d& reading : data.readings) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      contacts.position[axis].push_back(reading[static_cast<Eigen::Index>(axis)]);
      const auto factors = MmtContacts::factors(static_cast<int>(axis), reading);
      for (mm::SparseColumn& column : contacts.displacement[axis])
        column.values.push_back(factors[constants[column.coefficient] % 7]);
    }
    contacts.distance.push_back(MmtContacts::kDistance);
  }
  contacts.ball = data.ball;
  std::vector<mm::SphereBall> balls;
  for (const Eigen::Vector3d& centre : data.nominalCentres) balls.push_back({centre, true});
  return {contacts, balls, {}, constants.size(), rule};
}

}  // namespace mm_test
