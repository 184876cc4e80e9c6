#include <filesystem>

#include "bench_fixture.h"

namespace mm {
namespace {

using nlohmann::json;
using test::BenchTest;

class BenchImportTest : public BenchTest {
 protected:
  json send(const std::string& name, const std::string& content) {
    return ended(bench_->post("/upload", "name=" + name + "&who=Ada", content, "test"));
  }
  /// The preview of the file that was sent, as it was asked for.
  json look(json wish = json::object()) {
    wish["file"] = data("import")["number"];
    wish["asked"] = ++asked_;
    if (!wish.contains("session")) wish["session"] = session();
    const json end = act("preview", wish);
    EXPECT_TRUE(end["ok"]) << end;
    const json found = data("preview");
    EXPECT_EQ(found["asked_by"], asked_);
    return found;
  }
  json import(json wish) {
    if (!wish.contains("file")) wish["file"] = data("import")["number"];
    if (!wish.contains("session")) wish["session"] = session();
    return act("import", wish);
  }
  /// Number of the document of the session in hand; 0: there is none.
  std::uint64_t session() { return live()["documents"].value("session", std::uint64_t{0}); }
  std::string said(const json& end) const { return end["message"].get<std::string>(); }
  /// A grid of references within the travels of three_axis.
  static std::string positions() {
    std::string csv = "time_s,x_mm,y_mm,z_mm,reference_x_mm,reference_y_mm,reference_z_mm\n";
    for (int i = 0; i < 27; ++i) {
      const std::string place = std::to_string(5 * (i % 3)) + "," + std::to_string(5 * (i / 3 % 3)) + "," +
                                std::to_string(5 * (i / 9));
      csv += std::to_string(10 * i) + "," + place + "," + place + "\n";
    }
    return csv;
  }

