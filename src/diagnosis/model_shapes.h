#pragma once
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"
#include "diagnosis/search.h"

namespace mm {

/// What an effect of the model has beside the shape that it has in it: the remainder of a screw's wave, a
/// play that is larger in the middle. It is no new cause.
struct ModelShape {
  int effect = 0;      // of the model
  std::string along;   // the joint along which its size changes; empty: another shape
  EffectSpec follows;  // would be added for it; of no type where nothing can
  RandomBlock block;   // its columns, of known size
};

/// Of every effect that is not zero.
std::vector<ModelShape> shapesOfTheModel(const ResidualSpace& space);

/// Effects of the model of which such a shape is seen: likelier than none by the evidence, as the causes are,
/// and at least half of the noise. Causes that do as well are told beside it, each by its probability.
/// @param causes that may act. @param noise, least m or rad: of the session, and from which on it is told.
std::vector<Variation> variationsOf(const Search& search, const Explanation& found,
                                    const std::vector<CandidateResult>& causes, double noise, double least);

}  // namespace mm
