#include "workbench/bench.h"

#include <cstdlib>

#include "base/temporary_folder.h"
#include "bench_fixture.h"

namespace mm {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using test::BenchTest, test::named, test::plate, test::withSerial;

TEST_F(BenchTest, TheWholeLoop) {
  start();
  const double before = data("compare")["rms_um"];
  EXPECT_GT(before, 0.7);
  const json points = data("points");
  EXPECT_EQ(points["rows"], plate().observations.size());
  for (const json& column : points["columns"])
    EXPECT_EQ(column["values"].size(), points["rows"]) << column["name"];

  const json diagnosed = act("diagnose");
  ASSERT_TRUE(diagnosed["ok"]) << diagnosed;
  EXPECT_NE(diagnosed["message"].get<std::string>().find("backlash of x"), std::string::npos);
  const json missing = data("diagnosis")["missing"];
  ASSERT_EQ(missing.size(), 1u);
  EXPECT_EQ(missing[0]["effect"]["type"], "backlash");

  const json added = act("add", {{"effect", "{type: backlash, axis: x}"}, {"who", "Ada"}});
  ASSERT_TRUE(added["ok"]) << added;
  EXPECT_LT(data("compare")["rms_um"].get<double>(), 0.5 * before);
  const json calibration = data("calibration");
  EXPECT_TRUE(calibration["kept"]);
  ASSERT_EQ(calibration["effects"].size(), 1u);
  EXPECT_NEAR(std::abs(calibration["effects"][0]["values"][0]["value"].get<double>()), 3.0, 0.2);
  EXPECT_GT(calibration["effects"][0]["values"][0]["std"].get<double>(), 0.0);
  EXPECT_EQ(calibration["ledger"].size(), 2u);
  EXPECT_TRUE(data("diagnosis").is_null()) << "a diagnosis of another model stayed";
  EXPECT_EQ(data("points")["before"].size(), points["rows"]);

  const std::string id = calibration["id"];
  EXPECT_EQ(act("promote", {{"id", id}})["message"], id + " is active");
  EXPECT_TRUE(data("history")["calibrations"][0]["active"]);
  EXPECT_EQ(data("correct")["active"]["id"], id);
  EXPECT_GT(data("correct")["active"]["at_mm"].size(), 100u);
  const json own = act("verify");
  EXPECT_FALSE(own["ok"]) << own;
  EXPECT_NE(own["message"].get<std::string>().find("fitted to this session"), std::string::npos) << own;
  ASSERT_TRUE(ended(bench_->post("/upload", "name=fresh.bag", "fresh points", "test"))["ok"]);
  const json verified = act("verify");
  ASSERT_TRUE(verified["ok"]) << verified;
  EXPECT_EQ(verified["message"], data("verify")["in_words"]);
  EXPECT_EQ(act("promote", {{"id", id}})["message"], id + " is active");
  EXPECT_TRUE(data("verify").is_null()) << "what was said of another active calibration stayed";

  const json removed = act("remove", {{"effect", "{type: backlash, axis: x}"}});
  ASSERT_TRUE(removed["ok"]) << removed;
  EXPECT_NEAR(data("compare")["rms_um"].get<double>(), before, 0.01);
  EXPECT_TRUE(act("use", {{"id", id}})["ok"]);
  EXPECT_LT(data("compare")["rms_um"].get<double>(), 0.5 * before);

  const json log = data("log")["lines"];
  bool ada = false;
  for (const json& line : log)
    ada = ada || (line["who"] == "Ada (test)" && line["what"].get<std::string>().find("add: ") == 0);
  EXPECT_TRUE(ada) << log;
  bench_.reset();
  EXPECT_NE(test::readAll(folder_.path("store") / "workbench.log").find("Ada (test)"), std::string::npos);
}

TEST_F(BenchTest, RefusalsAreTheServicesWords) {
  start();
  EXPECT_NE(
      act("add", {{"effect", "{type: backlsh, axis: x}"}})["message"].get<std::string>().find("backlash"),
      std::string::npos);
  EXPECT_FALSE(act("remove", {{"effect", "{type: backlash, axis: x}"}})["ok"]);
  EXPECT_FALSE(act("use", {{"id", "../../etc/passwd"}})["ok"]);
  EXPECT_FALSE(act("promote", {{"id", "nosuch"}})["ok"]);
  EXPECT_NE(act("verify")["message"].get<std::string>().find("no calibration is active"), std::string::npos);
  EXPECT_FALSE(act("calibrate", {{"model", "effects: [{type: nothing}]"}})["ok"]);
  EXPECT_FALSE(act("fly")["ok"]);
  EXPECT_THROW(bench_->post("/action/add", "", "{\"efect\": \"x\"}", "test"), InputError);
  EXPECT_EQ(bench_->get("/data/../../etc/passwd").status, 404u);
  EXPECT_EQ(bench_->get("/app/nosuch.js").status, 404u);
  EXPECT_EQ(bench_->post("/upload", "name=x.exe", "abc", "test").status, 415u);
  const json opened = ended(bench_->post("/upload", "name=other.bag", "no bag", "test"));
  EXPECT_FALSE(opened["ok"]);
  EXPECT_NE(opened["message"].get<std::string>().find("is not a bag"), std::string::npos);
  EXPECT_EQ(data("session")["name"], "plate.bag") << "a bag that cannot be read took the session's place";
  EXPECT_TRUE(data("history")["calibrations"].empty()) << "something was written";
}

TEST_F(BenchTest, FormulasAreJudgedAsTheyAreTyped) {
  start();
  const auto judged = [&](const json& body) {
    return json::parse(*bench_->post("/formula", "", body.dump(), "test").body);
  };
  EXPECT_TRUE(judged({{"direction", "x"}, {"formula", "k1*x*y"}})["ok"]);
  for (const char* bad : {"k1*", "k1*nosuch", "x*y", "k1*x)", "((((", "", "k1*x/0*0 +"})
    EXPECT_FALSE(judged({{"direction", "x"}, {"formula", bad}})["ok"]) << bad;
  EXPECT_FALSE(judged({{"direction", "q"}, {"formula", "k1*x"}})["ok"]);
  EXPECT_FALSE(judged({{"direction", "x"}, {"formula", "k1*" + std::string(100000, '(') + "x"}})["ok"]);
  EXPECT_FALSE(judged(
      {{"direction", "x"}, {"formula", std::string(250, '(') + "k1*x" + std::string(240, ')')}})["ok"]);
  const json effect = judged({{"direction", "x"}, {"formula", "k1*sin(2*pi*x/k2)"}, {"start", "1, 5"}});
  EXPECT_TRUE(effect["ok"]) << effect;
  EXPECT_NE(effect["effect"].get<std::string>().find("start: [1, 5]"), std::string::npos) << effect;
}

TEST_F(BenchTest, StatesComeThirtyTimesASecondWhileItMoves) {
  start(true);
  machine_.moving = true;
  EXPECT_LE(bench_->period(), 34ms);
  machine_.moving = false;
  EXPECT_EQ(bench_->period(), 500ms);
  EXPECT_EQ(live()["documents"]["contacts"], plate().observations.size());
  EXPECT_EQ(data("contacts")["at_mm"], json::parse("[[1.0,2.0,3.0]]"));
  const auto first = bench_->get("/data/contacts").body;
  EXPECT_EQ(bench_->get("/data/contacts").body, first) << "written again for every page that asks";
  machine_.touched.emplace_back(4e-3, 5e-3, 6e-3);
  EXPECT_EQ(data("contacts")["at_mm"], json::parse("[[1.0,2.0,3.0],[4.0,5.0,6.0]]"));
  machine_.touched = {Eigen::Vector3d(7e-3, 8e-3, 9e-3),
                      Eigen::Vector3d(4e-3, 5e-3, 6e-3)};  // another session
  EXPECT_EQ(data("contacts")["at_mm"], json::parse("[[7.0,8.0,9.0],[4.0,5.0,6.0]]"));
  machine_.touched.clear();
  EXPECT_EQ(data("contacts")["at_mm"], json::array());
  EXPECT_EQ(live()["machine"]["readings"], json::parse("[1.0,2.0,3.0]"));
}

TEST_F(BenchTest, ItsMachineMayHaveAnyName) {
  session_ = [] { return named("mymill"); };
  start();
  const json added = act("add", {{"effect", "{type: backlash, axis: x}"}});
  ASSERT_TRUE(added["ok"]) << added;
  const json again = act("calibrate", {{"method", "least_squares"}});
  EXPECT_TRUE(again["ok"]) << again;
  EXPECT_EQ(data("calibration")["effects"].size(), 1u);
  EXPECT_EQ(data("calibration")["machine"], "mymill");
}

TEST_F(BenchTest, NoFileThatAPageNamesIsOpened) {
  start(true);
  for (const char* machine : {"/etc/passwd", "config/machine.urdf", "x.urdf"}) {
    const json end = act("calibrate", {{"model", "machine: " + std::string(machine) + "\neffects: []"}});
    EXPECT_NE(end["message"].get<std::string>().find("' is a file;"), std::string::npos) << end;
  }
  EXPECT_TRUE(act("calibrate", {{"model", "machine: three_axis\neffects: []"}})["ok"]);
  arm();
  const auto run = [&](const std::string& plan) {
    return act("run", {{"client", 1}, {"plan", plan}})["message"];
  };
  EXPECT_NE(run("config/demo_plan.yaml").get<std::string>().find("paths are not opened"), std::string::npos);
  EXPECT_NE(
      run("artifact: /etc/passwd").get<std::string>().find("plan:1: the artifact is '/etc/passwd', a file"),
      std::string::npos);
  EXPECT_NE(run(" \n").get<std::string>().find("no plan was sent"), std::string::npos);
  EXPECT_EQ(machine_.orders, 0);
  EXPECT_EQ(run("name: p").get<std::string>().find("measured name: p\n"), 0u)
      << "a line is a text, not a path";
}

TEST_F(BenchTest, ANameOfAFileMayBeLong) {
  start();
  for (const std::string& name :
       {std::string(60, 'a') + ".bag", std::string("FRESH.BAG"), std::string(200, 'b') + ".Bag"}) {
    const json opened = ended(bench_->post("/upload", "name=" + name + "&who=Ada", "fresh points", "test"));
    EXPECT_TRUE(opened["ok"]) << opened;
  }
  EXPECT_EQ(data("session")["name"], "…" + std::string(116, 'b') + ".Bag");
  EXPECT_EQ(bench_->post("/upload", "name=bag", "x", "test").status, 415u);
  EXPECT_NE(data("log").dump().find("Ada (test)"), std::string::npos);
}

TEST_F(BenchTest, WithoutAFolderNamedEachMachineHasItsOwn) {
  ::setenv("MM_CALIBRATIONS", folder_.path("all").c_str(), 1);
  store_.clear();
  session_ = [] { return withSerial("A7"); };
  start();
  EXPECT_EQ(data("history")["store"], (folder_.path("all") / "A7").string());
  const json opened = ended(bench_->post("/upload", "name=b.bag", "serial B8", "test"));
  ASSERT_TRUE(opened["ok"]) << opened;
  EXPECT_EQ(data("history")["store"], (folder_.path("all") / "B8").string());
  ASSERT_TRUE(act("add", {{"effect", "{type: backlash, axis: x}"}})["ok"]);
  bench_.reset();
  ::unsetenv("MM_CALIBRATIONS");
  EXPECT_NE(test::readAll(folder_.path("all") / "A7" / "workbench.log").find("plate.bag"), std::string::npos);
  const std::string log = test::readAll(folder_.path("all") / "B8" / "workbench.log");
  EXPECT_NE(log.find("b.bag: "), std::string::npos) << log;
  EXPECT_NE(log.find("add: "), std::string::npos) << log;
}

TEST_F(BenchTest, AnExportIsOneFileThatIsUnpacked) {
  start();
  EXPECT_GT(data("catalogue")["controllers"].size(), 5u);
  ASSERT_TRUE(act("add", {{"effect", "{type: backlash, axis: x}"}})["ok"]);
  EXPECT_FALSE(act("export", {{"controller", "../../etc"}})["ok"]);
  EXPECT_EQ(bench_->get("/download/export").status, 404u);
  const json done = act("export", {{"controller", "linuxcnc"}});
  ASSERT_TRUE(done["ok"]) << done;
  const WebAnswer sent = bench_->get("/download/export");
  ASSERT_EQ(sent.status, 200u);
  const std::string id = data("calibration")["id"];
  EXPECT_EQ(sent.fileName, id + "_linuxcnc.zip");
  constexpr std::size_t kEnd = 22;  // bytes of the record that ends an archive
  EXPECT_EQ(sent.body->substr(sent.body->size() - kEnd, 4), "PK\5\6") << "something stands behind the end";
  const auto zip = folder_.write("sent.zip", *sent.body);
  ASSERT_EQ(std::system(("python3 -m zipfile -e " + zip.string() + " " + folder_.path("").string()).c_str()),
            0);
  const std::filesystem::path folder = folder_.path(id + "_linuxcnc");
  EXPECT_NE(test::readAll(folder / "README.md").find("LinuxCNC"), std::string::npos);
  EXPECT_EQ(json::parse(test::readAll(folder / "representability.json"))["target"], "linuxcnc");
  ASSERT_TRUE(act("remove", {{"effect", "{type: backlash, axis: x}"}})["ok"]);
  EXPECT_EQ(bench_->get("/download/export").status, 404u) << "an export of another calibration stayed";
}

TEST_F(BenchTest, WhatIsShownIsOfTheModelThatIsThere) {
  start();
  const json all = act("add_all");
  ASSERT_TRUE(all["ok"]) << all;
  ASSERT_FALSE(data("diagnosis").is_null()) << "the last diagnosis of add all is lost";
  EXPECT_EQ(data("diagnosis")["sentence"], all["message"]);
  const bool moves = !data("diagnosis")["next_measurement"].empty();
  EXPECT_EQ(bench_->get("/data/moves").status == 200, moves);
  ASSERT_TRUE(act("use", {{"id", data("calibration")["id"]}})["ok"]);
  EXPECT_TRUE(data("diagnosis").is_null());
  ASSERT_TRUE(act("report")["ok"]);
  EXPECT_EQ(bench_->get("/data/moves").status == 200, !data("diagnosis")["next_measurement"].empty());
}

TEST_F(BenchTest, ThePageNamesNoOtherSite) {
  start();
  const WebAnswer page = bench_->get("/");
  EXPECT_EQ(page.body->find("https://"), std::string::npos);
  EXPECT_NE(page.policy.find("frame-ancestors 'none'"), std::string::npos);
  EXPECT_NE(page.body->find("/t/secret/app/main.js"), std::string::npos);
  EXPECT_EQ(page.body->find("{{"), std::string::npos);
  EXPECT_EQ(bench_->get("/app/main.js").status, 200u);
  EXPECT_EQ(bench_->get("/lib/three.core.js").status, 200u);
}

TEST(TemporaryFolder, GoesWithItsOwner) {
  std::filesystem::path path;
  {
    const TemporaryFolder folder;
    folder.write("sent.bag", "content");
    path = folder.path();
    EXPECT_EQ(test::readAll(path / "sent.bag"), "content");
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace mm