 private:
  std::uint64_t asked_ = 40;
};

TEST_F(BenchImportTest, AFileIsLookedAtThenWrittenThenOpened) {
  bag_.clear();
  start();
  EXPECT_TRUE(data("session").is_null());
  ASSERT_TRUE(send("interferometer.csv", test::readAll("examples/import/iso230_2_x.csv"))["ok"]);
  EXPECT_TRUE(data("preview").is_null());
  EXPECT_TRUE(data("session").is_null()) << "it was opened before anybody had looked";
  EXPECT_EQ(data("import")["output"], "interferometer.bag");

  const json found = look({{"machine", "three_axis"}});
  EXPECT_EQ(found["format"], "iso230-2");
  EXPECT_EQ(found["columns"][1]["meaning"], "run 1, upwards");
  EXPECT_EQ(found["rows"][0][0], "-18,000");
  EXPECT_TRUE(found["faults"].empty());
  EXPECT_TRUE(written_.empty()) << "a preview wrote";

  const json done =
      import({{"machine", "three_axis"}, {"output", "interferometer.bag"}, {"compensation", "none"}});
  ASSERT_TRUE(done["ok"]) << done;
  EXPECT_TRUE(std::filesystem::exists(folder_.path("interferometer.bag")));
  EXPECT_EQ(written_.at("interferometer.bag").compensation.inWords(), "none");
  EXPECT_EQ(data("session")["name"], "interferometer.bag");
  EXPECT_EQ(data("points")["rows"], 70);
  EXPECT_NE(data("log").dump().find("Ada (test)"), std::string::npos);
}

TEST_F(BenchImportTest, MachineAndArtifactOfTheOpenSessionOrSent) {
  start();
  ASSERT_TRUE(send("t.csv", positions())["ok"]);
  EXPECT_TRUE(look()["faults"].empty()) << "the machine in hand";
  json done = import({{"output", "t.bag"}, {"artifact_from", "session"}});
  ASSERT_TRUE(done["ok"]) << done;
  EXPECT_EQ(data("points")["rows"], 81);
  EXPECT_EQ(written_.at("t.bag").artifact.name, test::plate().artifact.name);

  ASSERT_TRUE(send("plate.csv", test::readAll("examples/tutorials/plate_contacts.csv"))["ok"]);
  EXPECT_NE(look()["faults"][0].get<std::string>().find("plate.csv:2: the file names features"),
            std::string::npos);
  const json sent = look({{"artifact", test::readAll("examples/tutorials/plate.yaml")},
                          {"machine", "mill.urdf"},
                          {"urdf", test::plate().machine.urdf()}});
  EXPECT_TRUE(sent["faults"].empty()) << sent["faults"];
  EXPECT_EQ(sent["machine"], "mill");
  EXPECT_FALSE(sent["questions"].empty()) << "the plate is larger than this machine";
}

TEST_F(BenchImportTest, AnAnswerIsALineOfTheMapping) {
  start();
  ASSERT_TRUE(send("e.txt", "Zeit [s];X [mm];Error X [um]\n0;1;1,5\n1;2;2,5\n")["ok"]);
  const json asked = look();
  ASSERT_EQ(asked["asked"].size(), 1u);
  EXPECT_EQ(asked["asked"][0]["column"], "Error X [um]");
  EXPECT_EQ(asked["keys"], json::parse(R"(["Zeit [s]", "X [mm]", "Error X [um]"])"));
  const json early = import({{"output", "e.bag"}});
  EXPECT_FALSE(early["ok"]);
  EXPECT_NE(said(early).find("e.txt:1: column 'Error X [um]'"), std::string::npos) << early;
  EXPECT_TRUE(written_.empty());
  EXPECT_TRUE(look({{"mapping", "columns: {\"Error X [um]\": \"error_x_um\"}\n"}})["faults"].empty());
}

TEST_F(BenchImportTest, TheBagHasAPlainNameThatIsFree) {
  start();
  ASSERT_TRUE(send("t.csv", positions())["ok"]);
  for (const char* name : {"../t.bag", "/tmp/t.bag", "a/b.bag", "..\\t.bag", ".t.bag", ".bag", "", "t.csv",
                           "a:b.bag", "t.bag\n"}) {
    const json end = import({{"output", name}});
    EXPECT_FALSE(end["ok"]) << name;
    EXPECT_NE(said(end).find("is not a plain name that ends in .bag"), std::string::npos) << end;
  }
  folder_.write("t.bag", "somebody's");
  EXPECT_NE(said(import({{"output", "t.bag"}})).find("exists already"), std::string::npos);
  EXPECT_EQ(test::readAll(folder_.path("t.bag")), "somebody's");
  std::filesystem::create_symlink(folder_.path("nowhere"), folder_.path("link.bag"));
  EXPECT_NE(said(import({{"output", "link.bag"}})).find("exists already"), std::string::npos);
  EXPECT_TRUE(written_.empty());
  ASSERT_TRUE(send("..%2F..%2Fetc%2Ft.csv", positions())["ok"]);
  EXPECT_EQ(data("import")["name"], "t.csv");
  EXPECT_EQ(data("import")["output"], "t_2.bag");
}

TEST_F(BenchImportTest, NoFileThatAPageNamesIsOpened) {
  start();
  ASSERT_TRUE(send("t.csv", positions())["ok"]);
  const json number = data("import")["number"];
  for (const char* machine : {"/etc/passwd", "config/machine.urdf", "x.urdf", "../three_axis"}) {
    const json end = act("preview", {{"file", number}, {"machine", machine}});
    EXPECT_FALSE(end["ok"]);
    EXPECT_NE(said(end).find("is a file"), std::string::npos) << end;
  }
  EXPECT_FALSE(act(
      "preview",
      {{"file", number}, {"machine", "three_axis"}, {"artifact", "examples/tutorials/plate.yaml"}})["ok"]);
  const json mapping = look({{"mapping", "/etc/passwd"}});
  EXPECT_EQ(mapping["faults"][0].get<std::string>().find("mapping:1:"), 0u) << mapping["faults"];
  EXPECT_FALSE(act("preview", {{"file", number}, {"machine", "three_axis"}, {"compensation", "/etc"}})["ok"]);
}

TEST_F(BenchImportTest, WhatIsNoTextOrTooLargeIsRefused) {
  start();
  EXPECT_FALSE(act("preview", {{"file", 1}})["ok"]) << "there is no file";
  EXPECT_EQ(bench_->post("/upload", "name=t.xlsx", "PK\x03\x04", "test").status, 415u);
  EXPECT_EQ(bench_->post("/upload", "name=t.csv", "", "test").status, 400u);
  const json workbook = send("t.csv", "PK\x03\x04 sheet");
  EXPECT_FALSE(workbook["ok"]);
  EXPECT_NE(said(workbook).find("t.csv: is a workbook"), std::string::npos) << workbook;
  const WebAnswer large = bench_->post("/upload", "name=t.csv", std::string((64u << 20) + 1, '1'), "test");
  EXPECT_EQ(large.status, 413u);
  EXPECT_NE(large.body->find("64 MB"), std::string::npos);
  EXPECT_TRUE(data("import").is_null()) << "something was kept of them";
}

TEST_F(BenchImportTest, AnotherSessionsMachineIsNotTakenForTheOneThatWasSeen) {
  start();
  ASSERT_TRUE(send("t.csv", positions())["ok"]);
  const std::uint64_t seen = session();
  EXPECT_TRUE(look()["faults"].empty());
  ASSERT_TRUE(ended(bench_->post("/upload", "name=f.bag", "fresh points", "test"))["ok"]);
  ASSERT_NE(session(), seen);
  for (const json& wish :
       {json{{"output", "t.bag"}, {"session", seen}}, json{{"output", "t.bag"},
                                                           {"session", seen},
                                                           {"machine", "three_axis"},
                                                           {"artifact_from", "session"}}}) {
    const json end = import(wish);
    EXPECT_FALSE(end["ok"]) << wish;
    EXPECT_EQ(said(end), "another session was opened meanwhile; look again");
  }
  EXPECT_TRUE(written_.empty());
  EXPECT_TRUE(import({{"output", "t.bag"}, {"session", seen}, {"machine", "three_axis"}})["ok"])
      << "nothing of the session is taken";
}

TEST_F(BenchImportTest, AfterAnImportAnotherNameIsProposed) {
  start();
  ASSERT_TRUE(send("t.csv", positions())["ok"]);
  const json number = data("import")["number"];
  ASSERT_TRUE(import({{"output", "t.bag"}})["ok"]);
  EXPECT_EQ(data("import")["output"], "t_2.bag");
  EXPECT_EQ(data("import")["number"], number) << "it is the same file";
}

TEST_F(BenchImportTest, WhoCancelsWhileTheBagIsOpenedIsToldThatItIsWritten) {
  start();
  ASSERT_TRUE(send("t.csv", positions())["ok"]);
  cancelsOpening_ = true;
  const json end = import({{"output", "t.bag"}});
  EXPECT_FALSE(end["ok"]);
  EXPECT_NE(said(end).find("t.bag is written; cancelled while it was opened"), std::string::npos) << end;
  EXPECT_EQ(data("import")["output"], "t_2.bag");
}

TEST_F(BenchImportTest, AnotherPagesFileIsNotTakenForOnesOwn) {
  start();
  ASSERT_TRUE(send("a.csv", positions())["ok"]);
  const json mine = data("import")["number"];
  ASSERT_TRUE(send("b.csv", "x_mm\n1\n")["ok"]);
  const json end = import({{"file", mine}, {"output", "a.bag"}});
  EXPECT_FALSE(end["ok"]);
  EXPECT_NE(said(end).find("another file was sent meanwhile, b.csv"), std::string::npos) << end;
}

}  // namespace
}  // namespace mm
