#include <algorithm>
#include <map>

#include "base/error.h"
#include "base/text.h"
#include "calibration_file/calibration_store.h"
#include "fleet/fleet.h"
#include "machine/machine.h"
#include "machine/machine_fit.h"
#include "verification/trend.h"

namespace mm {
namespace {

/// A calibration's record, and how much it counts among those of its session.
struct Stored {
  std::string session;    // hash; empty: the file does not tell
  int lastPromotion = 0;  // see CalibrationStore::Entry
  FleetRecord record;
};

/// The effects in the order of their names: parameters of other models mean something else.
std::string effectsOf(const Calibration& c) {
  std::vector<std::string> effects;
  for (const EffectSpec& effect : c.effects) effects.push_back(effect.yaml());
  std::sort(effects.begin(), effects.end());
  return joined(effects, ", ");
}

Stored storedOf(const CalibrationStore& store, const CalibrationStore::Entry& entry,
                const std::string& name) {
  Stored stored;
  FleetRecord& record = stored.record;
  record.session = entry.file.string();
  record.result.key = entry.id;
  if (!entry.damaged.empty()) {
    record.machine = name.empty() ? "?" : name;
    record.result.status = "failed";
    record.result.failed = "calibration";
    record.result.why = entry.damaged;
    return stored;
  }
  const Calibration c = store.load(entry.id);
  const std::string serial = serialOf(Machine(c.urdf, c.machineName));
  stored.session = c.sessionHash;
  stored.lastPromotion = entry.lastPromotion;
  record.machine = !name.empty() ? name : !serial.empty() ? serial : c.machineName;
  record.date = measuredAt(c);
  record.model = effectsOf(c);
  record.result.status = "done";
  record.result.serial = serial;
  record.result.software = c.software;
  record.result.sessionHash = c.sessionHash;
  takeFigures(c, record.result);
  return stored;
}

/// One store's calibrations, one a session: every effect that was added to a calibration kept one more of the
/// same session. What was made active last counts, else the last. Damaged ones are failed records.
void addStore(const std::filesystem::path& folder, const std::string& name,
              std::vector<FleetRecord>& records) {
  const CalibrationStore store(folder);
  std::vector<Stored> kept;
  std::map<std::string, std::size_t> ofSession;
  for (const CalibrationStore::Entry& entry : store.history()) {  // the oldest first
    Stored stored = storedOf(store, entry, name);
    if (stored.session.empty()) {
      kept.push_back(std::move(stored));
      continue;
    }
    const auto [at, isNew] = ofSession.emplace(stored.session, kept.size());
    if (isNew)
      kept.push_back(std::move(stored));
    else if (stored.lastPromotion >= kept[at->second].lastPromotion)
      kept[at->second] = std::move(stored);
  }
  for (Stored& stored : kept) records.push_back(std::move(stored.record));
}

}  // namespace

std::vector<FleetRecord> storeRecords(const std::string& folder) {
  std::vector<FleetRecord> records;
  addStore(folder, {}, records);
  std::vector<std::filesystem::path> machines;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
    if (entry.is_directory(ignored)) machines.push_back(entry.path());
  std::sort(machines.begin(), machines.end());
  for (const auto& machine : machines) addStore(machine, machine.filename().string(), records);
  if (records.empty())
    throw InputError(folder +
                     ": holds neither fleet.db (of mm batch -o) nor calibrations (of mm promote and the "
                     "services); name such a folder, or one with a folder of calibrations for each machine");
  return records;
}

}  // namespace mm
