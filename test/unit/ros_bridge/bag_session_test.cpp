#include "ros_bridge/bag_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/Temperature.h>
#include <std_msgs/String.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <cmath>
#include <csignal>
#include <random>

#include "base/error.h"
#include "read_contacts.h"
#include "ros_bridge/message_conversion.h"
#include "ros_bridge/session_collector.h"
#include "session/artifact_file.h"
#include "session/session_hash.h"
#include "session_files.h"

namespace mm {
namespace {

using test::Folder;
using ::testing::AllOf;
using ::testing::HasSubstr;

const char* const kPlate = R"(name: plate
pose: free
probe: {tip_radius_mm: 1.0, repeatability_um: 0.3}
expansion_per_K: 11.5e-6
temperature_sensor: bed
balls:
  - {name: b0, centre_mm: [-16.0, -11.0, -5.1], radius_mm: 3.9685, radius_std_um: 0.1, centre_std_um: 0.2}
  - {name: b1, centre_mm: [16.0, 11.0, 5.1], radius_mm: 3.9685, centre: free}
points:
  - {name: target, position_mm: [1, 2, 3], position: free}
)";

/// Rows out of order, equal times, empty cells, a row that only logs, every kind: whatever a CSV can hold.
const char* const kContacts =
    "time_s,feature,x_mm,z_mm,y_mm,x_velocity_mm_s,bed_degC,humidity_percent,deviation_x_um,deviation_x_std_"
    "um,"
    "reference_y_mm,setup,reading_mm\n"
    "12.000000001,b1,0.1,0.30000000000000004,1e-7,-1,20.1,,,,,,\n"
    "12.000000001,,0.1,0,0,0,20.15,,1.7,0.3,,one,\n"
    "12.000000001,b0,0.2,-3.3333333333333335,2,0,20.2,41,,,,,\n"
    "3.7,b0,1.1,2,-19.999999999999996,1.5,,40.5,,,,,7.1\n"
    "2.2,,1.1,2,1,1.5,,,2.1,,,two,\n"
    "-5,,,,,,19.7,,,,,,\n"
    "8,,1.1,2,1,,,,,,4.25,,\n"
    "40,b1,0.7,0,0,,20.9,39,,,,,\n";

class BagSession : public ::testing::Test {
 protected:
  Session sample() const {
    const Artifact plate = parseArtifact(kPlate, "plate.yaml");
    return readContactsCsv(folder_.write("c.csv", kContacts), Machine::load("three_axis"), &plate);
  }
  /// A session that fills several chunks.
  Session large(int rows) const {
    std::string csv = "time_s,x_mm,feature,bed_degC\n";
    for (int i = 0; i < rows; ++i)
      csv += std::to_string(i) + "," + std::to_string(1e-3 * i) + ",b" + std::to_string(i % 2) + ",20\n";
    const Artifact plate = parseArtifact(kPlate, "plate.yaml");
    return readContactsCsv(folder_.write("l.csv", csv), Machine::load("three_axis"), &plate);
  }
  /// What rosbag itself makes of the messages of `bag`.
  void rewrite(const std::string& bag, const std::string& to, rosbag::CompressionType compression) const {
    rosbag::Bag in(folder_.path(bag).string()), out;
    out.open(folder_.path(to).string(), rosbag::bagmode::Write);
    out.setCompression(compression);
    for (const rosbag::MessageInstance& m : rosbag::View(in))
      out.write(m.getTopic(), m.getTime(), m, m.getConnectionHeader());
  }
  /// The sessions of `bags`, each in a namespace, in one bag.
  void gather(const std::vector<std::pair<std::string, std::string>>& bags, const std::string& to) const {
    rosbag::Bag out(folder_.path(to).string(), rosbag::bagmode::Write);
    for (const auto& [space, bag] : bags) {
      rosbag::Bag in(folder_.path(bag).string());
      for (const rosbag::MessageInstance& m : rosbag::View(in))
        out.write(space + m.getTopic(), m.getTime(), m);
    }
  }
  std::string errorOf(const std::filesystem::path& file) const {
    return test::messageOf<InputError>([&] { readSessionBag(file); });
  }
  Folder folder_;
};

TEST_F(BagSession, GivesTheSameSessionAsItsCsvToTheBit) {
  const Session csv = sample();
  writeSessionBag(csv, folder_.path("s.bag"));
  const Session bag = readSessionBag(folder_.path("s.bag"));

  ASSERT_EQ(bag.observations.size(), 7u);
  EXPECT_EQ(sessionHash(bag), sessionHash(csv));
  EXPECT_EQ(bag.observations[1].time, 8.7);
  EXPECT_EQ(bag.observations[3].position[2], 0.30000000000000004 * 1e-3);
  EXPECT_EQ(bag.observations[3].time, 17.000000001);
  EXPECT_EQ(bag.observations[5].kind, ObservationKind::kDeviation) << "at equal times contacts come first";
  EXPECT_EQ(bag.temperatures.at(0).time.front(), 0.0);
  EXPECT_EQ(bag.temperatures.at(0).value.front(), 19.7);
  EXPECT_EQ(bag.covariates.at(0).unit, "percent");
  EXPECT_EQ(bag.observations[4].travel[0], 1.0) << "at standstill it is that of the way there";
  EXPECT_FALSE(bag.artifact.poseKnown);
  EXPECT_EQ(bag.machine.name(), "three_axis");
  EXPECT_EQ(bag.warning, "");
}

/// A recorded session in which no velocity was logged; the same messages live say that travel is not known.
TEST_F(BagSession, OnlyARecordedSessionAssumesItsTravel) {
  const Artifact plate = parseArtifact(kPlate, "plate.yaml");
  const Session csv = readContactsCsv(
      folder_.write("c.csv", "time_s,x_mm,deviation_x_um\n0,0,1\n1,5,1\n2,10,1\n3,10,1\n4,5,1\n"),
      Machine::load("three_axis"), &plate);
  writeSessionBag(csv, folder_.path("s.bag"));
  const Session bag = readSessionBag(folder_.path("s.bag"));
  EXPECT_EQ(sessionHash(bag), sessionHash(csv));
  ASSERT_EQ(bag.assumed.size(), 1u);
  EXPECT_EQ(bag.observations[3].travel[0], -1.0);

  SessionCollector live("the live session");
  live.setMachine(Machine::load("three_axis"));
  rosbag::Bag in(folder_.path("s.bag").string());
  for (const rosbag::MessageInstance& m : rosbag::View(in))
    if (const auto reference = m.instantiate<measuring_machine::ReferenceMeasurement>())
      live.addReference(*reference);
  const Session heard = live.build();
  ASSERT_EQ(heard.observations.size(), 5u);
  EXPECT_TRUE(heard.assumed.empty());
  for (const Observation& o : heard.observations) EXPECT_EQ(o.travel[0], 0.0);
}

TEST_F(BagSession, KeepsTheLinesOfItsCsvAndWhatIsSetAside) {
  const Artifact plate = parseArtifact(kPlate, "plate.yaml");
  std::string text = "time_s,x_mm,deviation_x_um,bed_degC\n";
  for (int i = 0; i < 60; ++i)
    text += "\n" + std::to_string(i) + "," + (i == 17 ? "-50000" : std::to_string(i % 9)) + ",1," +
            (i == 30 ? "-127" : "20") + "\n";
  const Session csv = readContactsCsv(folder_.write("c.csv", text), Machine::load("three_axis"), &plate);
  ASSERT_EQ(csv.setAside.size(), 2u);
  EXPECT_EQ(csv.setAside[0].row, 37) << "empty lines count";
  writeSessionBag(csv, folder_.path("s.bag"));
  const Session bag = readSessionBag(folder_.path("s.bag"));
  EXPECT_EQ(sessionHash(bag), sessionHash(csv));
  EXPECT_EQ(bag.rowFile, "c.csv");
  EXPECT_EQ(bag.observations.size(), 59u);
  EXPECT_EQ(bag.observations[20].row, csv.observations[20].row);
  EXPECT_EQ(bag.rowText(bag.setAside[0].row), "line 37 of c.csv");
  ASSERT_EQ(bag.setAside.size(), 2u) << "the bag holds them";
  EXPECT_EQ(bag.setAside[1].field, "temperature bed");
  EXPECT_EQ(bag.setAside[1].row, csv.setAside[1].row);
}

TEST_F(BagSession, KeepsThatNobodyRecordedTimes) {
  Session s = sample();
  const std::string timed = sessionHash(s);
  s.timesAssumed = kTimesInOrder;
  writeSessionBag(s, folder_.path("s.bag"));
  const Session back = readSessionBag(folder_.path("s.bag"));
  EXPECT_EQ(back.timesAssumed, kTimesInOrder);
  EXPECT_FALSE(back.timed(back.observations.front()));
  EXPECT_EQ(sessionHash(back), sessionHash(s));
  EXPECT_NE(sessionHash(back), timed) << "no effect of time can be asked of it";
}

TEST_F(BagSession, KeepsWhatTheControllerCompensated) {
  Session s = sample();
  const std::string unstated = sessionHash(s);
  const auto readBack = [&] {
    writeSessionBag(s, folder_.path("s.bag"));
    return readSessionBag(folder_.path("s.bag"));
  };
  EXPECT_EQ(readBack().compensation.stated, ControllerCompensation::Stated::kNot);
  s.compensation.stated = ControllerCompensation::Stated::kNone;
  EXPECT_EQ(readBack().compensation, s.compensation);
  s.compensation = {ControllerCompensation::Stated::kFiles, "grblhal", {{"settings.txt", "$160=0.01\n"}}};
  const Session files = readBack();
  EXPECT_EQ(files.compensation, s.compensation);
  EXPECT_EQ(files.compensation.files.at(0).text, "$160=0.01\n");
  EXPECT_NE(sessionHash(files), unstated)
      << "the same readings beside another compensation are another session";
  gather({{"/m1", "s.bag"}}, "space.bag");
  EXPECT_EQ(readSessionBag(folder_.path("space.bag")).compensation, s.compensation);

  SessionCollector live("the live session");
  live.addCompensation(compensationJson(s.compensation));
  EXPECT_NE(test::messageOf<InputError>([&] { live.addCompensation("none"); }).find("is not a statement"),
            std::string::npos);
}

TEST_F(BagSession, KeepsTimeZeroWhereNothingWasMeasuredAtOnce) {
  Session s = sample();
  for (Observation& o : s.observations) o.time += 100.0;
  for (auto* all : {&s.temperatures, &s.covariates})
    for (Series& series : *all)
      for (double& t : series.time) t += 100.0;
  s.epoch = 0.0;  // a simulated session has no date
  writeSessionBag(s, folder_.path("s.bag"));
  EXPECT_EQ(sessionHash(readSessionBag(folder_.path("s.bag"))), sessionHash(s));
}

TEST_F(BagSession, ANamespaceIsFoundByItself) {
  const Session csv = sample();
  writeSessionBag(csv, folder_.path("s.bag"));
  gather({{"/shop/machine1", "s.bag"}}, "n.bag");
  EXPECT_EQ(sessionHash(readSessionBag(folder_.path("n.bag"))), sessionHash(csv));
}

TEST_F(BagSession, OfSeveralNamespacesOneMustBeChosen) {
  writeSessionBag(sample(), folder_.path("s.bag"));
  writeSessionBag(large(30), folder_.path("l.bag"));
  gather({{"/machine1", "s.bag"}, {"/machine2", "l.bag"}}, "n.bag");
  EXPECT_THAT(errorOf(folder_.path("n.bag")),
              AllOf(HasSubstr("/machine1, /machine2"), HasSubstr("--namespace /machine1")));
  const auto rows = [&](const BagNamespace& where) {
    return readSessionBag(folder_.path("n.bag"), {}, nullptr, where).observations.size();
  };
  EXPECT_EQ(rows({"/machine1", true}), 7u);
  EXPECT_EQ(rows({"machine2/", true}), 30u);
  EXPECT_EQ(rows({"/machine2", false}), 30u);
  EXPECT_THAT(test::messageOf<InputError>([&] {
                rows({"/machine3", true});
              }),
              AllOf(HasSubstr("/machine3"), HasSubstr("/machine1, /machine2")));
  gather({{"/machine1", "s.bag"}}, "one.bag");
  EXPECT_EQ(readSessionBag(folder_.path("one.bag"), {}, nullptr, {"/machine2", false}).observations.size(),
            7u)
      << "the only one there is";
}

TEST_F(BagSession, RosbagReadsWhatIsWritten) {
  writeSessionBag(large(20000), folder_.path("s.bag"));
  rosbag::Bag bag(folder_.path("s.bag").string());
  std::size_t contacts = 0, others = 0;
  double last = 0.0;
  for (const rosbag::MessageInstance& m : rosbag::View(bag)) {
    EXPECT_GE(m.getTime().toSec(), last);
    last = m.getTime().toSec();
    if (m.getTopic() != "/probe/contact") {
      ++others;
      EXPECT_EQ(m.getConnectionHeader()->count("latching"), m.getTopic().find("/temperature") == 0 ? 0u : 1u);
      continue;
    }
    const auto contact = m.instantiate<measuring_machine::ProbeContact>();
    ASSERT_TRUE(contact);
    EXPECT_EQ(contact->header.stamp, m.getTime());
    EXPECT_EQ(contact->feature, contacts % 2 == 0 ? "b0" : "b1");
    EXPECT_NEAR(contact->position[0], 1e-6 * static_cast<double>(contacts), 1e-12);
    ++contacts;
  }
  EXPECT_EQ(contacts, 20000u);
  EXPECT_EQ(others, 20003u)
      << "a temperature each; the artifact, the lines of the CSV and what comes with them";
}

TEST_F(BagSession, ReadsWhatRosbagWritesWithEveryCompression) {
  const Session s = large(20000);
  writeSessionBag(s, folder_.path("s.bag"));
  for (const auto compression :
       {rosbag::compression::Uncompressed, rosbag::compression::BZ2, rosbag::compression::LZ4}) {
    rewrite("s.bag", "r.bag", compression);
    const Session r = readSessionBag(folder_.path("r.bag"));
    EXPECT_EQ(sessionHash(r), sessionHash(s)) << compression;
    EXPECT_EQ(r.warning, "");
  }
}

TEST_F(BagSession, TruncatedBagsAreReadUpToTheDamage) {
  writeSessionBag(large(9000), folder_.path("s.bag"));
  for (const char* kind : {"plain", "lz4"}) {
    if (kind == std::string("lz4")) {
      rewrite("s.bag", "r.bag", rosbag::compression::LZ4);
      std::filesystem::rename(folder_.path("r.bag"), folder_.path("s.bag"));
    }
    const std::string whole = test::readAll(folder_.path("s.bag"));
    std::size_t before = 0, sessions = 0;
    for (int part = 0; part < 40; ++part) {
      const auto cut = folder_.write("t.bag", whole.substr(0, whole.size() * part / 40));
      try {
        const Session s = readSessionBag(cut);
        EXPECT_THAT(s.warning, ::testing::MatchesRegex(".*(truncated|lost).*messages.*"));
        EXPECT_GE(s.observations.size(), before);
        before = s.observations.size();
        ++sessions;
        for (std::size_t i = 0; i < s.observations.size(); ++i)
          ASSERT_EQ(s.observations[i].row, static_cast<int>(i) + 2) << "the line of the CSV";
      } catch (const InputError& e) {
        EXPECT_EQ(before, 0u) << e.what();
      }
    }
    EXPECT_GE(sessions, kind == std::string("lz4") ? 10u : 35u) << kind;
    EXPECT_GT(before, 8000u * (kind == std::string("plain"))) << kind;
  }
}

TEST_F(BagSession, ARecordingThatWasKilledIsReadToItsEnd) {
  const Session s = large(9000);
  writeSessionBag(s, folder_.path("s.bag"));
  const pid_t child = ::fork();
  if (child == 0) {  // as `rosbag record` that gets SIGKILL: no index, the last chunk's size is still 0
    rosbag::Bag in(folder_.path("s.bag").string());
    auto* out = new rosbag::Bag(folder_.path("killed.bag.active").string(), rosbag::bagmode::Write);
    for (const rosbag::MessageInstance& m : rosbag::View(in)) out->write(m.getTopic(), m.getTime(), m);
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  const auto killed = folder_.path("killed.bag.active");
  EXPECT_THROW(rosbag::Bag(killed.string(), rosbag::bagmode::Read), rosbag::BagUnindexedException);
  const Session r = readSessionBag(killed);
  EXPECT_GE(r.observations.size(), 8990u) << "all but what was still in rosbag's buffer";
  EXPECT_THAT(r.warning, ::testing::AnyOf(HasSubstr("has no index"), HasSubstr("truncated")));
}

TEST_F(BagSession, NoDamageEndsTheProgram) {
  writeSessionBag(sample(), folder_.path("s.bag"));
  const std::string whole = test::readAll(folder_.path("s.bag"));
  std::mt19937 random(7);
  int refused = 0;
  for (int i = 0; i < 600; ++i) {
    std::string damaged = whole;
    const std::size_t begin = i % 2 == 0 ? 4100 : 0;  // the bag's padded header is long
    for (int k = 0; k < 1 + i % 4; ++k)
      damaged[begin + random() % (whole.size() - begin)] = static_cast<char>(random());
    try {
      readSessionBag(folder_.write("d.bag", damaged));
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 20);
}

/// The bytes of a stated length of joint names become four times 0xFF.
TEST_F(BagSession, ADamagedLengthTakesNoMemory) {
  writeSessionBag(sample(), folder_.path("s.bag"));
  std::string bag = test::readAll(folder_.path("s.bag"));
  const std::string name =
      std::string("\x01\x00\x00\x00x", 5);  // the first joint, after the number of joints
  const std::size_t at = bag.find(std::string("\x03\x00\x00\x00", 4) + name);
  ASSERT_NE(at, std::string::npos);
  bag.replace(at, 4, "\xff\xff\xff\x7f");
  EXPECT_THAT(errorOf(folder_.write("d.bag", bag)), HasSubstr("shorter than its type; the bag is damaged"));
}

TEST_F(BagSession, AChunkInAChunkIsDamage) {
  const auto number = [](std::uint32_t n) { return std::string(reinterpret_cast<const char*>(&n), 4); };
  const auto field = [&](const std::string& text) {
    return number(static_cast<std::uint32_t>(text.size())) + text;
  };
  std::string chunk;  // ten thousand, each in the next: the stack is not that deep
  for (int i = 0; i < 10000; ++i) {
    const std::string head = field(std::string("op=\x05")) + field("compression=none") +
                             field("size=" + number(static_cast<std::uint32_t>(chunk.size())));
    chunk = field(head) + number(static_cast<std::uint32_t>(chunk.size())) + chunk;
  }
  EXPECT_THAT(errorOf(folder_.write("n.bag", "#ROSBAG V2.0\n" + chunk)), HasSubstr("damaged or truncated"));
}

TEST_F(BagSession, WhoMeasuredIsReadFromTheIndexAlone) {
  writeSessionBag(sample(), folder_.path("s.bag"));
  EXPECT_EQ(bagSpace(folder_.path("s.bag")), "") << "no node did";
  std::string bag = test::readAll(folder_.path("s.bag"));
  EXPECT_EQ(bagSpace(folder_.write("cut.bag", bag.substr(0, bag.size() / 2))), "");
}

TEST_F(BagSession, AForeignBagIsRefusedWithItsTopics) {
  {
    rosbag::Bag bag(folder_.path("f.bag").string(), rosbag::bagmode::Write);
    bag.write("/chatter", ros::Time(10), std_msgs::String());
    bag.write("/camera", ros::Time(11), std_msgs::String());
  }
  EXPECT_THAT(errorOf(folder_.path("f.bag")),
              AllOf(HasSubstr("f.bag"), HasSubstr("/probe/contact"), HasSubstr("/camera, /chatter")));
}

TEST_F(BagSession, AnEmptySessionIsRefused) {
  { rosbag::Bag bag(folder_.path("e.bag").string(), rosbag::bagmode::Write); }
  EXPECT_THAT(errorOf(folder_.path("e.bag")), AllOf(HasSubstr("holds no measurement"), HasSubstr("none")));
  Session s = sample();
  s.observations.clear();
  EXPECT_THROW(writeSessionBag(s, folder_.path("x.bag")), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder_.path("x.bag")));
}

TEST_F(BagSession, AWrongTypeIsRefused) {
  {
    rosbag::Bag bag(folder_.path("w.bag").string(), rosbag::bagmode::Write);
    bag.write("/probe/contact", ros::Time(10), std_msgs::String());
  }
  EXPECT_THAT(errorOf(folder_.path("w.bag")),
              AllOf(HasSubstr("/probe/contact"), HasSubstr("std_msgs/String")));
}

TEST_F(BagSession, WhatIsNoBagIsRefused) {
  EXPECT_THAT(errorOf(folder_.path("no.bag")), HasSubstr("no.bag: the bag cannot be read"));
  EXPECT_THAT(errorOf(folder_.path("")), HasSubstr("folder"));
  EXPECT_THAT(errorOf(folder_.write("t.bag", "time_s,x_mm\n")), HasSubstr("is not a bag"));
  EXPECT_THAT(errorOf(folder_.write("o.bag", "#ROSBAG V1.2\n")),
              AllOf(HasSubstr("1.2"), HasSubstr("rosbag fix")));
}

TEST_F(BagSession, AMissingMachineOrArtifactIsNamed) {
  const Session s = sample();
  const auto write = [&](const std::string& without) {
    writeSessionBag(s, folder_.path("s.bag"));
    rosbag::Bag in(folder_.path("s.bag").string()),
        out(folder_.path("m.bag").string(), rosbag::bagmode::Write);
    for (const rosbag::MessageInstance& m : rosbag::View(in))
      if (m.getTopic() != without) out.write(m.getTopic(), m.getTime(), m);
  };
  write("/artifact");
  EXPECT_THAT(errorOf(folder_.path("m.bag")), HasSubstr("/artifact is missing"));
  write("/robot_description");
  EXPECT_THAT(errorOf(folder_.path("m.bag")), HasSubstr("/robot_description is missing"));
  const Machine machine = Machine::load("three_axis");
  EXPECT_EQ(sessionHash(readSessionBag(folder_.path("m.bag"), {}, &machine)), sessionHash(s));
}

/// A recording as the nodes make it: contacts late and out of order, latched topics last.
TEST_F(BagSession, ARecordingIsSortedByStampAndTravelComesFromTheJoints) {
  const Machine machine = Machine::load("three_axis");
  measuring_machine::Artifact artifact = toMessage(parseArtifact(kPlate, "plate.yaml"));
  const auto contact = [](double time, const char* feature, std::vector<double> velocity) {
    measuring_machine::ProbeContact c;
    c.header.stamp = ros::Time(time);
    c.name = {"z", "y", "x"};
    c.position = {3e-3, 2e-3, 1e-3};
    c.velocity = std::move(velocity);
    c.approach.z = -1.0;
    c.laser_reading = NAN;
    c.feature = feature;
    return c;
  };
  const auto joints = [](double time, double x, double z) {
    sensor_msgs::JointState j;
    j.header.stamp = ros::Time(time);
    j.name = {"x", "z"};
    j.position = {0, 0};
    j.velocity = {x, z};
    return j;
  };
  {
    rosbag::Bag bag(folder_.path("r.bag").string(), rosbag::bagmode::Write);
    bag.write("/probe/contact", ros::Time(120), contact(108, "b1", {0, 0, 0}));
    bag.write("/probe/contact", ros::Time(120), contact(104, "b0", {0, 0, 0}));
    bag.write("/probe/contact", ros::Time(120), contact(106, "b0", {}));
    bag.write("/joint_states", ros::Time(120), joints(103, 0.01, 0.0));
    bag.write("/joint_states", ros::Time(120), joints(105, -0.01, 0.0));
    bag.write("/joint_states", ros::Time(120), joints(107, 0.0, 0.02));
    bag.write("/joint_states", ros::Time(120), joints(109, 0.5, -0.5));
    std_msgs::String urdf;
    urdf.data = machine.urdf();
    bag.write("/robot_description", ros::Time(121), urdf);
    bag.write("/artifact", ros::Time(121), artifact);
  }
  const Session s = readSessionBag(folder_.path("r.bag"));
  ASSERT_EQ(s.observations.size(), 3u);
  EXPECT_EQ(s.observations[0].row, 2);
  EXPECT_EQ(s.observations[0].time, 1.0) << "the session starts with the first joint state";
  EXPECT_EQ(s.observations[0].position, (std::vector<double>{1e-3, 2e-3, 3e-3}));
  EXPECT_EQ(s.observations[0].travel, (std::vector<double>{1, 0, 0}));
  EXPECT_EQ(s.observations[1].travel, (std::vector<double>{-1, 0, 0}));
  EXPECT_EQ(s.observations[2].travel, (std::vector<double>{-1, 0, 1}));
  EXPECT_EQ(s.observations[2].feature, 1);
  EXPECT_EQ(s.observations[0].approach, Eigen::Vector3d(0, 0, -1));
}

TEST_F(BagSession, AFullDiskLeavesNothingBehind) {
  const Session s = large(9000);
  writeSessionBag(sample(), folder_.path("old.bag"));
  const std::string old = test::readAll(folder_.path("old.bag"));
  for (const rlim_t limit : {rlim_t{0}, rlim_t{5000}, rlim_t{1000000}}) {
    const pid_t child = ::fork();
    if (child == 0) {
      std::signal(SIGXFSZ, SIG_IGN);
      const rlimit small{limit, limit};
      ::setrlimit(RLIMIT_FSIZE, &small);
      const std::string message =
          test::messageOf<InputError>([&] { writeSessionBag(s, folder_.path("old.bag")); });
      ::_exit(message.find("old.bag: cannot be written: File too large") != std::string::npos ? 7 : 1);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_EQ(WEXITSTATUS(status), 7) << limit;
  }
  EXPECT_EQ(test::readAll(folder_.path("old.bag")), old) << "the last good file is still there";
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path("")))
    EXPECT_EQ(entry.path().string().find(".part"), std::string::npos) << entry.path();
}

TEST_F(BagSession, AFolderThatDoesNotExistIsNamed) {
  EXPECT_THAT(test::messageOf<InputError>([&] { writeSessionBag(sample(), folder_.path("no/s.bag")); }),
              AllOf(HasSubstr("no/s.bag"), HasSubstr("No such file")));
}

TEST_F(BagSession, RealFilesKeepEveryBit) {
  const auto data = test::sharedData();
  if (data.empty()) {
    std::cout << "no shared data here (set MM_SHARED_DATA): real files not read\n";
    return;
  }
  const Artifact target = loadArtifact(data / "laser_probe_mount/artifact.yaml");
  const Machine head = Machine::load((data / "laser_probe_mount/tracked_head.urdf").string());
  const Machine three = Machine::load("three_axis");
  for (const Session& csv :
       {readContactsCsv(data / "laser_probe_mount/poses.csv", head, &target),
        readContactsCsv(data / "frame_thermal/z_against_temperatures.csv", three, nullptr),
        readContactsCsv(data / "iso230_interferometer/x_axis.csv", three, nullptr)}) {
    writeSessionBag(csv, folder_.path("s.bag"));
    EXPECT_EQ(sessionHash(readSessionBag(folder_.path("s.bag"))), sessionHash(csv)) << csv.source;
  }
}

TEST_F(BagSession, ADeviceIsNoBag) {
  EXPECT_THAT(errorOf("/dev/zero"), HasSubstr("/dev/zero: is not a regular file"));
  EXPECT_THAT(errorOf(folder_.write("long.bag", std::string(10000000, 'x'))), HasSubstr("is not a bag"));
}

/// Of a bag whose contacts are well but for one, the others are the session; nodes tell their namespace.
TEST_F(BagSession, OneBadContactIsSetAsideByName) {
  writeSessionBag(large(30), folder_.path("s.bag"));
  {
    rosbag::Bag in(folder_.path("s.bag").string()),
        out(folder_.path("b.bag").string(), rosbag::bagmode::Write);
    int contacts = 0;
    boost::shared_ptr<ros::M_string> header = boost::make_shared<ros::M_string>();
    for (const rosbag::MessageInstance& m : rosbag::View(in)) {
      const auto contact = m.instantiate<measuring_machine::ProbeContact>();
      *header = *m.getConnectionHeader();
      (*header)["callerid"] = "/m1/probe";
      (*header)["topic"] = "/m1" + m.getTopic();
      if (contact && ++contacts == 17) contact->position[0] = NAN;
      if (contact)
        out.write("/m1" + m.getTopic(), m.getTime(), *contact, header);
      else
        out.write("/m1" + m.getTopic(), m.getTime(), m, header);
    }
  }
  const Session s = readSessionBag(folder_.path("b.bag"));
  EXPECT_EQ(s.observations.size(), 29u);
  ASSERT_EQ(s.setAside.size(), 1u);
  EXPECT_EQ(s.setAside[0].field, "/probe/contact message 17");
  EXPECT_EQ(bagSpace(folder_.path("b.bag")), "/m1");
  EXPECT_EQ(bagSpace(folder_.path("s.bag")), "") << "written by mm: nobody knows";
}

TEST_F(BagSession, SensorsWithSpacesKeepTheirNames) {
  Session s = large(30);
  s.temperatures[0].name = "motor left";
  writeSessionBag(s, folder_.path("s.bag"));
  EXPECT_EQ(readSessionBag(folder_.path("s.bag")).temperatures.at(0).name, "motor left");
  rosbag::Bag bag(folder_.path("s.bag").string());
  std::size_t messages = 0;
  for (const rosbag::MessageInstance& m : rosbag::View(bag, rosbag::TopicQuery("/temperature/motor_left")))
    messages += m.instantiate<sensor_msgs::Temperature>()->header.frame_id == "motor left";
  EXPECT_EQ(messages, 30u) << "a name that a replay can publish";
}

TEST_F(BagSession, KeepsPlacementsAndStyli) {
  const Artifact artifact = parseArtifact(
      "name: plate\nserial: P7\npose: free\nprobe: {styli: [{name: A, tip_radius_mm: 1}, {name: B, "
      "tip_radius_mm: "
      "2}]}\nballs:\n  - {name: b0, centre_mm: [0, 0, 0], radius_mm: 4}\n",
      "plate.yaml");
  const Session s =
      readContactsCsv(folder_.write("c.csv",
                                    "time_s,x_mm,feature,placement,stylus,reference_x_mm,length_mm\n"
                                    "0,5,b0,flat,B,,\n1,6,b0,turned,A,,\n2,6,,flat,B,1,\n"
                                    "3,6,b0,flat,A,,250.5\n"),
                      Machine::load("three_axis"), &artifact);
  writeSessionBag(s, folder_.path("s.bag"));
  const Session bag = readSessionBag(folder_.path("s.bag"));
  EXPECT_EQ(sessionHash(bag), sessionHash(s));
  EXPECT_EQ(bag.placements, s.placements);
  EXPECT_EQ(bag.observations[0].stylus, 1);
  EXPECT_EQ(bag.observations[2].stylus, 1) << "a reading of an instrument has one, too";
  EXPECT_EQ(bag.observations[3].kind, ObservationKind::kLength);
  EXPECT_DOUBLE_EQ(bag.observations[3].length, 0.2505);
  EXPECT_FALSE(bag.artifact.styli[1].known);
}

/// A message of an older version: that of today without the fields at its end.
template <typename Message>
struct Older {
  std::vector<std::uint8_t> bytes;
};
/// Checksum of that version's definition, as `rosmsg md5` told it.
template <typename Message>
const char* kOlderMd5 = "";
template <>
const char* kOlderMd5<measuring_machine::ProbeContact> = "b4c29775d90e8a19f75fcdbca4598966";
template <>
const char* kOlderMd5<measuring_machine::ReferenceMeasurement> = "";  // of which there are several
template <>
const char* kOlderMd5<measuring_machine::Artifact> = "2901c4140fcd49a8ea7858e0305e0f38";

template <typename Message>
Older<Message> olderOf(const Message& message, std::size_t missing) {
  Older<Message> older;
  older.bytes.resize(ros::serialization::serializationLength(message));
  ros::serialization::OStream out(older.bytes.data(), static_cast<std::uint32_t>(older.bytes.size()));
  ros::serialization::serialize(out, message);
  older.bytes.resize(older.bytes.size() - missing);
  return older;
}

}  // namespace
}  // namespace mm

