#pragma once
#include <string>

#include "mmt_contacts.h"
#include "model/model_spec.h"
#include "model/observed_domain.h"
#include "session/session.h"

namespace mm_test {

/// The contacts as a session of three_axis: 70 free balls, noise declared. @param noise m.
inline mm::Session mmtSession(const MmtContacts& data, double noise) {
  mm::Session session(mm::Machine::load("three_axis"));
  session.source = "MMT";
  session.artifact.tipRadius = 0.5 * MmtContacts::kDistance;
  session.artifact.repeatability = noise;
  for (std::size_t b = 0; b < MmtContacts::kBalls; ++b) {
    mm::Feature ball;
    ball.name = "p" + std::to_string(b);
    ball.position = data.nominalCentres[b];
    ball.known = false;
    ball.radius = 0.5 * MmtContacts::kDistance;
    session.artifact.features.push_back(ball);
  }
  for (std::size_t i = 0; i < data.readings.size(); ++i) {
    mm::Observation o;
    o.time = static_cast<double>(i);
    o.row = static_cast<std::int64_t>(i) + 1;
    o.position = {data.readings[i].x(), data.readings[i].y(), data.readings[i].z()};
    o.velocity.assign(3, mm::kNotMeasured);
    o.feature = static_cast<int>(data.ball[i]);
    session.observations.push_back(o);
  }
  session.prepare();
  return session;
}

/// The model of MMT (13) over the session's domain: 21 constants.
inline mm::Model mmtModel(const mm::Session& session) {
  std::vector<mm::EffectSpec> effects;
  for (const char* axis : {"x", "y", "z"})
    effects.push_back(
        mm::EffectSpec("mmt_deviation").set("axis", axis).set("lead_mm", 1e3 * MmtContacts::kLead));
  return {session.machine, mm::observedDomain(session), effects};
}

}  // namespace mm_test
