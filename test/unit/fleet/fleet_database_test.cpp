#include "fleet/fleet_database.h"

#include <gtest/gtest.h>

#include <fstream>

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
