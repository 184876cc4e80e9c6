#pragma once
#include "diagnosis/diagnose.h"

namespace mm {

/// The verdict, from everything else. `explained` asks for a noise that agrees with the repeatability:
/// stated, within a factor of 1.3; from repeats, within what their degrees of freedom let chance do once in a
/// hundred.
void decide(Diagnosis& out);
/// Whether another cause may act in its place: one that does not do the same wherever the session's kind of
/// measurement reaches.
bool hasRivals(const CandidateResult& missing);
/// What an axis has from position to position, or from run to run; null: nothing.
const ArtifactScatter* ofAnAxis(const Diagnosis& diagnosis);
/// Centres or radii of the balls that scatter beyond the repeatability, where that is known: null where none
/// do.
const ArtifactScatter* beyondTheFile(const Diagnosis& diagnosis);
/// A direction along which the errors scatter from one measurement to the next by more than the
/// repeatability, where that is known: null where none does.
const DriftResult* beyondTheRepeatability(const Diagnosis& diagnosis);

}  // namespace mm
