// The package's own tables (docs/interpreters.md). Rotary motors are moved by the errors of their own angle
// (EAA, EBB, ECC, as far as they point along the axis), then the linear ones so that the tip is where it was
// commanded.
#include <Eigen/Geometry>

#include "base/dense.h"
#include "base/rotation.h"
#include "interpreters/error_tables.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

struct ChainPose {
  Eigen::Vector3d tip;
  Eigen::Matrix3Xd directions;  // of the linear joints in the workpiece, a column each
};

class CsvInterpreter : public Interpreter {
 public:
  explicit CsvInterpreter(const std::filesystem::path& folder) : tables_(folder) {}

  std::map<std::string, double> motors(const CommandedState& command) const override {
    const std::vector<ChainJoint>& chain = tables_.chain();
    std::vector<SmallMotion> errors, locations, none(chain.size());
    Eigen::VectorXd position(chain.size());
    for (std::size_t j = 0; j < chain.size(); ++j) {
      position[j] = commanded(command, chain[j].name);
      errors.push_back(tables_.component(j, command));
      locations.push_back(tables_.location(j));
    }
    const ChainPose ideal = pose(position, none, none);
    Eigen::VectorXd driven = position;
    for (std::size_t j = 0; j < chain.size(); ++j)
      if (chain[j].rotary) driven[j] -= errors[j].rotation.dot(chain[j].direction);
    constexpr int kRounds = 3;  // each leaves the square of the errors of the one before
    for (int round = 0; round < kRounds && ideal.directions.cols() > 0; ++round) {
      const ChainPose real = pose(driven, errors, locations);
      const Eigen::VectorXd step = leastSquares(real.directions, ideal.tip - real.tip);
      int linear = 0;
      for (std::size_t j = 0; j < chain.size(); ++j)
        if (!chain[j].rotary) driven[j] += step[linear++];
    }
    std::map<std::string, double> motors = command.position;
    for (std::size_t j = 0; j < chain.size(); ++j) motors[chain[j].name] = driven[j];
    return motors;
  }

  JointPoints points() const override { return tables_.points(); }

 private:
  /// Location and orientation, then the component errors at the fixed side (or at the carriage), then the
  /// motion.
  ChainPose pose(const Eigen::VectorXd& position, const std::vector<SmallMotion>& errors,
                 const std::vector<SmallMotion>& locations) const {
    const std::vector<ChainJoint>& chain = tables_.chain();
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    Eigen::Matrix3Xd directions(3, 0);
    for (std::size_t j = 0; j < chain.size(); ++j) {
      frame.translate(chain[j].origin + locations[j].translation).rotate(rotationBy(locations[j].rotation));
      const Eigen::Vector3d travel = chain[j].direction * position[static_cast<Eigen::Index>(j)];
      const bool rotateLast = chain[j].aboutCarriage && !chain[j].rotary;
      frame.translate(errors[j].translation);
      if (!rotateLast) frame.rotate(rotationBy(errors[j].rotation));
      if (chain[j].rotary) {
        frame.rotate(rotationBy(travel));
      } else {
        directions.conservativeResize(3, directions.cols() + 1);
        directions.rightCols<1>() = frame.linear() * chain[j].direction;
        frame.translate(travel);
      }
      if (rotateLast) frame.rotate(rotationBy(errors[j].rotation));
    }
    return {frame * tables_.tip(), directions};
  }

  ErrorTables tables_;
};

}  // namespace

std::unique_ptr<Interpreter> interpretCsv(const std::filesystem::path& folder) {
  return std::make_unique<CsvInterpreter>(folder);
}

}  // namespace mm
