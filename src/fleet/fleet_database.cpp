#include "fleet/fleet_database.h"

#include <type_traits>

#include "base/error.h"
#include "base/utc_now.h"
#include "fleet/fields.h"

namespace mm {
namespace {

constexpr int kFleetSchema = 2;

const char* const kTables = R"(
CREATE TABLE IF NOT EXISTS jobs(
  key TEXT PRIMARY KEY, machine TEXT NOT NULL, serial TEXT, date TEXT, session TEXT NOT NULL, model TEXT,
  calibration TEXT, source TEXT, current INTEGER NOT NULL DEFAULT 1,
  status TEXT NOT NULL DEFAULT 'waiting', failed TEXT, why TEXT, verdict TEXT, sentence TEXT, asked INTEGER,
  converged INTEGER, observations INTEGER, rms_um REAL, held_out_rms_um REAL, chi2_per_dof REAL,
  repeatability_um REAL, verified TEXT, verified_before_um REAL, verified_after_um REAL, software TEXT,
  session_hash TEXT, folder TEXT, angular INTEGER) WITHOUT ROWID;
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
  mean_degC REAL, noise_K REAL, span_K REAL, offset_K REAL, step_K REAL, PRIMARY KEY(job, sensor)) WITHOUT ROWID;
)";
const char* const kSinceSchema1 = R"(
ALTER TABLE jobs ADD COLUMN angular INTEGER;
ALTER TABLE sensors ADD COLUMN step_K REAL;
)";

const JobResult kNothing;  // for the names of its fields

template <class Field>
void bindField(Database::Statement& s, int place, const Field& field) {
  if constexpr (std::is_integral_v<Field>)
    s.bind(place, static_cast<long long>(field));
  else
    s.bind(place, field);
}

void readField(const Database::Statement& s, int column, std::string& field) { field = s.text(column); }
void readField(const Database::Statement& s, int column, double& field) { field = s.number(column); }
template <class Whole>
void readField(const Database::Statement& s, int column, Whole& field) {
  field = static_cast<Whole>(s.whole(column));
}

}  // namespace

FleetDatabase::FleetDatabase(const std::filesystem::path& file, Database::Use use) : database_(file, use) {
  Database::Statement version = database_.prepare("PRAGMA user_version");
  version.step();
  if (version.whole(0) > kFleetSchema)
    throw InputError(file.string() + ": was written by a newer version of the package (schema " +
                     std::to_string(version.whole(0)) + ", this one reads " + std::to_string(kFleetSchema) +
                     "); use that version");
  schema_ = version.whole(0);
  version.reset();
  if (use == Database::Use::kRead) return;
  database_.together([&] {
    if (schema_ == 1) database_.run(kSinceSchema1);
    schema_ = kFleetSchema;
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
    std::string set =
        "UPDATE jobs SET folder=?2, serial=iif(coalesce(serial,'')='',?3,serial), "
        "date=iif(coalesce(date,'')='',?4,date)";
    int place = 4;
    JobResult::stored(kNothing, [&](const char* name, const auto& /*field*/) {
      set += std::string(", ") + name + "=?" + std::to_string(++place);
    });
    Database::Statement job = database_.prepare(set + " WHERE key=?1");
    for (const JobResult& r : results) {
      job.bind(1, r.key).bind(2, folder.jobFolder(r.key).lexically_relative(folder.path()).string());
      job.bind(3, r.serial).bind(4, utcText(r.epoch));
      place = 4;
      JobResult::stored(r, [&](const char* /*name*/, const auto& field) { bindField(job, ++place, field); });
      job.step();
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
      database_.prepare("INSERT OR REPLACE INTO sensors VALUES(?1,?2,?3,?4,?5,?6,?7,?8,?9)");
  const auto add = [](Database::Statement& row, const std::string& key, const auto& thing) {
    int place = 1;
    row.bind(1, key);
    eachField(thing, [&](const char* /*name*/, const auto& field) { bindField(row, ++place, field); });
    row.step();
    row.reset();
  };
  for (const JobResult& r : results) {
    for (const FleetParameter& p : r.parameters) add(parameter, r.key, p);
    for (const SensorHealth& h : r.sensors) add(sensor, r.key, h);
    for (const std::string& effect : r.found) {
      found.bind(1, r.key).bind(2, effect).step();
      found.reset();
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
  return s.whole(0);
}

std::vector<FleetRecord> FleetDatabase::records() const {
  std::vector<FleetRecord> all;
  std::string columns = "machine,date,session,model,key,serial";
  JobResult::stored(kNothing, [&](const std::string& name, const auto& /*field*/) {
    columns += schema_ < 2 && name == "angular" ? ",0" : "," + name;
  });
  Database::Statement s = database_.prepare(
      "SELECT " + columns +
      " FROM jobs WHERE current=1 AND status<>'waiting' ORDER BY machine,date,session,model");
  while (s.step()) {
    FleetRecord record{s.text(0), s.text(1), s.text(2), s.text(3), {}};
    record.result.key = s.text(4);
    record.result.serial = s.text(5);
    int column = 5;
    JobResult::stored(record.result,
                      [&](const char* /*name*/, auto& field) { readField(s, ++column, field); });
    all.push_back(std::move(record));
  }
  addLists(all);
  return all;
}

void FleetDatabase::addLists(std::vector<FleetRecord>& records) const {
  Database::Statement parameters =
      database_.prepare("SELECT effect,name,unit,value,std,fixed FROM parameters WHERE job=?1");
  Database::Statement found = database_.prepare("SELECT effect FROM found WHERE job=?1");
  Database::Statement sensors =
      database_.prepare(std::string("SELECT sensor,logged,set_aside,mean_degC,noise_K,span_K,offset_K,") +
                        (schema_ < 2 ? "NULL" : "step_K") + " FROM sensors WHERE job=?1");
  const auto read = [](Database::Statement& row, auto& things) {
    while (row.step()) {
      int column = -1;
      eachField(things.emplace_back(),
                [&](const char* /*name*/, auto& field) { readField(row, ++column, field); });
    }
  };
  for (FleetRecord& record : records) {
    JobResult& r = record.result;
    for (Database::Statement* s : {&parameters, &found, &sensors}) {
      s->reset();
      s->bind(1, r.key);
    }
    read(parameters, r.parameters);
    read(sensors, r.sensors);
    while (found.step()) r.found.push_back(found.text(0));
  }
}

}  // namespace mm
