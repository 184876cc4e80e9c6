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

TEST_F(MachineMeshes, TrianglesOfEveryFormatAreRead) {
  const std::vector<float> one = {0, 0, 0, 0.1F, 0, 0, 0, 0.2F, 0};
  EXPECT_EQ(meshTriangles(folder_.path("p/meshes/one.stl")), one);
  std::string binary(80, ' ');
  const std::uint32_t count = 1;
  const std::uint16_t attribute = 0;
  const float normal[3] = {0, 0, 1};
  binary.append(reinterpret_cast<const char*>(&count), 4);
  binary.append(reinterpret_cast<const char*>(normal), 12);
  binary.append(reinterpret_cast<const char*>(one.data()), 36);
  binary.append(reinterpret_cast<const char*>(&attribute), 2);
  write(folder_.path("binary.STL"), binary);
  EXPECT_EQ(meshTriangles(folder_.path("binary.STL")), one);
  write(folder_.path("square.obj"),
        "mtllib none.mtl\nv 0 0 0\nv 0.1 0 0\nv 0.1 0.2 0\nv 0 0.2 0\nf 1 2 3 4\n");
  EXPECT_EQ(meshTriangles(folder_.path("square.obj")).size(), 18u) << "two triangles";
  // a Collada file in millimetres whose z is up: as RViz, by its unit, and not turned
  write(folder_.path("mm.dae"),
        "<?xml version='1.0'?><COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>"
        "<asset><unit name='millimeter' meter='0.001'/><up_axis>Z_UP</up_axis></asset><library_geometries>"
        "<geometry id='g'><mesh><source id='s'><float_array id='f' count='9'>0 0 0 100 0 0 0 200 0"
        "</float_array><technique_common><accessor source='#f' count='3' stride='3'><param name='X' "
        "type='float'/><param name='Y' type='float'/><param name='Z' type='float'/></accessor>"
        "</technique_common></source><vertices id='v'><input semantic='POSITION' source='#s'/></vertices>"
        "<triangles count='1'><input semantic='VERTEX' source='#v' offset='0'/><p>0 1 2</p></triangles>"
        "</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id='w'><node id='n'>"
        "<instance_geometry url='#g'/></node></visual_scene></library_visual_scenes><scene>"
        "<instance_visual_scene url='#w'/></scene></COLLADA>");
  const std::vector<float> dae = meshTriangles(folder_.path("mm.dae"));
  ASSERT_EQ(dae.size(), 9u);
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(dae[i], one[i], 1e-6) << i;
}

TEST_F(MachineMeshes, WhatIsNoMeshIsRefusedInWords) {
  for (const std::string& text : {std::string(), std::string("root:x:0:0:root:/root:/bin/bash\n"),
                                  std::string(84, '\xff'), std::string("solid x\nfacet normal 0 0\n")}) {
    write(folder_.path("bad.stl"), text);
    EXPECT_NE(test::messageOf<InputError>([&] { meshTriangles(folder_.path("bad.stl")); }), "") << text;
  }
  write(folder_.path("large.stl"), "solid");
  std::filesystem::resize_file(folder_.path("large.stl"), 40u << 20);
  EXPECT_NE(
      test::messageOf<InputError>([&] { meshTriangles(folder_.path("large.stl")); }).find("at most 32 are"),
      std::string::npos);
}

TEST_F(MachineMeshes, TheDocumentHasEachWithItsTrianglesOrWhyNot) {
  EXPECT_EQ(meshesDocument("<robot name='m'/>", UrdfOrigin::kSent, packages()), "");
  std::string urdf = urdfWith("package://p/meshes/one.stl");
  urdf.insert(urdf.find("<visual>"), "<visual><geometry><mesh filename='/etc/passwd'/></geometry></visual>");
  const std::string document = meshesDocument(urdf, UrdfOrigin::kSent, packages());
  std::uint32_t size = 0;
  ASSERT_GT(document.size(), 4u);
  std::memcpy(&size, document.data(), 4);
  ASSERT_EQ(size % 4, 0u);
  const auto head = nlohmann::json::parse(document.substr(4, size));
  ASSERT_EQ(head["meshes"].size(), 2u);
  EXPECT_EQ(head["meshes"][0]["name"], "/etc/passwd");
  EXPECT_NE(head["meshes"][0]["why"].get<std::string>(), "");
  EXPECT_EQ(head["meshes"][1]["first"], 0);
  EXPECT_EQ(head["meshes"][1]["count"], 9);
  ASSERT_EQ(document.size(), 4u + size + 36u);
  float last[3];
  std::memcpy(last, document.data() + document.size() - 12, 12);
  EXPECT_EQ(last[1], 0.2F);
}

}  // namespace
}  // namespace mm
