#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "interpreters/table_sum.h"

namespace mm {

/// A small displacement and a small rotation, m and rad, in the axes of the fixed side of a joint.
struct SmallMotion {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero(), rotation = Eigen::Vector3d::Zero();
};

/// One line of chain.csv.
struct ChainJoint {
  std::string name;
  bool rotary = false;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // unit vector, axes of the fixed side
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();     // from the joint before, axes of its moving side, m
  bool aboutCarriage = false;  // errors rotate about the point that moves, else about the fixed side's origin
};

/// Component errors of ISO 230-1 with the kinematic chain that they belong to: the files of target csv. A
/// value is where the axis really is less where it should be.
class ErrorTables {
 public:
  /// @throw InputError naming file, line, column and value.
  explicit ErrorTables(const std::filesystem::path& folder);

  const std::vector<ChainJoint>& chain() const { return chain_; }  ///< from workpiece to tool
  const Eigen::Vector3d& tip() const { return tip_; }              ///< from the last joint, m
  JointPoints points() const;                                      ///< of every joint of the chain
  /// Component errors of a joint at a command.
  SmallMotion component(std::size_t joint, const CommandedState& command) const;
  /// Its errors of location and orientation.
  const SmallMotion& location(std::size_t joint) const { return locations_[joint]; }

 private:
  struct Component {
    std::size_t joint;
    int coordinate;  // 0 to 2: along x, y, z; 3 to 5: about them
    Curve positive, negative;
  };
  void readChain(const std::filesystem::path& file);
  void readComponent(const std::filesystem::path& file);
  void readLocations(const std::filesystem::path& file);
  std::size_t jointCalled(char letter, const FilePlace& place) const;

  std::vector<ChainJoint> chain_;
  Eigen::Vector3d tip_ = Eigen::Vector3d::Zero();
  std::vector<Component> components_;
  std::vector<SmallMotion> locations_;
};

}  // namespace mm
