#include "fleet/fleet_database.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <iostream>

#include "base/error.h"
#include "fleet_support.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

class FleetDatabaseTest : public testing::Test {
 protected:
  FleetDatabaseTest() : folder_(make()) {}
  ~FleetDatabaseTest() override { fs::remove_all(folder_); }
  static fs::path make() {
    std::string pattern = (fs::temp_directory_path() / "mm_database_XXXXXX").string();
    return mkdtemp(pattern.data());
  }
  static BatchJob job(const std::string& key, const std::string& bag) {
    BatchJob j;
    j.key = key;
    j.bag = bag;
    j.model = "/model.yaml";
    j.machine = "mill";
    j.date = "2026-01-05T00:00:00Z";
    return j;
  }
  JobResult resultOf(const std::string& key) const {
    JobResult r = MadeUpFleet(1, 1, 1).records[0].result;
    r.key = key;
    return r;
  }
  fs::path folder_;
};

TEST_F(FleetDatabaseTest, whatIsEnteredIsReadBackToTheBit) {
  FleetDatabase tables(folder_ / "fleet.db", Database::Use::kWrite);
  EXPECT_TRUE(tables.plan({job("a", "/a.bag")}).empty());
  EXPECT_EQ(tables.count("waiting"), 1);
  const JobResult entered = resultOf("a");
  tables.enter({entered}, ResultsFolder(folder_));
  const std::vector<FleetRecord> records =
      FleetDatabase(folder_ / "fleet.db", Database::Use::kRead).records();
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].machine, "mill");
  EXPECT_EQ(records[0].date, "2026-01-05T00:00:00Z");
  const JobResult& read = records[0].result;
  ASSERT_EQ(read.parameters.size(), entered.parameters.size());
  for (std::size_t i = 0; i < read.parameters.size(); ++i) {
    EXPECT_EQ(read.parameters[i].effect, entered.parameters[i].effect);
    EXPECT_EQ(read.parameters[i].value, entered.parameters[i].value);
    EXPECT_EQ(read.parameters[i].std, entered.parameters[i].std);
  }
  EXPECT_EQ(read.sensors.size(), 3u);
  EXPECT_EQ(read.heldOutRms, entered.heldOutRms);
  EXPECT_TRUE(std::isnan(read.chi2PerDof));  // was not there
}

TEST_F(FleetDatabaseTest, enteringTwiceIsEnteringOnce) {
  FleetDatabase tables(folder_ / "fleet.db", Database::Use::kWrite);
  tables.plan({job("a", "/a.bag"), job("b", "/b.bag")});
  for (int i = 0; i < 3; ++i) tables.enter({resultOf("a")}, ResultsFolder(folder_));
  EXPECT_EQ(tables.records().size(), 1u);
  EXPECT_EQ(tables.records()[0].result.parameters.size(), 9u);
  EXPECT_EQ(tables.plan({job("a", "/a.bag"), job("b", "/b.bag")}), std::set<std::string>{"a"});
}

TEST_F(FleetDatabaseTest, aSessionThatChangedReplacesItsOlderSelf) {
  FleetDatabase tables(folder_ / "fleet.db", Database::Use::kWrite);
  tables.plan({job("a", "/a.bag")});
  tables.enter({resultOf("a")}, ResultsFolder(folder_));
  tables.plan({job("a2", "/a.bag")});
  EXPECT_TRUE(tables.records().empty());
  tables.enter({resultOf("a2")}, ResultsFolder(folder_));
  ASSERT_EQ(tables.records().size(), 1u);
  EXPECT_EQ(tables.records()[0].result.key, "a2");
  tables.plan({job("a", "/a.bag")});  // and back
  EXPECT_EQ(tables.records()[0].result.key, "a");
}

TEST_F(FleetDatabaseTest, isReadWhileItIsWritten) {
  const FleetDatabase writer(folder_ / "fleet.db", Database::Use::kWrite);
  Database database(folder_ / "fleet.db", Database::Use::kWrite);
  database.together([&] {
    database.run("INSERT INTO jobs(key,machine,session) VALUES('x','m','/x.bag')");
    EXPECT_EQ(FleetDatabase(folder_ / "fleet.db", Database::Use::kRead).count("waiting"), 0);
  });
  EXPECT_EQ(FleetDatabase(folder_ / "fleet.db", Database::Use::kRead).count("waiting"), 1);
  Database::Statement mode = database.prepare("PRAGMA journal_mode");
  mode.step();
  EXPECT_EQ(mode.text(0), "wal");
}

