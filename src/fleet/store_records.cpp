#include <algorithm>

#include "base/error.h"
#include "calibration_file/calibration_store.h"
#include "fleet/fleet.h"
#include "machine/machine.h"
#include "machine/machine_fit.h"

namespace mm {
namespace {

/// One store's calibrations; damaged ones as failed records.
void addStore(const std::filesystem::path& folder, const std::string& name,
              std::vector<FleetRecord>& records) {
  const CalibrationStore store(folder);
  for (const CalibrationStore::Entry& entry : store.history()) {
    FleetRecord record;
    record.session = entry.file.string();
    record.result.key = entry.id;
    if (!entry.damaged.empty()) {
      record.machine = name.empty() ? "?" : name;
      record.result.status = "failed";
      record.result.failed = "calibration";
      record.result.why = entry.damaged;
      records.push_back(std::move(record));
      continue;
    }
    const Calibration c = store.load(entry.id);
    const std::string serial = serialOf(Machine(c.urdf, c.machineName));
    record.machine = !name.empty() ? name : !serial.empty() ? serial : c.machineName;
    record.date = c.created;
    record.result.status = "done";
    record.result.serial = serial;
    record.result.software = c.software;
    record.result.observations = static_cast<long>(c.observations);
    record.result.rms = 1e6 * c.rms;
    record.result.heldOutRms = 1e6 * c.heldOutRms;
    record.result.parameters = parametersOf(c);
    for (const LedgerEntry& step : c.ledger)
      if (step.action == "add") record.result.found.push_back(step.effect.yaml());
    records.push_back(std::move(record));
  }
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
