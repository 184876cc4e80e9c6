#pragma once
#include <string>

#include "model/model_spec.h"

namespace mm {

// YAML that a page sent. What it names is never opened as a file: the files of this computer are not the
// page's.

/// @throw InputError as parseModelSpec; the machine is a path.
ModelSpec sentModel(const std::string& yaml);

/// The text of a plan as it may be handed on. @throw InputError: there is none; no YAML; its artifact is a
/// path.
std::string sentPlan(const std::string& yaml);

}  // namespace mm
