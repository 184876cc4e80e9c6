#include "workbench/sent_yaml.h"

#include "base/error.h"
#include "base/text.h"
#include "base/yaml_mapping.h"

namespace mm {

ModelSpec sentModel(const std::string& yaml) {
  ModelSpec spec = parseModelSpec(yaml, "model");
  if (spec.machine.find('/') != std::string::npos || spec.machine.find(".urdf") != std::string::npos)
    throw InputError("model: the machine '" + spec.machine.substr(0, 80) +
                     "' is a file; omit 'machine', as the session contains it, or give a name such as "
                     "three_axis");
  return spec;
}

std::string sentPlan(const std::string& yaml) {
  if (trim(yaml).empty()) throw InputError("no plan was sent; paste one (mm plan new makes one)");
  const YAML::Node plan = YamlMapping::load(yaml, "plan");
  if (!plan.IsMap())
    throw InputError("plan:1: is '" + std::string(trim(yaml).substr(0, 80)) +
                     "', which is not a plan; paste the text of a plan, paths are not opened");
  if (plan["artifact"] && plan["artifact"].IsScalar())
    throw InputError("plan:" + std::to_string(plan["artifact"].Mark().line + 1) + ": the artifact is '" +
                     plan["artifact"].Scalar().substr(0, 80) +
                     "', a file; replace it by the contents of that file");
  return yaml + "\n";  // what is one line is a text all the same, and no path
}

}  // namespace mm
