#pragma once
#include <string>
#include <vector>

#include "measuring_machine/axis_controller.h"

namespace mm {

/// Axes of a numerical control, in the order of its positions.
inline constexpr char kControlLetters[] = "XYZABC";

/// Between the joints of the URDF and the lettered axes of a numerical control: letter, sign and zero.
/// Parameters: `axes` (`x:X y:Y b:B`; left out: joints of one letter by their own), `sign` (`y:-1`), `zero`
/// (`x:-10.5`: what the control shows, mm or deg, where the joint reads 0).
class AxisMap {
 public:
  /// @throw InputError naming the joint or letter that is wrong.
  AxisMap(const ControllerSetup& setup, const std::string& letters);

  std::size_t size() const { return axes_.size(); }                 ///< axes
  const std::vector<std::string>& names() const { return names_; }  ///< in their order
  const ControllerAxis& axis(std::size_t j) const { return axes_[j]; }
  char letter(std::size_t j) const { return letters_[j]; }
  std::size_t place(std::size_t j) const { return places_[j]; }  ///< among the letters of the control
  double unit(std::size_t j) const { return units_[j]; }         ///< m or rad per mm or deg
  int sign(std::size_t j) const { return signs_[j]; }

  double toJoint(std::size_t j, double control) const;  ///< mm or deg to m or rad
  double toControl(std::size_t j, double joint) const;  ///< m or rad to mm or deg
  /// Places among the letters that a control must have.
  std::size_t needed() const;

 private:
  std::vector<ControllerAxis> axes_;
  std::vector<std::string> names_;
  std::vector<char> letters_;
  std::vector<std::size_t> places_;
  std::vector<double> units_, zeros_;
  std::vector<int> signs_;
};

/// A number in a parameter of a controller. @throw InputError naming it.
double numberParameterOf(const ControllerSetup& setup, const std::string& name, double standard, double lower,
                         double upper);
std::string textParameterOf(const ControllerSetup& setup, const std::string& name,
                            const std::string& standard);
/// @throw InputError naming a parameter that is not among `known`.
void refuseUnknownParametersOf(const ControllerSetup& setup, const std::string& controller,
                               const std::vector<std::string>& known);

/// The switch of the probe as one state shows it: closed or open now, and when only within `period` (s).
ProbeEdge seenEdge(const AxesState& state, bool closed, double period);

}  // namespace mm
