#include "session/joined.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "base/error.h"
#include "base/format.h"
#include "base/numbered_names.h"
#include "base/units.h"
#include "machine/machine_fit.h"
#include "session/session_hash.h"

namespace mm {
namespace {

constexpr double kDay = 86400.0;
/// What is imported without a date counts its times from 2001-09-09 (kImportEpoch), and so does what is
/// simulated. Nothing was recorded in the years after it.
constexpr double kDated = 1.2e9;  // 2008-01-10

std::string nameOf(const Session& session) {
  return std::filesystem::path(session.source).filename().string();
}

double lastTime(const Session& session) { return session.observations.back().time; }

[[noreturn]] void refuse(const Session& session, const Session& first, const std::string& what,
                         const std::string& remedy) {
  throw InputError(session.source + ": " + what + " " + first.source + "; " + remedy);
}

/// How a feature or stylus of the same name differs; empty: it does not.
std::string differenceOf(const Feature& a, const Feature& b) {
  if (a.kind != b.kind) return "is a ball in one and a point in the other";
  if (a.known != b.known) return "is known in one and free in the other";
  if (a.known && a.position != b.position)
    return format("is %.4g um away from its position in", (a.position - b.position).norm() / kMicrometre);
  if (a.radius != b.radius)
    return format("has a radius that differs by %.4g um from that in", (b.radius - a.radius) / kMicrometre);
  return {};
}

void checkSame(const Session& first, const Session& s) {
  const std::string difference = differenceOf(first.machine, s.machine, "in " + nameOf(s));
  if (!difference.empty())
    refuse(s, first, "was measured on another machine (" + difference + ") than",
           "only sessions of one machine can be evaluated together");
  if (!(first.compensation == s.compensation))
    refuse(s, first, "was measured with another compensation in the controller than",
           "only sessions with the same compensation can be evaluated together");
  if (first.hasLaser() != s.hasLaser())
    refuse(s, first,
           std::string("was measured by ") +
               (s.hasLaser() ? "a laser, not by touch as" : "touch, not by a laser as"),
           "evaluate only sessions with one kind of probe together");
  if (first.artifact.name.empty() || s.artifact.name.empty()) return;
  if (first.artifact.name != s.artifact.name)
    refuse(s, first, "measured the artifact '" + s.artifact.name + "', not '" + first.artifact.name + "' as",
           "sessions of one artifact are judged together");
  if (!first.artifact.serial.empty() && !s.artifact.serial.empty() &&
      first.artifact.serial != s.artifact.serial)
    refuse(s, first,
           "measured the artifact with serial '" + s.artifact.serial + "', not '" + first.artifact.serial +
               "' as",
           "sessions of one artifact are judged together");
  if (first.artifact.styli.empty() != s.artifact.styli.empty() ||
      (first.artifact.styli.empty() && first.artifact.tipRadius != s.artifact.tipRadius))
    refuse(s, first, "was measured with another tip radius or other styli than",
           "name the styli in the artifact's file (probe: styli) of both");
}

/// What the artifact of a session has and the joint one has not is added; the observations count in that.
void takeArtifact(Session& out, Session& s) {
  if (out.artifact.name.empty()) {
    out.artifact = s.artifact;
    return;
  }
  std::vector<int> feature, stylus;
  for (const Feature& f : s.artifact.features) {
    int at = out.artifact.findFeature(f.name);
    if (at >= 0) {
      const std::string difference = differenceOf(out.artifact.features[static_cast<std::size_t>(at)], f);
      if (!difference.empty())
        refuse(s, out, "'" + f.name + "' of artifact '" + s.artifact.name + "' " + difference,
               "use one artifact file for both");
    } else {
      at = static_cast<int>(out.artifact.features.size());
      out.artifact.features.push_back(f);
    }
    feature.push_back(at);
  }
  for (const Stylus& one : s.artifact.styli) {
    int at = out.artifact.findStylus(one.name);
    if (at >= 0) {
      Stylus& known = out.artifact.styli[static_cast<std::size_t>(at)];
      const bool both = known.known && one.known;
      if (known.tipRadius != one.tipRadius || (both && known.offset != one.offset))
        refuse(s, out, "stylus '" + one.name + "' has another radius or offset than in",
               "different styli need different names");
      if (one.known) known = one;
    } else {
      at = static_cast<int>(out.artifact.styli.size());
      out.artifact.styli.push_back(one);
    }
    stylus.push_back(at);
  }
  for (Observation& o : s.observations) {
    if (o.feature >= 0) o.feature = feature[static_cast<std::size_t>(o.feature)];
    if (!stylus.empty()) o.stylus = stylus[static_cast<std::size_t>(o.stylus)];
  }
}

void takeSeries(std::vector<Series>& out, const std::vector<Series>& more, double begin, const Session& s) {
  for (const Series& series : more) {
    auto at = std::find_if(out.begin(), out.end(), [&](const Series& o) { return o.name == series.name; });
    if (at == out.end()) at = out.insert(at, {series.name, series.unit, {}, {}});
    if (at->unit != series.unit)
      throw InputError(s.source + ": '" + series.name + "' is in " + series.unit + " here and in " +
                       at->unit + " in the session before it; give both the same unit");
    for (std::size_t i = 0; i < series.time.size(); ++i) {
      at->time.push_back(begin + series.time[i]);
      at->value.push_back(series.value[i]);
    }
  }
}

/// What a session is, or is joined of.
std::vector<Recording> partsOf(const Session& session) {
  if (!session.recordings.empty()) return session.recordings;
  return {{session.source, sessionHash(session), session.rowFile, 0.0, session.timesAssumed}};
}

/// Of one day, and the first bears no time of day (its midnight stands for it).
bool orderUnknown(double first, double second) {
  return std::fmod(first, kDay) == 0.0 && second < first + kDay;
}

/// In the order of time. @return begin of each, s from that of the first.
std::vector<double> inOrder(std::vector<Session>& sessions, std::string& warning) {
  std::vector<double> epochs;
  for (const Session& s : sessions) epochs.push_back(s.epoch);
  std::sort(epochs.begin(), epochs.end());
  if (epochs.front() < kDated)
    warning = "not all sessions have a date: they are taken in the order given, one day apart";
  else if (std::adjacent_find(epochs.begin(), epochs.end(), orderUnknown) != epochs.end())
    warning = "sessions of one day have no time of day: they are taken in the order given, one day apart";
  const bool dated = warning.empty();
  if (dated)
    std::stable_sort(sessions.begin(), sessions.end(),
                     [](const Session& a, const Session& b) { return a.epoch < b.epoch; });
  std::vector<double> begins = {0.0};
  for (std::size_t i = 1; i < sessions.size(); ++i) {
    const double end = begins.back() + lastTime(sessions[i - 1]);
    begins.push_back(dated ? sessions[i].epoch - sessions[0].epoch : end + kDay);
    if (begins.back() <= end)
      refuse(sessions[i], sessions[i - 1], format("begins %.4g s before the end of", end - begins.back()),
             "a machine measures one session at a time; is a clock wrong?");
  }
  return begins;
}

}  // namespace

Session joined(std::vector<Session> sessions) {
  if (sessions.size() == 1) return std::move(sessions.front());
  std::map<std::string, std::string> seen;  // hash -> source
  for (const Session& s : sessions)
    for (const Recording& part : partsOf(s)) {
      const auto [same, isNew] = seen.emplace(part.hash, part.source);
      if (!isNew)
        throw InputError(part.source + ": is the same session as " + same->second +
                         "; give each session once");
    }
  std::string warning;
  const std::vector<double> begins = inOrder(sessions, warning);
  Session out(sessions.front().machine);
  out.epoch = sessions.front().epoch;
  out.compensation = sessions.front().compensation;
  for (const Session& s : sessions) checkSame(sessions.front(), s);
  NumberedNames placements, setups;
  std::multiset<std::string> namesIn;
  for (const Session& s : sessions) namesIn.insert(nameOf(s));
  for (std::size_t r = 0; r < sessions.size(); ++r) {
    Session& s = sessions[r];
    const int recording = static_cast<int>(out.recordings.size());
    const bool several = !s.recordings.empty();  // its placements and setups are told by session already
    const std::string own = namesIn.count(nameOf(s)) > 1 ? s.source : nameOf(s);
    out.source += (r > 0 ? ":" : "") + s.source;
    out.simulated = out.simulated || s.simulated;
    for (Recording part : partsOf(s)) {
      part.begin += begins[r];
      out.recordings.push_back(std::move(part));
    }
    if (!s.warning.empty()) warning += (warning.empty() ? "" : "; ") + own + ": " + s.warning;
    takeArtifact(out, s);
    if (out.artifact.serial.empty()) out.artifact.serial = s.artifact.serial;
    for (Observation& o : s.observations) {
      const std::string placement =
          s.placements.empty() ? "" : s.placements[static_cast<std::size_t>(o.placement)];
      const bool known =
          placement.empty() && (o.kind == ObservationKind::kDeviation || !s.poseFree(o.placement));
      const std::string behind = placement.empty() ? "" : ": " + placement;
      o.placement = placements[known ? "" : several ? placement : own + behind];
      if (o.setup >= 0) {
        const std::string& setup = s.setups[static_cast<std::size_t>(o.setup)];
        o.setup = setups[several ? setup : own + ": " + setup];
      }
      o.time += begins[r];
      o.recording += recording;
      out.observations.push_back(std::move(o));
    }
    takeSeries(out.temperatures, s.temperatures, begins[r], s);
    takeSeries(out.covariates, s.covariates, begins[r], s);
    for (const AssumedInput& a : s.assumed)
      if (std::none_of(out.assumed.begin(), out.assumed.end(),
                       [&](const AssumedInput& b) { return a.joint == b.joint && a.how == b.how; }))
        out.assumed.push_back(a);
    for (SetAside aside : s.setAside) {
      aside.recording += recording;
      out.setAside.push_back(std::move(aside));
    }
  }
  out.setups = setups.all();
  if (placements.all() != std::vector<std::string>{""}) out.placements = placements.all();
  out.warning = warning;
  return out;
}

}  // namespace mm
