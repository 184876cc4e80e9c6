#include "nodes/calibration_watch.h"

#include "base/error.h"

namespace mm {

LoadedCalibration::LoadedCalibration(Calibration c, double margin)
    : id(c.id),
      calibration(std::move(c)),
      frames(calibration, {margin, false}),
      contacts(calibration, {margin, true}) {}

CalibrationWatch::CalibrationWatch(CalibrationStore store, const Machine& machine, double margin)
    : store_(std::move(store)), margin_(margin) {
  for (const Joint& joint : machine.joints()) joints_.push_back(joint.name);
}

CalibrationWatch::Link CalibrationWatch::look(const char* name) const {
  namespace fs = std::filesystem;
  std::error_code failed;
  const fs::path target = fs::read_symlink(store_.folder() / name, failed);
  if (failed) return {};
  Link link;
  link.id = target.stem().string();
  link.changed = fs::last_write_time(store_.folder() / target, failed);
  if (failed) link.changed = {};
  link.size = fs::file_size(store_.folder() / target, failed);
  if (failed) link.size = 0;
  return link;
}

void CalibrationWatch::load(const Link& link, const char* what,
                            std::shared_ptr<const LoadedCalibration>& loaded, std::string& warning) const {
  warning.clear();
  const bool kept = loaded != nullptr;
  try {
    if (link.id.empty()) {
      if (kept)
        throw InputError(std::string("the link '") + what + "' is gone from " + store_.folder().string());
      return;
    }
    Calibration calibration = store_.load(link.id);
    std::string names, own;
    for (const Joint& joint : calibration.domain.joints) names += " " + joint.name;
    for (const std::string& joint : joints_) own += " " + joint;
    if (names != own)
      throw InputError("calibration '" + link.id + "' is of a machine with the joints" + names +
                       ", this one has" + own + "; promote a calibration of this machine");
    loaded = std::make_shared<const LoadedCalibration>(std::move(calibration), margin_);
  } catch (const std::exception& e) {
    warning = e.what();
    if (kept) warning += "; '" + loaded->id + "', read before, stays in use";
  }
}

void CalibrationWatch::loadFirst() {
  // Nothing is in memory yet: a damaged file falls back on what was active before it.
  try {
    CalibrationStore::Active active = store_.active();
    now_.warning = active.warning;
    if (active.calibration)
      now_.active = std::make_shared<const LoadedCalibration>(std::move(*active.calibration), margin_);
  } catch (const std::exception& e) {
    now_.warning = e.what();
  }
}

std::shared_ptr<const CalibrationPair> CalibrationWatch::refresh() {
  bool changed = first_;
  const Link active = first_ ? Link() : look("active");
  if (first_) {
    loadFirst();
    activeLink_ = look("active");
    if (now_.active && now_.active->id != activeLink_.id) activeLink_ = {};
    if (now_.active) {  // of this machine?
      std::shared_ptr<const LoadedCalibration> checked;
      std::string warning;
      load(activeLink_, "active", checked, warning);
      if (!checked) now_.active = nullptr, now_.warning = warning;
    }
    first_ = false;
  } else if (!(active == activeLink_)) {
    load(active, "active", now_.active, now_.warning);
    activeLink_ = active;
    changed = true;
  }
  const Link candidate = look("candidate");
  if (changed || !(candidate == candidateLink_)) {
    const bool none = candidate.id.empty() || candidate.id == activeLink_.id;
    if (none || (now_.candidate && now_.candidate->id != candidate.id)) now_.candidate = nullptr;
    now_.candidateWarning.clear();
    if (!none && !(candidate == candidateLink_ && now_.candidate))
      load(candidate, "candidate", now_.candidate, now_.candidateWarning);
    candidateLink_ = candidate;
    changed = true;
  }
  return changed ? std::make_shared<const CalibrationPair>(now_) : nullptr;
}

}  // namespace mm
