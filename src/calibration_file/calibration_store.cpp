#include "calibration_file/calibration_store.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "base/error.h"
#include "base/format.h"
#include "base/read_file.h"
#include "base/units.h"
#include "base/utc_now.h"
#include "calibration_file/atomic_file.h"
#include "calibration_file/calibration_yaml.h"

namespace mm {
namespace fs = std::filesystem;
namespace {

constexpr const char* kActive = "active";
constexpr const char* kCandidate = "candidate";
constexpr const char* kPromotions = "promotions";
constexpr const char* kVerifications = "verifications";
constexpr const char* kCertificates = "certificates";
constexpr const char* kSuffix = ".yaml";

/// Temporary files of a writer that was killed. Only under the lock, where no living writer has any. Throws
/// nothing: the lock that calls it must be released.
void removeLeftovers(const fs::path& folder) {
  std::error_code unreadable, ignored;
  for (fs::directory_iterator at(folder, unreadable), end; !unreadable && at != end; at.increment(unreadable))
    if (at->path().filename().string().find(kTemporaryMark) != std::string::npos)
      fs::remove(at->path(), ignored);
}

/// Lets one writer at a time into a folder, without what those that were killed left there; released with
/// the process at the latest.
class FolderLock {
 public:
  explicit FolderLock(const fs::path& folder) {
    const fs::path file = folder / ".lock";
    descriptor_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0)
      throw InputError(file.string() + ": cannot be written: " + std::strerror(errno) +
                       "; check the permissions of the folder of calibrations");
    while (::flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) {
    }
    removeLeftovers(folder);
  }
  ~FolderLock() { ::close(descriptor_); }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_ = -1;
};

/// An id becomes the name of a file: nothing that could lead elsewhere.
void checkId(const std::string& id) {
  const bool fit = !id.empty() && id.front() != '.' && std::all_of(id.begin(), id.end(), [](unsigned char c) {
    return std::isalnum(c) || std::strchr("._-", c);
  });
  if (!fit)
    throw InputError("calibration id '" + id +
                     "': only letters, digits, '.', '_' and '-'; mm history lists the ids");
}

/// One of the lists, an entry a line; those that `read(words, entry)` cannot read are left out.
template <class Entry, class Read>
std::vector<Entry> entriesOf(const fs::path& list, const Read& read) {
  std::vector<Entry> all;
  if (!fs::exists(list)) return all;
  std::istringstream lines(readFile(list));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    if (Entry entry; read(words, entry)) all.push_back(std::move(entry));
  }
  return all;
}

void addLine(const fs::path& list, const std::string& line) {
  std::string text = fs::exists(list) ? readFile(list) : std::string();
  if (!text.empty() && text.back() != '\n') text += '\n';
  writeFileAtomically(list, text + line + "\n");
}

InputError noSuch(const fs::path& folder, const std::string& id) {
  return InputError("no calibration '" + id + "' in " + folder.string() +
                    "; mm history lists the stored ones");
}

}  // namespace

fs::path CalibrationStore::defaultFolder() {
  const char* named = std::getenv("MM_CALIBRATIONS");
  if (named != nullptr && *named != '\0') return named;
  const char* home = std::getenv("HOME");
  if (home == nullptr || *home == '\0')
    throw InputError(
        "no folder for calibrations: neither MM_CALIBRATIONS nor HOME is set; name one with --store");
  return fs::path(home) / ".measuring_machine" / "calibrations";
}

void CalibrationStore::prepareFolder() const {
  std::error_code failed;
  fs::create_directories(folder_, failed);
  if (failed || !fs::is_directory(folder_))
    throw InputError(folder_.string() + ": cannot be made a folder of calibrations: " + failed.message() +
                     "; check the path and its permissions");
}

fs::path CalibrationStore::fileOf(const std::string& id) const {
  checkId(id);
  return folder_ / (id + kSuffix);
}

std::string CalibrationStore::linked(const char* link) const {
  std::error_code failed;
  const fs::path target = fs::read_symlink(folder_ / link, failed);
  if (failed) {
    if (fs::exists(folder_ / link, failed))
      throw InputError((folder_ / link).string() +
                       ": must be a link to a calibration in its folder; remove it, then promote an id of mm "
                       "history");
    return {};
  }
  // A path would lead to a calibration of another folder, or to none; its name alone may be one of this
  // folder's.
  const fs::path inside = fs::weakly_canonical(folder_, failed) / target.filename();
  if (target != target.filename() && fs::weakly_canonical(folder_ / target, failed) != inside)
    throw InputError(
        (folder_ / link).string() + ": leads to " + target.string() +
        ", which is not in that folder; promote an id of mm history, or 'mm promote <file>' to keep "
        "a copy here");
  return target.stem().string();
}

std::string CalibrationStore::linkedHere(const char* link) const {
  try {
    return linked(link);
  } catch (const InputError&) {
    return {};  // whoever replaces it mends it
  }
}

