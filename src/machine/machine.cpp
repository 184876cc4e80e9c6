#include "machine/machine.h"

#include <tinyxml2.h>

#include <Eigen/LU>
#include <kdl/chain.hpp>
#include <kdl/tree.hpp>
#include <kdl_parser/kdl_parser.hpp>

#include "base/error.h"
#include "base/read_file.h"
#include "base/rotation.h"

namespace mm {
namespace {

constexpr int kMaxJoints = 16;  // buffers of `measure` are on the stack

Eigen::Vector3d vectorOf(const KDL::Vector& v) { return {v.x(), v.y(), v.z()}; }

Eigen::Matrix3d matrixOf(const KDL::Rotation& r) {
  Eigen::Matrix3d m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = r(i, j);
  return m;
}

struct Limits {
  double lower = 0.0, upper = 0.0, velocity = 0.0;
};

/// Limits are not part of a KDL tree: read from the XML itself.
Limits limitsOf(const tinyxml2::XMLElement* robot, const std::string& joint) {
  Limits limits;
  for (auto* j = robot->FirstChildElement("joint"); j != nullptr; j = j->NextSiblingElement("joint")) {
    const char* name = j->Attribute("name");
    const tinyxml2::XMLElement* limit = j->FirstChildElement("limit");
    if (name == nullptr || joint != name || limit == nullptr) continue;
    limits.lower = limit->DoubleAttribute("lower");
    limits.upper = limit->DoubleAttribute("upper");
    limits.velocity = limit->DoubleAttribute("velocity");
  }
  return limits;
}

/// Moving joints from `workpiece` up to the link that carries both it and `probe_tip`.
int jointsBelowTheBed(const KDL::Tree& tree) {
  const auto linksAbove = [](KDL::SegmentMap::const_iterator link, KDL::SegmentMap::const_iterator root) {
    std::vector<KDL::SegmentMap::const_iterator> above{link};
    while (above.back() != root) above.push_back(GetTreeElementParent(above.back()->second));
    return above;
  };
  const auto carriers = linksAbove(tree.getSegment("probe_tip"), tree.getRootSegment());
  int joints = 0;
  for (const auto& link : linksAbove(tree.getSegment("workpiece"), tree.getRootSegment())) {
    if (std::find(carriers.begin(), carriers.end(), link) != carriers.end()) break;
    const KDL::Joint::JointType type = GetTreeElementSegment(link->second).getJoint().getType();
    if (type != KDL::Joint::None && type != KDL::Joint::Fixed) ++joints;
  }
  return joints;
}

}  // namespace

Machine::Machine(std::string urdf, std::string name) : name_(std::move(name)), urdf_(std::move(urdf)) {
  tinyxml2::XMLDocument document;
  if (document.Parse(urdf_.c_str()) != tinyxml2::XML_SUCCESS ||
      document.FirstChildElement("robot") == nullptr)
    throw InputError("machine '" + name_ + "': the URDF is not XML with a <robot> element: " +
                     (document.ErrorStr() ? document.ErrorStr() : ""));
  KDL::Tree tree;
  if (!kdl_parser::treeFromString(urdf_, tree))
    throw InputError("machine '" + name_ +
                     "': the URDF cannot be read as a tree of links; check it with check_urdf");
  KDL::Chain chain;
  if (!tree.getChain("workpiece", "probe_tip", chain))
    throw InputError(
        "machine '" + name_ +
        "': no chain from link 'workpiece' to link 'probe_tip'; both links must exist in the URDF");

  tableJoints_ = jointsBelowTheBed(tree);
  // A KDL segment is a joint at its origin followed by a fixed transform; fixed parts are gathered before
  // each joint.
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  const auto then = [&](const Eigen::Matrix3d& r, const Eigen::Vector3d& t) {
    translation += rotation * t;
    rotation = rotation * r;
  };
  for (const KDL::Segment& segment : chain.segments) {
    const KDL::Joint& joint = segment.getJoint();
    if (joint.getType() == KDL::Joint::None || joint.getType() == KDL::Joint::Fixed) {
      then(matrixOf(segment.pose(0.0).M), vectorOf(segment.pose(0.0).p));
      continue;
    }
    const std::string type = joint.getTypeName();
    const bool rotary = type.find("Rot") != std::string::npos;
    const Eigen::Vector3d axis = vectorOf(joint.JointAxis());
    const Eigen::Vector3d origin = vectorOf(joint.JointOrigin());
    then(Eigen::Matrix3d::Identity(), origin);
    links_.push_back({rotation, translation, axis, !rotation.isIdentity(0.0)});
    const Limits limits = limitsOf(document.FirstChildElement("robot"), joint.getName());
    joints_.push_back({joint.getName(), rotary ? JointKind::kRotary : JointKind::kLinear, limits.lower,
                       limits.upper, limits.velocity, axis, rotation.transpose() * translation});
    rotation = Eigen::Matrix3d::Identity();
    translation = Eigen::Vector3d::Zero();
    // segment.pose(0) = joint at zero * fixed tip; the joint at zero is the identity about its origin
    then(matrixOf(segment.pose(0.0).M), vectorOf(segment.pose(0.0).p) - origin);
  }
  tip_ = {rotation, translation, Eigen::Vector3d::UnitZ(), !rotation.isIdentity(0.0)};
  if (jointCount() > kMaxJoints)
    throw InputError("machine '" + name_ + "': " + std::to_string(jointCount()) +
                     " moving joints between 'workpiece' and 'probe_tip'; at most " +
                     std::to_string(kMaxJoints) + ": make those that do not move fixed joints");
  if (joints_.empty())
    throw InputError("machine '" + name_ + "': no moving joint between 'workpiece' and 'probe_tip'");
}

Machine Machine::load(const std::string& nameOrPath, const std::filesystem::path& relativeTo) {
  namespace fs = std::filesystem;
  std::vector<fs::path> tried;
  const bool shipped =
      nameOrPath.find('/') == std::string::npos && nameOrPath.find(".urdf") == std::string::npos;
  if (shipped) {
    for (const char* folder : {MM_SOURCE_URDF, MM_INSTALLED_URDF})
      tried.push_back(fs::path(folder) / (nameOrPath + ".urdf"));
  } else {
    tried.push_back(relativeTo.empty() || fs::path(nameOrPath).is_absolute() ? fs::path(nameOrPath)
                                                                             : relativeTo / nameOrPath);
    if (!relativeTo.empty()) tried.push_back(nameOrPath);
  }
  for (const fs::path& path : tried) {
    if (!fs::is_regular_file(path)) continue;
    return Machine(readWholeFile(path, "check the path of the machine's URDF"), nameOrPath);
  }
  throw InputError(
      "machine '" + nameOrPath + "': " +
      (shipped ? "not one of three_axis, five_axis; for a machine of your own give the path of its URDF"
               : "no such file as " + tried.front().string()));
}

int Machine::findJoint(const std::string& name) const {
  for (int j = 0; j < jointCount(); ++j)
    if (joints_[j].name == name) return j;
  return -1;
}

void Machine::Link::appendTo(ProbePose& pose) const {
  pose.position += pose.orientation * translation;
  if (turned) pose.orientation = pose.orientation * rotation;
}

ProbePose Machine::nominal(const double* q, double laserReading) const {
  ProbePose pose;
  for (int j = 0; j < jointCount(); ++j) {
    const Link& link = links_[j];
    link.appendTo(pose);
    if (joints_[j].kind == JointKind::kLinear)
      pose.position += pose.orientation * link.axis * q[j];
    else
      pose.orientation = pose.orientation * Eigen::AngleAxisd(q[j], link.axis).toRotationMatrix();
  }
  tip_.appendTo(pose);
  if (laserReading == laserReading) pose.position += pose.orientation.col(2) * laserReading;
  return pose;
}

ProbePose Machine::measure(const double* q, double laserReading, const double* errors,
                           Eigen::Matrix<double, 6, Eigen::Dynamic>* gradient) const {
  const ErrorLayout at = layout();
  const auto vector = [&](int first) { return Eigen::Map<const Eigen::Vector3d>(errors + first); };
  Eigen::Vector3d origins[kMaxJoints], pivots[kMaxJoints], axes[kMaxJoints];
  Eigen::Matrix3d frames[kMaxJoints];

  ProbePose pose;
  for (int j = 0; j < jointCount(); ++j) {
    const Link& link = links_[j];
    link.appendTo(pose);
    const auto displace = [&](double sign) {
      frames[j] = sign * pose.orientation;
      pose.position += frames[j] * vector(at.jointTranslation(j, 0));
      origins[j] = pose.position;
      const Eigen::Vector3d twist = sign * vector(at.jointRotation(j, 0));
      if (!twist.isZero(0.0)) pose.orientation = pose.orientation * rotationBy(twist);
    };
    if (j >= tableJoints_) displace(1.0);
    pivots[j] = pose.position;
    axes[j] = pose.orientation * link.axis;
    const double moved = q[j] + errors[at.axis(j)];
    if (joints_[j].kind == JointKind::kLinear)
      pose.position += axes[j] * moved;
    else
      pose.orientation = pose.orientation * Eigen::AngleAxisd(moved, link.axis).toRotationMatrix();
    if (j < tableJoints_) displace(-1.0);  // seen from the workpiece the bed goes the other way
  }
  tip_.appendTo(pose);

  const bool laser = laserReading == laserReading;
  const double reading = (laser ? laserReading : 0.0) + errors[at.reading()];
  const Eigen::Vector3d beam = Eigen::Vector3d::UnitZ() + vector(at.beam(0));
  const Eigen::Matrix3d tipFrame = pose.orientation;
  const Eigen::Vector3d tilt = vector(at.orientation(0));
  Eigen::Vector3d reach = Eigen::Vector3d::Zero();
  if (laser) reach = tipFrame * beam * reading;
  pose.position += tipFrame * vector(at.probe(0)) + reach + tilt.cross(reach) + vector(at.volume(0));
  if (!tilt.isZero(0.0)) pose.orientation = rotationBy(tilt) * pose.orientation;
  if (gradient == nullptr) return pose;

  gradient->setZero(6, at.size());
  const Eigen::Vector3d rigid = pose.position - vector(at.volume(0)) - tilt.cross(reach);
  for (int j = 0; j < jointCount(); ++j) {
    gradient->block<3, 3>(0, at.jointTranslation(j, 0)) = frames[j];
    gradient->block<3, 3>(3, at.jointRotation(j, 0)) = frames[j];
    for (int k = 0; k < 3; ++k)
      gradient->block<3, 1>(0, at.jointRotation(j, k)) = frames[j].col(k).cross(rigid - origins[j]);
    if (joints_[j].kind == JointKind::kLinear) {
      gradient->block<3, 1>(0, at.axis(j)) = axes[j];
    } else {
      gradient->block<3, 1>(0, at.axis(j)) = axes[j].cross(rigid - pivots[j]);
      gradient->block<3, 1>(3, at.axis(j)) = axes[j];
    }
  }
  gradient->block<3, 3>(0, at.volume(0)).setIdentity();
  gradient->block<3, 3>(3, at.orientation(0)).setIdentity();
  gradient->block<3, 3>(0, at.probe(0)) = tipFrame;
  if (laser) {
    gradient->block<3, 3>(0, at.orientation(0)) = -skew(reach);
    gradient->block<3, 3>(0, at.beam(0)) = tipFrame * reading;
    gradient->block<3, 1>(0, at.reading()) = tipFrame * beam;
  }
  return pose;
}

Eigen::Matrix<double, 6, Eigen::Dynamic> Machine::jacobian(const double* q, double laserReading) const {
  const std::vector<double> none(static_cast<std::size_t>(layout().size()), 0.0);
  Eigen::Matrix<double, 6, Eigen::Dynamic> gradient;
  measure(q, laserReading, none.data(), &gradient);
  return gradient.leftCols(jointCount());
}

Eigen::Matrix<double, 1, 6> Machine::seenAsDeviation(int joint, const double* q, double laserReading) const {
  constexpr double kSingular = 1e-3;  // sine of the angle between line of sight and first axis
  const Eigen::Matrix<double, 6, Eigen::Dynamic> by = jacobian(q, laserReading);
  Eigen::Matrix<double, 1, 6> seen = Eigen::Matrix<double, 1, 6>::Zero();
  if (joints_[joint].kind == JointKind::kLinear) {
    seen.head<3>() = by.block<3, 1>(0, joint).transpose() / by.block<3, 1>(0, joint).squaredNorm();
    return seen;
  }
  seen.tail<3>() = by.block<3, 1>(3, joint).transpose();
  if (jointCount() != 2 || joints_[0].kind != JointKind::kRotary || joints_[1].kind != JointKind::kRotary)
    return seen;
  const Eigen::Vector3d first = by.block<3, 1>(3, 0), second = by.block<3, 1>(3, 1);
  const Eigen::Vector3d across = first.cross(second);
  if (across.norm() < kSingular) return seen;
  const Eigen::Vector3d sight = Eigen::AngleAxisd(q[1], second) * across.normalized();
  Eigen::Matrix<double, 3, 2> moves;  // of the line of sight by each joint
  moves << first.cross(sight), second.cross(sight);
  if (moves.col(0).norm() < kSingular) return seen;
  const Eigen::Matrix2d gram = moves.transpose() * moves;
  seen.tail<3>() = (gram.inverse() * moves.transpose() * -skew(sight)).row(joint);
  return seen;
}

}  // namespace mm