TEST_F(FleetDatabaseTest, aFileThatWasRemovedWhileItsLogWasLeftIsMadeAnew) {
  const Database reader = [&] {
    FleetDatabase tables(folder_ / "fleet.db", Database::Use::kWrite);
    tables.plan({job("a", "/a.bag")});
    return Database(folder_ / "fleet.db", Database::Use::kRead);
  }();
  reader.run("SELECT * FROM jobs");
  ASSERT_TRUE(fs::exists(folder_ / "fleet.db-wal"));
  fs::remove(folder_ / "fleet.db");
  FleetDatabase tables(folder_ / "fleet.db", Database::Use::kWrite);
  EXPECT_EQ(tables.count("waiting"), 0);
  EXPECT_TRUE(tables.plan({job("b", "/b.bag")}).empty());
  EXPECT_EQ(FleetDatabase(folder_ / "fleet.db", Database::Use::kRead).count("waiting"), 1);
}

TEST_F(FleetDatabaseTest, isReadFromAFolderThatNobodyMayWriteTo) {
  {
    FleetDatabase tables(folder_ / "fleet.db", Database::Use::kWrite);
    tables.plan({job("a", "/a.bag")});
  }
  ::chmod((folder_ / "fleet.db").c_str(), 0444);
  ::chmod(folder_.c_str(), 0555);
  const pid_t child = ::fork();
  if (child == 0) {  // root may write anywhere: another user reads
    long waiting = -1;
    if (::geteuid() != 0 || ::setuid(65534) == 0) try {
        waiting = FleetDatabase(folder_ / "fleet.db", Database::Use::kRead).count("waiting");
      } catch (const InputError& e) {
        std::cerr << e.what() << std::endl;
      }
    ::_exit(waiting == 1 ? 0 : 1);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  fs::permissions(folder_, fs::perms::owner_all);
}

TEST_F(FleetDatabaseTest, tablesOfTheFirstSchemaAreReadAndCompleted) {
  {
    FleetDatabase tables(folder_ / "fleet.db", Database::Use::kWrite);
    tables.plan({job("a", "/a.bag")});
    tables.enter({resultOf("a")}, ResultsFolder(folder_));
    const Database old(folder_ / "fleet.db", Database::Use::kWrite);
    old.run(
        "ALTER TABLE jobs DROP COLUMN angular; ALTER TABLE sensors DROP COLUMN step_K; PRAGMA "
        "user_version=1");
  }
  const FleetDatabase read(folder_ / "fleet.db", Database::Use::kRead);
  ASSERT_EQ(read.records().size(), 1u);
  EXPECT_FALSE(read.records()[0].result.angular);
  EXPECT_TRUE(std::isnan(read.records()[0].result.sensors.at(0).step));
  FleetDatabase tables(folder_ / "fleet.db", Database::Use::kWrite);
  JobResult b = resultOf("b");
  b.angular = true;
  b.sensors[0].step = 0.125;
  tables.plan({job("b", "/b.bag")});
  tables.enter({b}, ResultsFolder(folder_));
  ASSERT_EQ(tables.records().size(), 2u);
  EXPECT_TRUE(tables.records()[1].result.angular);
  EXPECT_EQ(tables.records()[1].result.sensors.at(0).step, 0.125);
}

TEST_F(FleetDatabaseTest, onlyADamagedFileIsToBeRemoved) {
  const auto said = [&](const fs::path& file) {
    try {
      FleetDatabase(file, Database::Use::kRead).records();
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string("was read");
  };
  EXPECT_EQ(said(folder_ / "none.db").find("remove"), std::string::npos) << said(folder_ / "none.db");
  std::ofstream(folder_ / "fleet.db") << std::string(4096, 'x');
  EXPECT_NE(said(folder_ / "fleet.db").find("remove"), std::string::npos) << said(folder_ / "fleet.db");
}

TEST_F(FleetDatabaseTest, anotherFileIsRefusedByName) {
  std::ofstream(folder_ / "fleet.db")
      << "this is no database, however long it may be, and it is longer than a header "
         "of a hundred bytes, too";
  try {
    FleetDatabase(folder_ / "fleet.db", Database::Use::kRead).records();
    FAIL() << "was accepted";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("fleet.db"), std::string::npos);
  }
}

TEST(JobResultText, aForeignNameInAMessageIsReplaced) {
  JobResult r = MadeUpFleet(2, 1, 1).records[0].result;
  r.status = "failed";
  r.why = "geh\xE4use.csv: no contacts";
  EXPECT_EQ(parseResult(resultText(r), "r").why, "geh\uFFFDuse.csv: no contacts");
  FleetRecord failed{"m1", "2026-01-05", "/s.bag", "/model.yaml", r};
  EXPECT_NO_THROW(fleetJson(fleetOf({failed}, {}), true));
}

TEST(JobResultText, isReadBackToTheBit) {
  JobResult r = MadeUpFleet(2, 1, 1).records[0].result;
  r.why = "a \"quoted\"\nline";
  r.epoch = 1.25;
  const std::string text = resultText(r);
  EXPECT_EQ(resultText(parseResult(text, "r")), text);
  EXPECT_THROW(parseResult(text.substr(0, 100), "result.json"), InputError);
}

}  // namespace
}  // namespace mm
