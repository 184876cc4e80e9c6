#include "machine/new_machine.h"

#include <algorithm>
#include <cctype>
#include <sstream>

#include "base/error.h"
#include "base/format.h"
#include "base/rotation.h"

namespace mm {
namespace {

std::string number(double value) { return format("%.12g", value); }

std::string vector(const Eigen::Vector3d& v) {
  return number(v.x()) + " " + number(v.y()) + " " + number(v.z());
}

/// A name that is a YAML key, a column and a topic at once.
bool isName(const std::string& name) {
  return !name.empty() && std::isalpha(static_cast<unsigned char>(name.front())) != 0 &&
         std::all_of(name.begin(), name.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; });
}

void check(const NewMachine& m) {
  if (!isName(m.name))
    throw InputError("the machine's name '" + m.name +
                     "' must be letters, digits and _, beginning with a letter");
  if (m.axes.empty()) throw InputError("the machine '" + m.name + "' has no axis; give one");
  for (std::size_t i = 0; i < m.axes.size(); ++i) {
    const NewMachine::Axis& a = m.axes[i];
    if (!isName(a.name))
      throw InputError("axis '" + a.name +
                       "': its name must be letters, digits and _, beginning with a letter");
    for (std::size_t j = 0; j < i; ++j)
      if (m.axes[j].name == a.name)
        throw InputError("axis '" + a.name + "' is given twice; name them differently");
    if (!(a.upper > a.lower))
      throw InputError("axis '" + a.name + "': its travel must go from a lower to a higher reading");
    if (!(a.direction.norm() > kNoDirection))
      throw InputError("axis '" + a.name + "': its direction must not be zero");
  }
}

}  // namespace

std::string newMachineUrdf(const NewMachine& m) {
  check(m);
  std::ostringstream out;
  out << "<?xml version=\"1.0\"?>\n"
         "<!-- The axes in the order from the workpiece to the probe; a positive reading moves the probe "
         "along\n"
         "     (turns it about) its axis, seen from the workpiece. Lengths in m, angles in rad. -->\n"
      << "<robot name=\"" << m.name << "\">\n  <link name=\"workpiece\"/>\n";
  for (const auto& a : m.axes) out << "  <link name=\"" << a.name << "_slide\"/>\n";
  out << "  <link name=\"probe_tip\"/>\n";
  std::string parent = "workpiece";
  for (const auto& a : m.axes) {
    const bool linear = a.kind == JointKind::kLinear;
    out << "  <joint name=\"" << a.name << "\" type=\"" << (linear ? "prismatic" : "revolute") << "\">\n"
        << "    <parent link=\"" << parent << "\"/><child link=\"" << a.name << "_slide\"/><axis xyz=\""
        << vector(a.direction.normalized()) << "\"/>\n"
        << "    <limit lower=\"" << number(a.lower) << "\" upper=\"" << number(a.upper)
        << "\" effort=\"50\" velocity=\"" << number(linear ? m.speed : 10.0 * m.speed)
        << "\"/>\n  </joint>\n";
    parent = a.name + "_slide";
  }
  out << "  <joint name=\"probe_mount\" type=\"fixed\">\n    <parent link=\"" << parent
      << "\"/><child link=\"probe_tip\"/><origin xyz=\"" << vector(m.tip) << "\"/>\n  </joint>\n</robot>\n";
  return out.str();
}

}  // namespace mm
