// What a session and a model make of the problem: its rows and its unknowns.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/units.h"
#include "estimation/problem.h"

namespace mm {
namespace {

/// The temperature whose absence alone keeps a model from a value; "an input" where it is none.
std::string missingTemperature(const Model& model, const State& at, const std::vector<double>& parameters,
                               Model::Workspace& work) {
  const std::vector<std::string>& sensors = model.domain().sensors;
  State known = at;
  for (double& t : known.temperature)
    if (!std::isfinite(t)) t = kReferenceTemperature;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    if (std::isfinite(at.temperature[s])) continue;
    State without = known;
    without.temperature[s] = at.temperature[s];
    model.corrected(without, parameters.data(), work);
    for (const double error : work.errors)
      if (!std::isfinite(error)) return "temperature '" + sensors[s] + "'";
  }
  return "an input";
}

const char* const kAxisNames[] = {"x", "y", "z"};

// Typical sizes, in which a fit counts, and largest plausible ones of what belongs to the artifact: an
// artifact that was set down by hand, a ball whose radius is known but for its calibration.
constexpr double kTurnScale = 1e-3, kTurnBound = 0.5;       // rad
constexpr double kPlaceScale = 1e-4, kPlaceBound = 1.0;     // m
constexpr double kRadiusScale = 1e-6, kRadiusBound = 1e-2;  // m
constexpr double kZeroBound = 1.0;                          // m or rad: of an instrument
constexpr int kMostUnused = 5;  // one observation in so many may lack an input of the model

}  // namespace

Problem::Problem(const Session& session, Model model, Datum datum)
    : session_(&session), model_(std::move(model)), datum_(datum) {
  if (session.observations.empty())
    throw InputError(session.source +
                     ": the session has no observations; record contacts or references first");
  start_ = geometricStart(session);
  states_ = std::make_shared<SessionStates>(session, model_.domain(), Temperatures::kSmoothed);
  states_->aim(start_);
  addRows();
  addUnknowns();

  findUsable();
}

void Problem::findUsable() {
  const int count = static_cast<int>(session_->observations.size());
  usable_.assign(count, 1);
  Model::Workspace work;
  std::vector<double> r(kMaxRows);
  const Eigen::VectorXd x = start();
  for (int o = 0; o < count; ++o) {
    const int n = residualsOf(o, x, r.data(), nullptr, work);
    for (int i = 0; i < n; ++i)
      if (!std::isfinite(r[i])) usable_[o] = 0;
    if (!usable_[o]) leftOut_.push_back(o);
  }
  if (kMostUnused * leftOut_.size() <= usable_.size()) return;
  const int o = leftOut_.front();  // which effect lacks its input?
  const std::string where =
      session_->source + ": " +
      session_->rowText(session_->observations[o].row, session_->observations[o].recording) + " and " +
      std::to_string(leftOut_.size() - 1) + " more: ";
  for (const EffectPtr& e : model_.effects()) {
    Model one(model_.machine(), model_.domain(), {e});
    std::vector<double> p;
    for (const Parameter& q : e->parameters()) p.push_back(q.start);
    one.corrected(state(o), p.data(), work);
    for (double error : work.errors)
      if (!std::isfinite(error))
        throw InputError(where + "effect " + e->spec().yaml() + " lacks " +
                         missingTemperature(one, state(o), p, work) + " there (" + e->shownBy() +
                         "); log it, or leave the effect out");
  }
  throw InputError(where + "the value of the model is not a number");
}