Calibration CalibrationStore::load(const std::string& id) const {
  const fs::path file = fileOf(id);
  if (!fs::exists(file)) throw noSuch(folder_, id);
  return loadCalibration(file);
}

std::string CalibrationStore::add(Calibration& calibration) {
  prepareFolder();
  const FolderLock lock(folder_);
  completeCalibration(calibration);
  const std::string wanted = calibration.id;
  for (int n = 2; fs::exists(fileOf(calibration.id)); ++n) {
    if (readFile(fileOf(calibration.id)) == calibrationYaml(calibration)) break;  // kept already
    calibration.id = wanted + "-" + std::to_string(n);
  }
  writeFileAtomically(fileOf(calibration.id), calibrationYaml(calibration));
  linkAtomically(folder_ / kCandidate, calibration.id + kSuffix);
  return calibration.id;
}

std::vector<CalibrationStore::Promotion> CalibrationStore::promotions() const {
  return entriesOf<Promotion>(folder_ / kPromotions, [](std::istream& words, Promotion& p) {
    return static_cast<bool>(words >> p.time >> p.action >> p.id);
  });
}

bool CalibrationStore::keeps(const std::string& id) const {
  std::error_code failed;
  return fs::is_regular_file(fileOf(id), failed);
}

// time id verdict before after and their standard uncertainties, unit, points, session: that last, for it may
// hold blanks.
void CalibrationStore::note(Verified v) const {
  if (!keeps(v.id)) throw noSuch(folder_, v.id);
  if (v.time.empty()) v.time = utcNow();
  for (char& c : v.session)
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) c = ' ';
  const double unit = v.angular ? kArcsecond : kMicrometre;
  const FolderLock lock(folder_);
  addLine(folder_ / kVerifications,
          format("%s %s %s %.6g %.6g %.3g %.3g %s %d ", v.time.c_str(), v.id.c_str(), v.verdict.c_str(),
                 v.before / unit, v.after / unit, v.beforeStd / unit, v.afterStd / unit,
                 v.angular ? "arcsec" : "um", v.points) +
              v.session);
}

int CalibrationStore::noteIssue(Issue issue) const {
  if (!keeps(issue.id)) throw noSuch(folder_, issue.id);
  const FolderLock lock(folder_);
  for (const Issue& earlier : issues())
    if (earlier.id == issue.id) issue.count = std::max(issue.count, earlier.count + 1);
  issue.count = std::max(issue.count, 1);
  addLine(folder_ / kCertificates,
          issue.stamp + " " + issue.id + " " + issue.form + " " + std::to_string(issue.count));
  return issue.count;
}

std::vector<CalibrationStore::Issue> CalibrationStore::issues() const {
  return entriesOf<Issue>(folder_ / kCertificates, [](std::istream& words, Issue& issue) {
    return static_cast<bool>(words >> issue.stamp >> issue.id >> issue.form >> issue.count);
  });
}

std::vector<CalibrationStore::Verified> CalibrationStore::verifications() const {
  return entriesOf<Verified>(folder_ / kVerifications, [](std::istream& words, Verified& v) {
    std::string unit;
    if (!(words >> v.time >> v.id >> v.verdict >> v.before >> v.after >> v.beforeStd >> v.afterStd >> unit >>
          v.points))
      return false;
    v.angular = unit == "arcsec";
    for (double* figure : {&v.before, &v.after, &v.beforeStd, &v.afterStd})
      *figure *= v.angular ? kArcsecond : kMicrometre;
    std::getline(words >> std::ws, v.session);
    return true;
  });
}

std::vector<std::string> CalibrationStore::before(const std::string& id) const {
  std::vector<std::string> stack;
  for (const Promotion& p : promotions()) {
    const auto known = std::find(stack.rbegin(), stack.rend(), p.id);
    if (p.action == "rollback" && known != stack.rend())
      stack.erase(known.base(), stack.end());  // keeps p.id on top
    else
      stack.push_back(p.id);
  }
  // The link is what counts: a writer may have been killed between the list and the link.
  const auto at = std::find(stack.rbegin(), stack.rend(), id);
  std::vector<std::string> earlier;
  for (auto it = at == stack.rend() ? stack.rbegin() : at + 1; it != stack.rend(); ++it)
    if (*it != id && std::find(earlier.begin(), earlier.end(), *it) == earlier.end()) earlier.push_back(*it);
  return earlier;
}

void CalibrationStore::makeActive(const std::string& id, const std::string& action) const {
  addLine(folder_ / kPromotions, utcNow() + " " + action + " " + id);
  linkAtomically(folder_ / kActive, id + kSuffix);
}

