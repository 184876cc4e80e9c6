#pragma once
#include <string>
#include <vector>

#include "machine/machine.h"

namespace mm::test {

/// A joint of a chain that is made up: "prismatic", "revolute" or "fixed", with axis and rpy in its own axes.
struct ChainJoint {
  std::string name, parent, child, type = "fixed", axis = "1 0 0", rpy = "0 0 0";
};

inline Machine chainOf(const std::string& name, const std::vector<ChainJoint>& joints) {
  std::string urdf = "<robot name=\"" + name + "\"><link name=\"" + joints.front().parent + "\"/>";
  for (const ChainJoint& j : joints) urdf += "<link name=\"" + j.child + "\"/>";
  for (const ChainJoint& j : joints)
    urdf += "<joint name=\"" + j.name + "\" type=\"" + j.type + "\"><parent link=\"" + j.parent +
            "\"/><child link=\"" + j.child + "\"/><origin xyz=\"0 0 0\" rpy=\"" + j.rpy + "\"/><axis xyz=\"" +
            j.axis + "\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>";
  return Machine(urdf + "</robot>", name);
}

constexpr const char* kAlong = "prismatic";
constexpr const char* kTurns = "revolute";

/// A trunnion a, on it a table c, both on a saddle; the column carries the ram.
inline Machine tableTable() {
  return chainOf("table_table", {{"saddle", "base", "carriage", kAlong, "1 0 0"},
                                 {"trunnion", "carriage", "cradle", kTurns, "1 0 0"},
                                 {"table", "cradle", "workpiece", kTurns, "0 0 1"},
                                 {"column", "base", "upright", kAlong, "0 1 0"},
                                 {"ram", "upright", "probe_tip", kAlong, "0 0 1"}});
}

/// Three linear axes and a fork head, whose second axis stands in a link that is turned by 90 degrees.
inline Machine headHead() {
  return chainOf("head_head", {{"j1", "workpiece", "l1", kAlong, "1 0 0"},
                               {"j2", "l1", "l2", kAlong, "0 1 0"},
                               {"j3", "l2", "l3", kAlong, "0 0 -1"},
                               {"j4", "l3", "l4", kTurns, "0 0 1"},
                               {"adapter", "l4", "turned", "fixed", "1 0 0", "0 0 1.5707963267948966"},
                               {"j5", "turned", "l5", kTurns, "0 1 0"},
                               {"mount", "l5", "probe_tip"}});
}

/// A bridge over a table that stands on the bed's frame; a quill in the ram moves as the ram does.
inline Machine gantry() {
  return chainOf("gantry", {{"table", "bed", "workpiece"},
                            {"frame", "bed", "rails"},
                            {"bridge", "rails", "portal", kAlong, "0 1 0"},
                            {"carriage", "portal", "slide", kAlong, "1 0 0"},
                            {"ram", "slide", "beam", kAlong, "0 0 1"},
                            {"quill", "beam", "probe_tip", kAlong, "0 0 1"}});
}

/// A moving column beside a table that turns about the vertical, which is y; the table's joint is called a.
inline Machine movingColumn() {
  return chainOf("moving_column", {{"a", "base", "workpiece", kTurns, "0 -1 0"},
                                   {"h", "base", "column", kAlong, "1 0 0"},
                                   {"v", "column", "saddle", kAlong, "0 1 0"},
                                   {"r", "saddle", "probe_tip", kAlong, "0 0 1"}});
}

/// Azimuth and elevation.
inline Machine telescope() {
  return chainOf("telescope", {{"azimuth", "workpiece", "fork", kTurns, "0 0 1"},
                               {"elevation", "fork", "tube", kTurns, "0 1 0"},
                               {"mount", "tube", "probe_tip"}});
}

/// Hour angle about a polar axis 48 degrees above the horizon, and declination.
inline Machine equatorialMount() {
  return chainOf("equatorial_mount", {{"ha", "workpiece", "fork", kTurns, "0 0.669 0.743"},
                                      {"dec", "fork", "tube", kTurns, "1 0 0"},
                                      {"mount", "tube", "probe_tip"}});
}

}  // namespace mm::test