void Problem::addRows() {
  const auto& observations = session_->observations;
  for (std::size_t o = 0; o < observations.size(); ++o) {
    const Observation& at = observations[o];
    firstRow_.push_back(static_cast<int>(rows_.size()));
    ResidualRow row;
    row.observation = static_cast<int>(o);
    switch (at.kind) {
      case ObservationKind::kContact:
      case ObservationKind::kLength: {
        const int count = session_->outward(at) != 0 ? 1 : 3;
        for (row.component = 0; row.component < count; ++row.component) rows_.push_back(row);
        break;
      }
      case ObservationKind::kPosition:
        for (row.component = 0; row.component < 3; ++row.component)
          if (std::isfinite(at.reference[row.component])) rows_.push_back(row);
        break;
      case ObservationKind::kDeviation:
        for (row.component = 0; row.component < static_cast<int>(at.deviation.size()); ++row.component)
          if (std::isfinite(at.deviation[row.component])) {
            ResidualRow r = row;
            r.angular = model_.machine().joints()[row.component].kind == JointKind::kRotary;
            if (row.component < static_cast<int>(at.deviationStd.size()) &&
                std::isfinite(at.deviationStd[row.component]))
              r.statedSigma = at.deviationStd[row.component];
            rows_.push_back(r);
          }
        break;
    }
  }
  firstRow_.push_back(static_cast<int>(rows_.size()));
  if (rows_.empty())
    throw InputError(session_->source + ": no observation has a measured value; nothing to fit");
}

void Problem::add(Unknown u) {
  if (u.priorStd > 0.0) priors_.push_back(static_cast<int>(unknowns_.size()));
  const bool next = !groups_.empty() && groups_.back().kind == u.kind && groups_.back().owner == u.owner;
  if (next)
    ++groups_.back().count;
  else
    groups_.push_back({u.kind, u.owner, static_cast<int>(unknowns_.size()), 1});
  unknowns_.push_back(std::move(u));
}

/// Free features that nothing else tells of stand wherever a placement is: its pose is then a part of them.
/// Where all features are free, the first placement is the frame in which they are told.
void Problem::addPoses() {
  const auto& features = session_->artifact.features;
  const auto placements = static_cast<std::size_t>(session_->placementCount());
  std::vector<std::vector<char>> seenIn(placements, std::vector<char>(features.size(), 0));
  std::vector<char> known(placements, 0), shares(placements, 0);  // with another placement
  std::vector<int> places(features.size(), 0);                    // in so many placements
  for (const Observation& o : session_->observations) {
    const auto p = static_cast<std::size_t>(o.placement);
    if (o.kind == ObservationKind::kPosition) known[p] = 1;
    if (o.feature < 0) continue;
    const auto f = static_cast<std::size_t>(o.feature);
    if (features[f].known) known[p] = 1;
    if (!seenIn[p][f]) ++places[f];
    seenIn[p][f] = 1;
  }
  for (std::size_t p = 0; p < placements; ++p)
    for (std::size_t f = 0; f < features.size(); ++f) shares[p] |= seenIn[p][f] && places[f] > 1;
  const bool anyKnown = std::find(known.begin(), known.end(), 1) != known.end();
  poseOffset_.assign(placements, -1);
  for (std::size_t p = 0; p < placements; ++p) {
    const bool told = known[p] || (shares[p] && (anyKnown || p > 0));
    if (!session_->poseFree(static_cast<int>(p)) || !told) continue;
    poseOffset_[p] = unknownCount();
    const std::string name = session_->placements.empty() ? "" : session_->placements[p];
    for (int k = 0; k < 6; ++k) {
      const bool rotation = k < 3;
      add({UnknownKind::kPose, static_cast<int>(p), k,
           std::string(rotation ? "rotation " : "position ") + kAxisNames[k % 3] + " of the artifact" +
               (name.empty() ? "" : " in placement " + name),
           rotation ? "arcsec" : "um", rotation ? 1.0 / kArcsecond : 1.0 / kMicrometre,
           rotation ? kTurnScale : kPlaceScale, rotation ? kTurnBound : kPlaceBound, 0.0, 0.0});
    }
  }
}

