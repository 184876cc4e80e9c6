#include "nodes/calibration_watch.h"

#include <utility>

#include "base/error.h"
#include "base/read_file.h"
#include "calibration_file/calibration_fit.h"

namespace mm {
namespace {

constexpr std::chrono::seconds kAgain(1);  // between two attempts at what the disk does not give

}  // namespace

LoadedCalibration::LoadedCalibration(Calibration c, double margin)
    : id(c.id),
      calibration(std::move(c)),
      frames(calibration, {margin, false}),
      contacts(calibration, {margin, true}) {}

CalibrationWatch::CalibrationWatch(CalibrationStore store, const Machine& machine, std::string space,
                                   double margin)
    : store_(std::move(store)), machine_(machine), space_(std::move(space)), margin_(margin) {}

CalibrationWatch::Link CalibrationWatch::look(const char* name) const {
  namespace fs = std::filesystem;
  Link link;
  try {
    link.id = store_.linked(name);
  } catch (const InputError& e) {
    link.wrong = e.what();
  }
  if (link.id.empty()) return link;
  const fs::path target = store_.folder() / (link.id + ".yaml");
  std::error_code failed;  // then it is a time and a size that no file has
  link.changed = fs::last_write_time(target, failed);
  link.size = fs::file_size(target, failed);
  return link;
}

std::shared_ptr<const LoadedCalibration> CalibrationWatch::fitting(Calibration calibration,
                                                                   std::string& warning) const {
  const std::string misfit = misfitOf(calibration, machine_, space_);
  if (!misfit.empty()) throw InputError(misfit);
  const std::string unchecked = uncheckedFit(calibration, machine_);
  if (!unchecked.empty()) warning += (warning.empty() ? "" : "; ") + unchecked;
  return std::make_shared<const LoadedCalibration>(std::move(calibration), margin_);
}

bool CalibrationWatch::load(const Link& link, const char* what,
                            std::shared_ptr<const LoadedCalibration>& loaded, std::string& warning) const {
  warning.clear();
  const bool kept = loaded != nullptr;
  try {
    if (!link.wrong.empty()) throw InputError(link.wrong);
    if (link.id.empty()) {
      if (kept)
        throw InputError(std::string("the link '") + what + "' is gone from " + store_.folder().string());
      return true;
    }
    loaded = fitting(store_.load(link.id), warning);
    return true;
  } catch (const std::exception& e) {
    warning = e.what();
    if (kept) warning += "; '" + loaded->id + "', read before, stays in use";
    return dynamic_cast<const UnreadableFile*>(&e) == nullptr;
  }
}

void CalibrationWatch::Followed::note(const Link& now, bool given) {
  link = now;
  again.reset();
  if (!given) again = Wall::now() + kAgain;
}

/// Nothing is in memory yet: a damaged file falls back on what was active before it.
void CalibrationWatch::loadFirst() {
  bool given = true;
  try {
    CalibrationStore::Active active = store_.active();
    now_.warning = active.warning;
    if (active.calibration) now_.active = fitting(std::move(*active.calibration), now_.warning);
  } catch (const std::exception& e) {
    now_.warning = e.what();
    given = dynamic_cast<const UnreadableFile*>(&e) == nullptr;
  }
  const Link link = look("active");
  const bool standsIn = now_.active && now_.active->id != link.id;
  active_.note(link, given && !standsIn);
}

bool CalibrationWatch::followActive() {
  const Link link = look("active");
  if (!active_.due(link)) return false;
  active_.note(link, load(link, "active", now_.active, now_.warning));
  return true;
}

void CalibrationWatch::followCandidate(bool activeChanged) {
  const Link link = look("candidate");
  const bool none = link.wrong.empty() && (link.id.empty() || link.id == active_.link.id);
  if (none || (now_.candidate && now_.candidate->id != link.id)) now_.candidate = nullptr;
  if (none) {
    now_.candidateWarning.clear();
    candidate_.note(link, true);
  } else if (candidate_.due(link) || (activeChanged && !now_.candidate)) {
    candidate_.note(link, load(link, "candidate", now_.candidate, now_.candidateWarning));
  }
}

std::shared_ptr<const CalibrationPair> CalibrationWatch::refresh() {
  const CalibrationPair before = now_;
  const bool first = std::exchange(first_, false);
  if (first) loadFirst();
  const bool activeChanged = first || followActive();
  followCandidate(activeChanged);
  return first || !(now_ == before) ? std::make_shared<const CalibrationPair>(now_) : nullptr;
}

std::shared_ptr<const CalibrationPair> CalibrationWatch::setMargin(double margin) {
  margin_ = margin;
  for (auto* loaded : {&now_.active, &now_.candidate})
    if (*loaded) *loaded = std::make_shared<const LoadedCalibration>((*loaded)->calibration, margin_);
  return std::make_shared<const CalibrationPair>(now_);
}

}  // namespace mm
