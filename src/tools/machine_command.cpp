#include <cmath>
#include <filesystem>
#include <iostream>

#include "base/error.h"
#include "base/number_text.h"
#include "base/units.h"
#include "effects/effect_spec.h"
#include "machine/iso230_axes.h"
#include "machine/new_machine.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/output_files.h"

namespace mm {
namespace {

struct MachineOptions {
  std::vector<std::string> axes;   // from the workpiece to the probe
  std::vector<std::string> leads;  // of their screws or worms
  std::string tip = "0,0,0", probe = "touch", output, model;
  double speed = 20.0;  // mm/s
  OutputFiles files;
};

/// "0,0,-60". @throw InputError.
Eigen::Vector3d vectorOf(const std::string& option, const std::string& text) {
  return Eigen::Vector3d(listOfNumbers(text, option, 3, "x,y,z").data());
}

/// "x=-20:20mm" or "b=-90:90deg@0,0,1". @throw InputError.
NewMachine::Axis axisOf(const std::string& text) {
  const auto bad = [&](const std::string& why) {
    return InputError("--axis '" + text + "': " + why + "; write it as x=-20:20mm or b=-90:90deg@0,0,1");
  };
  const std::string travel = text.substr(0, text.find('@'));
  const std::size_t equal = travel.find('='), colon = travel.find(':'),
                    unit = travel.find_last_of("0123456789.") + 1;
  if (equal == std::string::npos || colon == std::string::npos || colon < equal || unit <= colon)
    throw bad("is not an axis with its travel");
  NewMachine::Axis axis;
  axis.name = travel.substr(0, equal);
  if (travel.substr(unit) != "mm" && travel.substr(unit) != "deg")
    throw bad("its travel is neither in mm (a linear axis) nor in deg (a rotary one)");
  axis.kind = travel.substr(unit) == "mm" ? JointKind::kLinear : JointKind::kRotary;
  const double si = axis.kind == JointKind::kLinear ? kMillimetre : kDegree;
  if (!parseNumber(travel.substr(equal + 1, colon - equal - 1), axis.lower) ||
      !parseNumber(travel.substr(colon + 1, unit - colon - 1), axis.upper) ||
      !std::isfinite(axis.upper - axis.lower))
    throw bad("its travel is not two numbers");
  axis.lower *= si;
  axis.upper *= si;
  if (travel.size() < text.size()) {
    axis.direction = vectorOf("--axis " + axis.name, text.substr(travel.size() + 1));
    return axis;
  }
  const std::size_t standard = axis.name.size() == 1 ? std::string("xyz").find(axis.name) : std::string::npos;
  if (axis.kind == JointKind::kRotary || standard == std::string::npos)
    throw bad("only linear axes named x, y or z have a default direction; add @X,Y,Z");
  axis.direction = Eigen::Vector3d::Unit(static_cast<Eigen::Index>(standard));
  return axis;
}

/// "x=5mm" or "b=3deg" as the effect of a screw, or worm, of this lead. @throw InputError.
EffectSpec periodicError(const std::string& text, const Machine& machine) {
  const auto bad = [&](const std::string& why) {
    return InputError("--lead '" + text + "': " + why + "; write it as x=5mm or b=3deg");
  };
  const auto [name, length] = assignmentOf(text, "--lead", "x=5mm or b=3deg");
  const int joint = machine.findJoint(name);
  if (joint < 0) throw bad("no --axis is named '" + name + "'");
  const bool linear = machine.joints()[static_cast<std::size_t>(joint)].kind == JointKind::kLinear;
  const std::size_t unit = length.find_last_of("0123456789.") + 1;
  const std::string number = length.substr(0, unit);
  double lead = 0.0;
  if (!parseNumber(number, lead) || lead <= 0.0 || length.substr(unit) != (linear ? "mm" : "deg"))
    throw bad(std::string("the lead of a ") + (linear ? "linear axis is a positive number in mm"
                                                      : "rotary axis is a positive number in deg"));
  return EffectSpec("lead_screw_periodic").set("axis", name).set(linear ? "period_mm" : "period_deg", number);
}

/// What every machine has: scales, and axes that are not square; of a screw the error that repeats with its
/// turns; of a laser, where it is mounted.
std::string modelYaml(const Machine& machine, const std::string& urdf, const std::vector<EffectSpec>& screws,
                      bool laser) {
  std::vector<std::string> linear;
  for (const Joint& j : machine.joints())
    if (j.kind == JointKind::kLinear) linear.push_back(j.name);
  std::string text;
  for (const std::string& name : linear) text += "  - {type: scale, axis: " + name + "}\n";
  for (std::size_t i = 0; i < linear.size(); ++i)
    for (std::size_t j = i + 1; j < linear.size(); ++j)
      text += "  - {type: squareness, axis: " + linear[i] + ", of: " + linear[j] + "}\n";
  for (const EffectSpec& screw : screws) text += "  - " + screw.yaml() + "\n";
  if (laser) text += "  - {type: laser_mount}\n";
  return "machine: " + urdf + "\neffects:" + (text.empty() ? " []\n" : "\n" + text);
}

void runNewMachine(MachineOptions& o) {
  o.files.output("-o", o.output, FileKind::kMachine);
  o.files.output("--model", o.model, FileKind::kModel);
  o.files.check();
  namespace fs = std::filesystem;
  NewMachine machine;
  machine.name = fs::path(o.output).stem().string();
  for (const std::string& text : o.axes) machine.axes.push_back(axisOf(text));
  machine.tip = vectorOf("--tip-mm", o.tip) * kMillimetre;
  machine.speed = o.speed * kMillimetre;
  const std::string urdf = newMachineUrdf(machine);
  const Machine read(urdf, machine.name);  // what is written can be read
  std::vector<EffectSpec> screws;
  for (const std::string& text : o.leads) screws.push_back(periodicError(text, read));
  if (!screws.empty() && o.model.empty())
    throw InputError("--lead: the lead is written to the model; add --model model.yaml");
  o.files.write(o.output, urdf);
  std::cout << "machine '" << read.name() << "' with " << read.jointCount() << " axes written to " << o.output
            << "\nkinematic chain from workpiece (w) over bed (b) to probe (t): " << kinematicChain(read)
            << '\n';
  if (o.model.empty()) return;
  const fs::path folder = fs::absolute(o.model).parent_path();
  const std::string relative = fs::proximate(fs::absolute(o.output), folder).string();
  o.files.write(o.model, modelYaml(read, relative, screws, o.probe == "laser"));
  std::cout << "first model written to " << o.model << '\n';
}

}  // namespace

void addMachineCommand(CLI::App& app, int& exitStatus) {
  CLI::App* machine = app.add_subcommand("machine", "Create a machine description");
  machine->require_subcommand(1);
  auto [o, command] =
      addCommand<MachineOptions>(*machine, exitStatus, runNewMachine, "new",
                                 "Create a machine (URDF) and a first model from the travels of its axes");
  repeatedOption(
      command, "--axis", o.axes,
      "NAME=FROM:TOmm[@X,Y,Z] or NAME=FROM:TOdeg@X,Y,Z: name, travel and positive direction of an axis; "
      "repeatable")
      ->required();
  repeatedOption(
      command, "--lead", o.leads,
      "NAME=LENGTHmm: travel of an axis per turn of its screw; of a rotary axis NAME=ANGLEdeg, per "
      "turn of its worm; the model then fits the error that repeats with it; repeatable");
  standardOption(command, "--probe", o.probe, CLI::IsMember({"touch", "laser"}), "the probe");
  command.add_option("--tip-mm", o.tip, "X,Y,Z: position of the tip relative to the last axis")
      ->capture_default_str();
  standardOption(command, "--speed-mm-s", o.speed, numberWithin(1e-3, 1e4, "mm/s"),
                 "maximum speed of linear axes; of rotary axes, ten times this number in mrad/s");
  command.add_option("-o,--output", o.output, "the URDF to write; the file name is the name of the machine")
      ->required();
  command.add_option("--model", o.model, "also write a first model, YAML");
  o.files.declare(command);
  command.footer(
      "Give the axes in order from the workpiece to the probe. An axis that moves the table towards + has "
      "the\n"
      "direction -: relative to the workpiece, the probe moves towards -.\n"
      "Example:\n"
      "  mm machine new --axis x=0:300mm@-1,0,0 --axis y=0:200mm --axis z=-100:0mm --tip-mm 0,0,-60 \\\n"
      "     -o mill.urdf --model mill.yaml");
}

}  // namespace mm
