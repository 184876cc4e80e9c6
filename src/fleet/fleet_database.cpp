#include "fleet/fleet_database.h"

#include <cmath>
#include <ctime>

#include "base/error.h"

namespace mm {
namespace {

constexpr int kFleetSchema = 1;

const char* const kTables = R"(
CREATE TABLE IF NOT EXISTS jobs(
  key TEXT PRIMARY KEY, machine TEXT NOT NULL, serial TEXT, date TEXT, session TEXT NOT NULL, model TEXT,
  calibration TEXT, source TEXT, current INTEGER NOT NULL DEFAULT 1,
  status TEXT NOT NULL DEFAULT 'waiting', failed TEXT, why TEXT, verdict TEXT, sentence TEXT, asked INTEGER,
  converged INTEGER, observations INTEGER, rms_um REAL, held_out_rms_um REAL, chi2_per_dof REAL,
  repeatability_um REAL, verified TEXT, verified_before_um REAL, verified_after_um REAL, software TEXT,
  session_hash TEXT, folder TEXT) WITHOUT ROWID;
CREATE INDEX IF NOT EXISTS jobs_of_machine ON jobs(machine, date);
CREATE INDEX IF NOT EXISTS jobs_of_session ON jobs(session, model);
CREATE INDEX IF NOT EXISTS jobs_of_status ON jobs(status);
CREATE TABLE IF NOT EXISTS parameters(
  job TEXT NOT NULL REFERENCES jobs(key), effect TEXT NOT NULL, name TEXT NOT NULL, unit TEXT, value REAL,
  std REAL, fixed INTEGER, PRIMARY KEY(job, effect, name)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS found(
  job TEXT NOT NULL REFERENCES jobs(key), effect TEXT NOT NULL, PRIMARY KEY(job, effect)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS sensors(
  job TEXT NOT NULL REFERENCES jobs(key), sensor TEXT NOT NULL, logged INTEGER, set_aside INTEGER,
  mean_degC REAL, noise_K REAL, span_K REAL, offset_K REAL, PRIMARY KEY(job, sensor)) WITHOUT ROWID;
)";

std::string stampOf(double epoch) {
  if (!std::isfinite(epoch)) return {};
  const auto seconds = static_cast<std::time_t>(std::floor(epoch));
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  return std::string(text, std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc));
}

}  // namespace

FleetDatabase::FleetDatabase(const std::filesystem::path& file, Database::Use use) : database_(file, use) {
  Database::Statement version = database_.prepare("PRAGMA user_version");
  version.step();
  if (version.whole(0) > kFleetSchema)
    throw InputError(file.string() + ": was written by a newer version of the package (schema " +
                     std::to_string(version.whole(0)) + ", this one reads " + std::to_string(kFleetSchema) +
                     "); use that version");
  version.reset();
  if (use == Database::Use::kRead) return;
  database_.together([&] {
    database_.run(kTables);
    database_.run("PRAGMA user_version=" + std::to_string(kFleetSchema));
  });
}

std::set<std::string> FleetDatabase::plan(const std::vector<BatchJob>& jobs) {
  std::set<std::string> entered;
  database_.together([&] {
    Database::Statement retire =
        database_.prepare("UPDATE jobs SET current=0 WHERE session=?1 AND model=?2 AND key<>?3");
    Database::Statement insert = database_.prepare(
        "INSERT INTO jobs(key,machine,serial,date,session,model,calibration,source) "
        "VALUES(?1,?2,?3,?4,?5,?6,?7,?8) "
        "ON CONFLICT(key) DO UPDATE SET machine=?2, serial=iif(?3='',serial,?3), date=iif(?4='',date,?4), "
        "session=?5, model=?6, calibration=?7, source=?8, current=1");
    Database::Statement status = database_.prepare("SELECT status FROM jobs WHERE key=?1");
    std::set<std::string> keys;
    for (const BatchJob& job : jobs) keys.insert(job.key);
    for (const BatchJob& job : jobs) {
      retire.bind(1, job.bag.string()).bind(2, job.model.string()).bind(3, job.key).step();
      retire.reset();
    }
    for (const BatchJob& job : jobs) {
      insert.bind(1, job.key).bind(2, job.machine).bind(3, job.serial).bind(4, job.date);
      insert.bind(5, job.bag.string()).bind(6, job.model.string()).bind(7, job.calibration.string());
      insert.bind(8, job.source).step();
      insert.reset();
      status.bind(1, job.key);
      if (status.step() && status.text(0) != "waiting") entered.insert(job.key);
      status.reset();
    }
  });
  return entered;
}

void FleetDatabase::enter(const std::vector<JobResult>& results, const ResultsFolder& folder) {
  database_.together([&] {
    Database::Statement job = database_.prepare(
        "UPDATE jobs SET status=?2, failed=?3, why=?4, verdict=?5, sentence=?6, asked=?7, converged=?8, "
        "observations=?9, rms_um=?10, held_out_rms_um=?11, chi2_per_dof=?12, repeatability_um=?13, "
        "verified=?14, "
        "verified_before_um=?15, verified_after_um=?16, software=?17, session_hash=?18, folder=?19, "
        "serial=iif(coalesce(serial,'')='',?20,serial), date=iif(coalesce(date,'')='',?21,date) WHERE "
        "key=?1");
    for (const JobResult& r : results) {
      job.bind(1, r.key).bind(2, r.status).bind(3, r.failed).bind(4, r.why).bind(5, r.verdict);
      job.bind(6, r.sentence).bind(7, static_cast<long long>(r.asked));
      job.bind(8, static_cast<long long>(r.converged)).bind(9, static_cast<long long>(r.observations));
      job.bind(10, r.rms).bind(11, r.heldOutRms).bind(12, r.chi2PerDof).bind(13, r.repeatability);
      job.bind(14, r.verified).bind(15, r.verifiedBefore).bind(16, r.verifiedAfter).bind(17, r.software);
      job.bind(18, r.sessionHash)
          .bind(19, folder.jobFolder(r.key).lexically_relative(folder.path()).string());
      job.bind(20, r.serial).bind(21, stampOf(r.epoch)).step();
      job.reset();
    }
    enterLists(results);
  });
}

void FleetDatabase::enterLists(const std::vector<JobResult>& results) const {
  Database::Statement parameter =
      database_.prepare("INSERT OR REPLACE INTO parameters VALUES(?1,?2,?3,?4,?5,?6,?7)");
  Database::Statement found = database_.prepare("INSERT OR REPLACE INTO found VALUES(?1,?2)");
  Database::Statement sensor =
      database_.prepare("INSERT OR REPLACE INTO sensors VALUES(?1,?2,?3,?4,?5,?6,?7,?8)");
  for (const JobResult& r : results) {
    for (const FleetParameter& p : r.parameters) {
      parameter.bind(1, r.key).bind(2, p.effect).bind(3, p.name).bind(4, p.unit).bind(5, p.value);
      parameter.bind(6, p.std).bind(7, static_cast<long long>(p.fixed)).step();
      parameter.reset();
    }
    for (const std::string& effect : r.found) {
      found.bind(1, r.key).bind(2, effect).step();
      found.reset();
    }
    for (const SensorHealth& h : r.sensors) {
      sensor.bind(1, r.key).bind(2, h.sensor).bind(3, static_cast<long long>(h.values));
      sensor.bind(4, static_cast<long long>(h.setAside)).bind(5, h.mean).bind(6, h.noise).bind(7, h.span);
      sensor.bind(8, h.offset).step();
      sensor.reset();
    }
  }
}

void FleetDatabase::takeOut(const std::string& key) {
  database_.together([&] {
    for (const char* table : {"parameters", "found", "sensors"})
      database_.prepare(std::string("DELETE FROM ") + table + " WHERE job=?1").bind(1, key).step();
    database_.prepare("UPDATE jobs SET status='waiting', failed='', why='' WHERE key=?1").bind(1, key).step();
  });
}

long FleetDatabase::count(const std::string& status) const {
  Database::Statement s = database_.prepare("SELECT count(*) FROM jobs WHERE current=1 AND status=?1");
  s.bind(1, status).step();
  return static_cast<long>(s.whole(0));
}

std::vector<FleetRecord> FleetDatabase::records(const std::string& machine) const {
  std::vector<FleetRecord> all;
  Database::Statement s = database_.prepare(
      "SELECT "
      "key,machine,serial,date,session,model,status,failed,why,verdict,sentence,asked,converged,observations,"
      "rms_um,held_out_rms_um,chi2_per_dof,repeatability_um,verified,verified_before_um,verified_after_um,"
      "software,"
      "session_hash FROM jobs WHERE current=1 AND status<>'waiting' AND (?1='' OR machine=?1) "
      "ORDER BY machine,date,session,model");
  s.bind(1, machine);
  while (s.step()) {
    FleetRecord record{s.text(1), s.text(3), s.text(4), s.text(5), {}};
    JobResult& r = record.result;
    r.key = s.text(0);
    r.serial = s.text(2);
    r.status = s.text(6);
    r.failed = s.text(7);
    r.why = s.text(8);
    r.verdict = s.text(9);
    r.sentence = s.text(10);
    r.asked = s.whole(11) != 0;
    r.converged = s.whole(12) != 0;
    r.observations = static_cast<long>(s.whole(13));
    r.rms = s.number(14);
    r.heldOutRms = s.number(15);
    r.chi2PerDof = s.number(16);
    r.repeatability = s.number(17);
    r.verified = s.text(18);
    r.verifiedBefore = s.number(19);
    r.verifiedAfter = s.number(20);
    r.software = s.text(21);
    r.sessionHash = s.text(22);
    all.push_back(std::move(record));
  }
  addLists(all);
  return all;
}

void FleetDatabase::addLists(std::vector<FleetRecord>& records) const {
  Database::Statement parameters =
      database_.prepare("SELECT effect,name,unit,value,std,fixed FROM parameters WHERE job=?1");
  Database::Statement found = database_.prepare("SELECT effect FROM found WHERE job=?1");
  Database::Statement sensors = database_.prepare(
      "SELECT sensor,logged,set_aside,mean_degC,noise_K,span_K,offset_K FROM sensors WHERE job=?1");
  for (FleetRecord& record : records) {
    JobResult& r = record.result;
    for (Database::Statement* s : {&parameters, &found, &sensors}) {
      s->reset();
      s->bind(1, r.key);
    }
    while (parameters.step())
      r.parameters.push_back({parameters.text(0), parameters.text(1), parameters.text(2),
                              parameters.number(3), parameters.number(4), parameters.whole(5) != 0});
    while (found.step()) r.found.push_back(found.text(0));
    while (sensors.step())
      r.sensors.push_back({sensors.text(0), static_cast<int>(sensors.whole(1)),
                           static_cast<int>(sensors.whole(2)), sensors.number(3), sensors.number(4),
                           sensors.number(5), sensors.number(6)});
  }
}

}  // namespace mm
