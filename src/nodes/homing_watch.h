#pragma once
#include <cstdint>
#include <vector>

namespace mm {

/// Whether the joints of a machine have a zero, as their drivers tell it: one driver may move all of them, or
/// each of several some. Stamps in ns.
class HomingWatch {
 public:
  /// What a driver tells of its joints.
  struct Told {
    bool homed = false;
    std::int64_t at = 0;  // of the homing; 0: not homed
  };
  /// Nothing is known of any of so many joints.
  explicit HomingWatch(std::size_t joints) : joints_(joints) {}

  /// As a joint state says it. @return true when its zero is another one: how it moved until now says
  /// nothing.
  bool take(int joint, const Told& told);
  /// As a status says it; counts for a joint whose states do not.
  void takeStatus(int joint, const Told& told);
  /// Whether a status that tells of a homing at `at` is of the life that the joint's states are of.
  bool isOf(int joint, std::int64_t at) const;

  bool anyNotHomed() const;   ///< a joint that is said to be without a zero
  std::int64_t zero() const;  ///< of the last homing; 0: not known

 private:
  struct Joint {
    bool byState = false, known = false;
    Told told;
  };
  std::vector<Joint> joints_;
};

}  // namespace mm