/// Offsets that the artifact's file does not state, of styli that touched something.
void Problem::addStyli() {
  const auto& styli = session_->artifact.styli;
  stylusOffset_.assign(std::max<std::size_t>(1, styli.size()), -1);
  std::vector<char> used(stylusOffset_.size(), 0);
  for (const Observation& o : session_->observations)
    if (o.feature >= 0) used[static_cast<std::size_t>(o.stylus)] = 1;
  for (std::size_t s = 0; s < styli.size(); ++s) {
    if (!used[s] || styli[s].known) continue;
    stylusOffset_[s] = unknownCount();
    for (int k = 0; k < 3; ++k)
      add({UnknownKind::kStylus, static_cast<int>(s), k,
           std::string("offset ") + kAxisNames[k] + " of stylus " + styli[s].name, "um", 1.0 / kMicrometre,
           kPlaceScale, kPlaceBound, 0.0, 0.0});
  }
}

void Problem::addUnknowns() {
  for (int e = 0; e < static_cast<int>(model_.effects().size()); ++e) {
    const Effect& effect = *model_.effects()[e];
    for (int k = 0; k < effect.parameterCount(); ++k) {
      const Parameter& p = effect.parameters()[k];
      add({UnknownKind::kEffect, e, k, p.name, p.unit, p.toUnit, p.scale, p.bound, p.start, p.priorStd,
           p.minimum, p.maximum});
    }
    for (const int k : effect.nature().unitVectors)
      unitVectors_.push_back({model_.offset(e) + k, effect.nature().unitVectorPenalty});
  }
  const auto& features = session_->artifact.features;
  std::vector<char> touched(features.size(), 0);
  for (const Observation& o : session_->observations)
    if (o.feature >= 0) touched[o.feature] = 1;
  addPoses();
  addStyli();
  featureOffset_.assign(features.size(), -1);
  radiusOffset_.assign(features.size(), -1);
  for (std::size_t f = 0; f < features.size(); ++f) {
    if (!touched[f]) continue;
    if (!features[f].known || features[f].positionStd > 0.0) {
      featureOffset_[f] = unknownCount();
      for (int k = 0; k < 3; ++k)
        add({UnknownKind::kFeature, static_cast<int>(f), k, features[f].name + " " + kAxisNames[k], "um",
             1.0 / kMicrometre, kPlaceScale, kPlaceBound, 0.0,
             features[f].known ? features[f].positionStd : 0.0});
    }
    if (features[f].kind == FeatureKind::kBall && features[f].radiusStd > 0.0) {
      radiusOffset_[f] = unknownCount();
      add({UnknownKind::kRadius, static_cast<int>(f), 0, "radius of " + features[f].name, "um",
           1.0 / kMicrometre, kRadiusScale, kRadiusBound, 0.0, features[f].radiusStd});
    }
  }
  // one zero a setup and measured component; rows without a setup share one, too, in each session
  const int named = static_cast<int>(session_->setups.size());
  for (const Observation& o : session_->observations)
    setupOf_.push_back(o.setup >= 0                                                      ? o.setup
                       : o.kind == ObservationKind::kDeviation && datum_ == Datum::kFree ? named + o.recording
                                                                                         : -1);
  const int width = std::max(3, model_.machine().jointCount());
  setupOffset_.assign((named + session_->recordingCount()) * width, -1);
  for (const ResidualRow& row : rows_) {
    const int setup = setupOf_[row.observation];
    if (session_->observations[row.observation].kind == ObservationKind::kContact || setup < 0) continue;
    int& offset = setupOffset_[setup * width + row.component];
    if (offset >= 0) continue;
    offset = unknownCount();
    const double unit = row.angular ? kArcsecond : kMicrometre;
    add({UnknownKind::kSetup, setup, row.component,
         (setup < named ? "zero of setup " + session_->setups[setup] : "zero of the instrument along ") +
             (setup < named ? "" : model_.machine().joints()[row.component].name) +
             (setup < named || session_->recordings.empty()
                  ? ""
                  : " in " + session_->recordings[static_cast<std::size_t>(setup - named)].source),
         row.angular ? "arcsec" : "um", 1.0 / unit, unit, kZeroBound, 0.0, 0.0});
  }
}

}  // namespace mm
