#include "workbench/machine_meshes.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "session_files.h"

namespace mm {
namespace {

const char* const kStl =
    "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.2 0\nendloop\n"
    "endfacet\nendsolid one\n";

void write(const std::string& file, const std::string& text) {
  std::filesystem::create_directories(std::filesystem::path(file).parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

std::string urdfWith(const std::string& mesh) {
  return "<robot name='m'><link name='a'><collision><geometry><mesh filename='package://p/none.stl'/>"
         "</geometry></collision><visual><geometry><mesh filename='" +
         mesh + "' scale='1 1 1'/></geometry></visual><visual><geometry><mesh filename='" + mesh +
         "'/></geometry></visual></link></robot>";
}

/// The list at the head of a document.
nlohmann::json headOf(const std::string& document) {
  std::uint32_t size = 0;
  std::memcpy(&size, document.data(), 4);
  return nlohmann::json::parse(document.substr(4, size))["meshes"];
}

class MachineMeshes : public ::testing::Test {
 protected:
  test::Folder folder_;
  void SetUp() override { write(folder_.path("p/meshes/one.stl"), kStl); }
  PackageFolder packages() const {
    return [this](const std::string& name) {
      return name == "p" ? std::filesystem::path(folder_.path("p")) : std::filesystem::path();
    };
  }
  std::string refusal(const std::string& name, UrdfOrigin origin = UrdfOrigin::kThisComputer) const {
    return test::messageOf<InputError>([&] { meshFile(name, origin, packages()); });
  }
};

TEST_F(MachineMeshes, ThoseOfTheVisualsAreNamedOnce) {
  EXPECT_EQ(meshNames(urdfWith("package://p/a.stl")), std::vector<std::string>{"package://p/a.stl"});
  EXPECT_TRUE(meshNames("<robot name='m'><link name='a'/></robot>").empty());
  EXPECT_TRUE(meshNames("no XML").empty());
}

TEST_F(MachineMeshes, APackagesFileIsFoundAndNothingOutsideIt) {
  for (const UrdfOrigin origin : {UrdfOrigin::kThisComputer, UrdfOrigin::kSent})
    EXPECT_EQ(meshFile("package://p/meshes/one.stl", origin, packages()),
              std::filesystem::canonical(folder_.path("p/meshes/one.stl")));
  write(folder_.path("secret.stl"), kStl);
  std::filesystem::create_symlink(folder_.path("secret.stl"), folder_.path("p/link.stl"));
  for (const char* name : {"package://p/../secret.stl", "package://p/meshes/../../secret.stl",
                           "package://p//../secret.stl", "package://p/link.stl"})
    EXPECT_NE(refusal(name).find("out of the folder"), std::string::npos) << name << ": " << refusal(name);
  EXPECT_NE(refusal("package://p//" + folder_.path("secret.stl").string()), "");
  EXPECT_NE(refusal("package://q/one.stl").find("no package 'q'"), std::string::npos);
  EXPECT_NE(refusal("package://p").find("names no file"), std::string::npos);
  EXPECT_NE(refusal("package:///meshes/one.stl").find("names no file"), std::string::npos);
  EXPECT_NE(refusal("package://p/meshes/none.stl"), "");
  EXPECT_NE(refusal("package://p/meshes").find("not a supported mesh"), std::string::npos);
  EXPECT_NE(test::messageOf<InputError>([&] { meshFile("package://p/a.stl", UrdfOrigin::kSent, {}); }), "");
}

TEST_F(MachineMeshes, APathIsOpenedForThisComputersUrdfAlone) {
  const std::string file = folder_.path("p/meshes/one.stl");
  for (const std::string& name : {file, "file://" + file}) {
    EXPECT_EQ(meshFile(name, UrdfOrigin::kThisComputer, packages()), std::filesystem::canonical(file));
    EXPECT_NE(refusal(name, UrdfOrigin::kSent).find("uploaded"), std::string::npos);
  }
  EXPECT_NE(refusal("/etc/passwd").find("not a supported mesh"), std::string::npos);
  EXPECT_NE(refusal("meshes/one.stl").find("neither"), std::string::npos);
  EXPECT_NE(refusal("http://elsewhere/one.stl").find("neither"), std::string::npos);
  EXPECT_NE(refusal(""), "");
  ASSERT_EQ(::mkfifo(folder_.path("pipe.stl").c_str(), 0600), 0);  // would never be read to its end
  EXPECT_NE(refusal(folder_.path("pipe.stl")).find("is not a file"), std::string::npos);
}

TEST_F(MachineMeshes, TheBytesOfAFileAreAsTheyAreAndNotTooMany) {
  EXPECT_EQ(meshBytes(folder_.path("p/meshes/one.stl")), kStl);
  EXPECT_NE(test::messageOf<InputError>([&] { meshBytes(folder_.path("none.stl")); }), "");
  write(folder_.path("large.stl"), "solid");
  std::filesystem::resize_file(folder_.path("large.stl"), 40u << 20);
  EXPECT_NE(test::messageOf<InputError>([&] { meshBytes(folder_.path("large.stl")); }).find("at most 16 are"),
            std::string::npos);
  write(folder_.path("large.obj"), "v 0 0 0");  // text holds the page up longer
  std::filesystem::resize_file(folder_.path("large.obj"), 3u << 20);
  EXPECT_NE(test::messageOf<InputError>([&] { meshBytes(folder_.path("large.obj")); }).find("binary STL"),
            std::string::npos);
}

TEST_F(MachineMeshes, AllTogetherAreNotTooMany) {
  std::string urdf = "<robot name='m'><link name='a'>";
  for (const char* name : {"a.stl", "b.OBJ", "c.stl"}) {
    write(folder_.path("p") / name, "solid");
    std::filesystem::resize_file(folder_.path("p") / name, (name[0] == 'b' ? 1u : 10u) << 20);
    urdf += std::string("<visual><geometry><mesh filename='package://p/") + name + "'/></geometry></visual>";
  }
  const auto meshes = headOf(meshesDocument(urdf + "</link></robot>", UrdfOrigin::kSent, packages()));
  EXPECT_EQ(meshes[0]["kind"], ".stl");
  EXPECT_EQ(meshes[1]["kind"], ".obj");
  EXPECT_EQ(meshes[1]["first"], 10u << 20);
  EXPECT_NE(meshes[2]["why"].get<std::string>().find("at most 16 MB"), std::string::npos) << meshes[2];
}

TEST_F(MachineMeshes, TheDocumentHasEachWithItsTrianglesOrWhyNot) {
  EXPECT_EQ(meshesDocument("<robot name='m'/>", UrdfOrigin::kSent, packages()), "");
  std::string urdf = urdfWith("package://p/meshes/one.stl");
  urdf.insert(urdf.find("<visual>"), "<visual><geometry><mesh filename='/etc/passwd'/></geometry></visual>");
  const std::string document = meshesDocument(urdf, UrdfOrigin::kSent, packages());
  const auto meshes = headOf(document);
  ASSERT_EQ(meshes.size(), 2u);
  EXPECT_EQ(meshes[0]["name"], "/etc/passwd");
  EXPECT_NE(meshes[0]["why"].get<std::string>(), "");
  EXPECT_EQ(meshes[1]["kind"], ".stl");
  EXPECT_EQ(meshes[1]["first"], 0);
  EXPECT_EQ(meshes[1]["count"], std::strlen(kStl));
  EXPECT_EQ(document.substr(document.size() - std::strlen(kStl)), kStl);
  EXPECT_EQ(document.find("root:"), std::string::npos) << "of /etc/passwd";
}

}  // namespace
}  // namespace mm