namespace ros {
namespace message_traits {
template <typename Message>
struct MD5Sum<mm::Older<Message>> {
  static const char* value() { return mm::kOlderMd5<Message>; }
  static const char* value(const mm::Older<Message>&) { return value(); }
};
template <typename Message>
struct DataType<mm::Older<Message>> {
  static const char* value() { return DataType<Message>::value(); }
  static const char* value(const mm::Older<Message>&) { return value(); }
};
template <typename Message>
struct Definition<mm::Older<Message>> {
  static const char* value() { return "# of the version before"; }
  static const char* value(const mm::Older<Message>&) { return value(); }
};
}  // namespace message_traits
namespace serialization {
template <typename Message>
struct Serializer<mm::Older<Message>> {
  template <typename Stream>
  static void write(Stream& stream, const mm::Older<Message>& message) {
    std::memcpy(stream.advance(static_cast<std::uint32_t>(message.bytes.size())), message.bytes.data(),
                message.bytes.size());
  }
  static std::uint32_t serializedLength(const mm::Older<Message>& message) {
    return static_cast<std::uint32_t>(message.bytes.size());
  }
};
}  // namespace serialization
}  // namespace ros

namespace mm {
namespace {

class OlderReferences : public BagSession,
                        public ::testing::WithParamInterface<std::pair<const char*, std::size_t>> {};

TEST_P(OlderReferences, AreRead) {
  kOlderMd5<measuring_machine::ReferenceMeasurement> = GetParam().first;
  const Session s = sample();
  writeSessionBag(s, folder_.path("s.bag"));
  rosbag::Bag now(folder_.path("s.bag").string(), rosbag::bagmode::Read),
      before(folder_.path("before.bag").string(), rosbag::bagmode::Write);
  int contacts = 0, references = 0, artifacts = 0;
  for (const rosbag::MessageInstance& m : rosbag::View(now)) {
    if (const auto contact = m.instantiate<measuring_machine::ProbeContact>())
      before.write(m.getTopic(), m.getTime(), olderOf(*contact, 8)), ++contacts;
    else if (const auto reference = m.instantiate<measuring_machine::ReferenceMeasurement>())
      before.write(m.getTopic(), m.getTime(), olderOf(*reference, GetParam().second)), ++references;
    else if (const auto artifact = m.instantiate<measuring_machine::Artifact>())
      before.write(m.getTopic(), m.getTime(), olderOf(*artifact, 8)), ++artifacts;
    else
      before.write(m.getTopic(), m.getTime(), m);
  }
  before.close();
  EXPECT_GT(contacts, 0);
  EXPECT_GT(references, 0);
  EXPECT_EQ(artifacts, 1);
  EXPECT_EQ(sessionHash(readSessionBag(folder_.path("before.bag"))), sessionHash(s));
}
INSTANTIATE_TEST_SUITE_P(Versions, OlderReferences,
                         ::testing::Values(std::pair("eeba7cd1b94dfc51f75c0202a252cc66", 20),
                                           std::pair("a482de645c806787ff92691de62d6090", 16),
                                           std::pair("82269c670d85bc4d38c304750d8ffddf", 12)));

TEST_F(BagSession, SeveralBagsAreSeparatedByColons) {
  EXPECT_EQ(bagPaths("a.bag:b.bag"), (std::vector<std::string>{"a.bag", "b.bag"}));
  EXPECT_THROW(bagPaths("a.bag::b.bag"), InputError);
  writeSessionBag(sample(), folder_.path("odd:name.bag"));
  EXPECT_EQ(bagPaths(folder_.path("odd:name.bag")).size(), 1U) << "a file with that name";
}

}  // namespace
}  // namespace mm
