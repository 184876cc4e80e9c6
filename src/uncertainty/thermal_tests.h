#pragma once
#include <string>
#include <vector>

#include "session/session.h"
#include "uncertainty/drift_figures.h"
#include "uncertainty/residual_of.h"

namespace mm {

/// The tests of ISO 230-3: an idle machine in its surroundings (environmental temperature variation error,
/// ETVE), a spindle that turns, a linear or a rotary axis that moves to and fro.
enum class ThermalTestKind { kEnvironment, kSpindle, kLinearAxis, kRotaryAxis };

/// One displacement at one place against time, from the first reading.
struct ThermalCourse {
  std::string name;          // "X", "-18 mm", "X at -18 mm", "between -18 mm and 18 mm"
  std::string direction;     // x, y, z of the workpiece, or the joint whose deviation it is
  double at = kNotMeasured;  // mm or deg, of the joint that moves between the places; NaN: there is one place
  bool between = false;      // the difference of two places: how the length between them grows
  DriftCurve measured;
  std::vector<double> left;  // what a model leaves, at the same times, um (arcsec); empty: none is asked
};

/// What one session shows of one such test. Time counts from the session's start, in h.
struct ThermalTest {
  ThermalTestKind kind = ThermalTestKind::kEnvironment;
  std::string joint;     // that moves; empty: none
  std::string spindle;   // the covariate that says how fast it turns; empty: none
  std::string setup;     // of the instrument; empty: none
  bool angular = false;  // courses are in arcsec
  bool rotary = false;   // places are in deg
  int readings = 0, places = 0;
  double from = 0.0, to = 0.0;  // first and last reading
  HeatedTime heated;            // while the spindle turned, or up to the largest displacement
  std::vector<ThermalCourse> courses;
};

/// The tests of ISO 230-3 in a session: positions or deviations that an independent instrument measured at
/// the same places at least five times each, for an hour or while a temperature changed by 0.5 K. It is
/// told from the rows alone what is tested:
/// - one place: the spindle where a covariate in rpm was above 0, else a rotary joint where it is the only
///   one that travelled (or has the setup's name), else the surroundings;
/// - several places along one joint, nothing else moving: that joint; of more than three places the ends and
///   the middle are kept. Places by the hundred without a temperature are a positioning test (ISO 230-2).
/// Positions are told in the instrument's axes, which are taken for those of the workpiece.
/// @param left may be empty.
std::vector<ThermalTest> thermalTests(const Session& session, const ResidualOf& left = {});

/// "ISO 230-3, linear axis x: 180 readings at 3 positions over 5.0 h"; of five positions or more, which are a
/// positioning test that lasted, "ISO 230-2, linear axis x: displacement against time as in ISO 230-3 from
/// …".
std::string inWords(const ThermalTest& test);

}  // namespace mm
