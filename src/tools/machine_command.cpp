#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <sstream>

#include "base/error.h"
#include "base/units.h"
#include "machine/iso230_axes.h"
#include "machine/new_machine.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/output_files.h"

namespace mm {
namespace {

struct MachineOptions {
  std::vector<std::string> axes;  // from the workpiece to the probe
  std::string tip = "0,0,0", probe = "touch", output, model;
  double speed = 20.0;  // mm/s
  OutputFiles files;
};

bool numberOf(const std::string& text, double& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
}

/// "0,0,-60". @throw InputError.
Eigen::Vector3d vectorOf(const std::string& option, const std::string& text) {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  std::istringstream in(text);
  int n = 0;
  for (std::string part; std::getline(in, part, ','); ++n)
    if (n > 2 || !numberOf(part, v[n])) n = 3;
  if (n != 3) throw InputError(option + ": '" + text + "' is not three numbers x,y,z");
  return v;
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
  if (!numberOf(travel.substr(equal + 1, colon - equal - 1), axis.lower) ||
      !numberOf(travel.substr(colon + 1, unit - colon - 1), axis.upper))
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

/// What every machine has: scales, and axes that are not square; of a laser, where it is mounted.
std::string modelYaml(const Machine& machine, const std::string& urdf, bool laser) {
  std::string text = "machine: " + urdf + "\neffects:\n";
  std::vector<std::string> linear;
  for (const Joint& j : machine.joints())
    if (j.kind == JointKind::kLinear) linear.push_back(j.name);
  for (const std::string& name : linear) text += "  - {type: scale, axis: " + name + "}\n";
  for (std::size_t i = 0; i < linear.size(); ++i)
    for (std::size_t j = i + 1; j < linear.size(); ++j)
      text += "  - {type: squareness, axis: " + linear[i] + ", of: " + linear[j] + "}\n";
  if (laser) text += "  - {type: laser_mount}\n";
  return linear.empty() && !laser ? "machine: " + urdf + "\neffects: []\n" : text;
}

void runNew(MachineOptions& o) {
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
  o.files.write(o.output, urdf);
  std::cout << "machine '" << read.name() << "' with " << read.jointCount() << " axes written to " << o.output
            << "\nkinematic chain from workpiece (w) over bed (b) to probe (t): " << kinematicChain(read)
            << '\n';
  if (o.model.empty()) return;
  const fs::path folder = fs::absolute(o.model).parent_path();
  const std::string relative = fs::proximate(fs::absolute(o.output), folder).string();
  o.files.write(o.model, modelYaml(read, relative, o.probe == "laser"));
  std::cout << "first model written to " << o.model << '\n';
}

}  // namespace

void addMachineCommand(CLI::App& app, int& /*exitStatus*/) {
  auto o = std::make_shared<MachineOptions>();
  CLI::App* machine = app.add_subcommand("machine", "Create a machine description");
  machine->require_subcommand(1);
  CLI::App* command = machine->add_subcommand(
      "new", "Create a machine (URDF) and a first model from the travels of its axes");
  command
      ->add_option(
          "--axis", o->axes,
          "NAME=FROM:TOmm[@X,Y,Z] or NAME=FROM:TOdeg@X,Y,Z: name, travel and positive direction of an axis; "
          "repeatable")
      ->required()
      ->take_all()
      ->allow_extra_args(false);
  command->add_option("--probe", o->probe, "the probe")
      ->capture_default_str()
      ->check(CLI::IsMember({"touch", "laser"}));
  command->add_option("--tip-mm", o->tip, "X,Y,Z: position of the tip relative to the last axis")
      ->capture_default_str();
  command
      ->add_option("--speed-mm-s", o->speed,
                   "maximum speed of linear axes; of rotary axes, ten times this number in mrad/s")
      ->capture_default_str()
      ->check(numberWithin(1e-3, 1e4, "mm/s"));
  command->add_option("-o,--output", o->output, "the URDF to write; the file name is the name of the machine")
      ->required();
  command->add_option("--model", o->model, "also write a first model, YAML");
  o->files.declare(*command);
  command->footer(
      "Give the axes in order from the workpiece to the probe. An axis that moves the table towards + has "
      "the\n"
      "direction -: relative to the workpiece, the probe moves towards -.\n"
      "Example:\n"
      "  mm machine new --axis x=0:300mm@-1,0,0 --axis y=0:200mm --axis z=-100:0mm --tip-mm 0,0,-60 \\\n"
      "     -o mill.urdf --model mill.yaml");
  command->callback([o] { runNew(*o); });
}

}  // namespace mm
