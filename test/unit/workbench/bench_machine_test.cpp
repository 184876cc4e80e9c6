// What the page draws: the machine with its meshes, and a plan before it runs.
#include <cstring>
#include <fstream>

#include "base/read_file.h"
#include "bench_fixture.h"

namespace mm {
namespace {

using nlohmann::json;
using BenchMachineTest = test::BenchTest;

const char* const kFacet =
    "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.2 0\nendloop\n"
    "endfacet\nendsolid one\n";

std::string demoPlan() { return readWholeFile("config/demo_plan.yaml", ""); }

/// The list at the head of the document of meshes.
json meshesOf(const WebAnswer& answer) {
  const std::string& body = *answer.body;
  const auto size = static_cast<std::size_t>(static_cast<unsigned char>(body[0])) +
                    256u * static_cast<unsigned char>(body[1]);
  return json::parse(body.substr(4, size))["meshes"];
}

TEST_F(BenchMachineTest, APlanIsDrawnBeforeItRunsAndNothingMoves) {
  start(true);
  const json looked = act("look", {{"plan", demoPlan()}});
  ASSERT_TRUE(looked["ok"]) << looked;
  const json plan = data("plan");
  EXPECT_EQ(plan["text"], demoPlan());
  EXPECT_EQ(plan["measurements"], 120);
  EXPECT_EQ(machine_.orders, 0);
  EXPECT_EQ(machine_.stops, 0);
  const json refused = act("look", {{"plan", "artifact: /etc/passwd"}});
  EXPECT_FALSE(refused["ok"]);
  EXPECT_EQ(data("plan")["text"], demoPlan()) << "what was drawn stays until another is";
  EXPECT_EQ(bench_->get("/data/log").body->find("look"), std::string::npos) << "nobody did anything";
}

TEST_F(BenchMachineTest, APlanIsDrawnWhileAnotherRuns) {
  start(true);
  arm();
  machine_.runsUntilCancelled = true;
  ASSERT_EQ(bench_->post("/action/run", "", json{{"client", 1}, {"plan", demoPlan()}}.dump(), "t").status,
            202u);
  ASSERT_TRUE(machine_.waitForOrders(1));
  EXPECT_TRUE(act("look", {{"plan", demoPlan()}})["ok"]);
  EXPECT_TRUE(act("stop")["ok"]);
}

TEST_F(BenchMachineTest, ThePlanOfARecordedSessionIsDrawnOnItsMachine) {
  start();
  EXPECT_EQ(data("machine")["joints"].size(), 3u);
  EXPECT_TRUE(act("look", {{"plan", demoPlan()}})["ok"]);
}

TEST_F(BenchMachineTest, WhatWasDrawnOnAnotherMachineIsForgotten) {
  start();
  ASSERT_TRUE(act("look", {{"plan", demoPlan()}})["ok"]);
  ASSERT_TRUE(ended(bench_->post("/upload", "name=f.bag", "fresh points", "test"))["ok"]);
  EXPECT_EQ(data("plan")["text"], demoPlan()) << "of the same machine it stays";
  ASSERT_TRUE(ended(bench_->post("/upload", "name=m.bag", "mesh package://any/bed.stl", "test"))["ok"]);
  EXPECT_EQ(bench_->get("/data/plan").status, 404u);
}

TEST_F(BenchMachineTest, ALookThatIsRefusedSaysThatOthersWait) {
  start();
  std::string refused;
  for (int i = 0; i < 1000 && refused.empty(); ++i) {
    const WebAnswer answer = bench_->post("/action/look", "", json{{"plan", demoPlan()}}.dump(), "test");
    if (answer.status == 409) refused = json::parse(*answer.body)["message"];
  }
  EXPECT_EQ(refused, "4 others wait before 'look'; ask again in a moment");
}

TEST_F(BenchMachineTest, MeshesOfAPackageAreDrawnAndNoOtherFilesOfASession) {
  std::filesystem::create_directories(folder_.path("package"));
  std::ofstream(folder_.path("package/bed.stl")) << kFacet;
  std::ofstream(folder_.path("secret.stl")) << kFacet;
  start();
  EXPECT_EQ(bench_->get("/data/meshes").status, 404u) << "the URDF names none";
  const auto sent = [&](const std::string& mesh) {
    const json opened = ended(bench_->post("/upload", "name=m.bag", "mesh " + mesh, "test"));
    EXPECT_TRUE(opened["ok"]) << opened;
    const WebAnswer answer = bench_->get("/data/meshes");
    EXPECT_EQ(answer.type, "application/octet-stream");
    return meshesOf(answer)[0];
  };
  EXPECT_EQ(sent("package://any/bed.stl")["count"], std::strlen(kFacet));
  for (const std::string& path :
       {folder_.path("secret.stl").string(), "file://" + folder_.path("secret.stl").string(),
        std::string("package://any/../secret.stl")}) {
    const json refused = sent(path);
    EXPECT_FALSE(refused.contains("count")) << refused;
    EXPECT_NE(refused["why"].get<std::string>(), "");
  }
  for (const char* path : {"/data/bed.stl", "/data/meshes/bed.stl", "/data/package://any/bed.stl", "/mesh/0"})
    EXPECT_EQ(bench_->get(path).status, 404u) << path;
}

}  // namespace
}  // namespace mm