std::string CalibrationStore::promote(const std::string& id, const Check& check) {
  const std::string chosen = id.empty() ? linked(kCandidate) : id;
  if (chosen.empty())
    throw InputError("no candidate in " + folder_.string() +
                     "; calibrate with --store, or name an id of mm history");
  const Calibration wanted = load(chosen);  // refuses what is damaged before it is active
  if (check) check(wanted);
  const FolderLock lock(folder_);
  if (linkedHere(kActive) != chosen) makeActive(chosen, "promote");
  if (linkedHere(kCandidate) == chosen) {
    std::error_code ignored;
    fs::remove(folder_ / kCandidate, ignored);
  }
  return chosen;
}

std::string CalibrationStore::fallBack(const std::string& from, std::string& passedOver) const {
  for (const std::string& earlier : before(from)) {
    try {
      load(earlier);
      return earlier;
    } catch (const UnreadableFile&) {
      throw;  // it may well be whole: one before it is not what was asked for
    } catch (const InputError& e) {
      passedOver += std::string(passedOver.empty() ? "" : "; ") + e.what();
    }
  }
  return {};
}

std::string CalibrationStore::rollback(const std::string& id, const Check& check) {
  const std::string now = id.empty() ? linked(kActive) : std::string();
  std::string chosen = id, passedOver;
  const std::vector<Promotion> all = promotions();
  if (!id.empty() && keeps(id) && linkedHere(kActive) != id &&
      std::none_of(all.begin(), all.end(), [&](const Promotion& p) { return p.id == id; }))
    throw InputError("calibration '" + id +
                     "' was never active, so nothing leads back to it; promote it instead");
  if (chosen.empty()) {
    if (now.empty())
      throw InputError("no calibration is active in " + folder_.string() +
                       "; make one active with mm promote");
    chosen = fallBack(now, passedOver);
    if (chosen.empty())
      throw InputError("no undamaged calibration was active before '" + now + "' in " + folder_.string() +
                       (passedOver.empty() ? "" : " (" + passedOver + ")") + "; promote an id of mm history");
  }
  const Calibration wanted = load(chosen);
  if (check) check(wanted);
  const FolderLock lock(folder_);
  makeActive(chosen, "rollback");
  return chosen;
}

CalibrationStore::Active CalibrationStore::active() const {
  const std::string id = linked(kActive);
  if (id.empty()) return {};
  Active found;
  bool damaged = true;
  try {
    found.calibration = load(id);
    return found;
  } catch (const UnreadableFile& e) {
    found.warning = e.what();
    damaged = false;  // the disk does not give it now: it stays the active one
  } catch (const InputError& e) {
    found.warning = e.what();
  }
  std::string passedOver;
  const std::string last = fallBack(id, passedOver);
  if (!passedOver.empty()) found.warning += "; " + passedOver;
  if (last.empty())
    throw InputError(found.warning +
                     "; no earlier active calibration is undamaged: promote an id of mm history");
  found.calibration = load(last);
  found.warning += "; the last good calibration '" + last + "' is active instead";
  if (!damaged) {
    found.warning += " (for this program only: whether the other is damaged is not known)";
    return found;
  }
  try {
    const FolderLock lock(folder_);
    if (linked(kActive) == id) makeActive(last, "rollback");
  } catch (const InputError&) {
    found.warning += " (for this program only: the folder cannot be written)";
  }
  return found;
}

CalibrationStore::Active CalibrationStore::candidate() const {
  const std::string id = linked(kCandidate);
  if (id.empty() || id == linkedHere(kActive)) return {};
  Active found;
  try {
    found.calibration = load(id);
  } catch (const InputError& e) {
    found.warning = e.what();
  }
  return found;
}

std::vector<CalibrationStore::Entry> CalibrationStore::history() const {
  std::vector<Entry> entries;
  if (!fs::exists(folder_)) return entries;
  const std::string active = linkedHere(kActive), candidate = linkedHere(kCandidate);
  const std::vector<Promotion> made = promotions();
  for (const fs::directory_entry& item : fs::directory_iterator(folder_)) {
    const std::string name = item.path().filename().string();
    if (name.front() == '.' || item.path().extension() != kSuffix) continue;
    if (!item.is_symlink() && !item.is_regular_file()) continue;
    Entry entry;
    entry.file = item.path();
    entry.id = item.path().stem().string();
    entry.active = entry.id == active;
    entry.candidate = entry.id == candidate && !entry.active;
    for (std::size_t i = 0; i < made.size(); ++i)
      if (made[i].id == entry.id) {
        ++entry.promotions;
        entry.lastPromotion = static_cast<int>(i) + 1;
      }
    try {
      const Calibration c = loadCalibration(item.path());
      entry.created = c.created;
      entry.machine = c.machineName;
      entry.session = c.sessionSource;
      entry.method = c.method;
      entry.rms = c.rms;
      entry.heldOutRms = c.heldOutRms;
      entry.effects = c.effects.size();
    } catch (const InputError& e) {
      entry.damaged = e.what();
    }
    entries.push_back(std::move(entry));
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.created != b.created ? a.created < b.created : a.id < b.id;
  });
  return entries;
}

}  // namespace mm
