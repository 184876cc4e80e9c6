#pragma once
#include <CLI/CLI.hpp>
#include <map>
#include <string>

#include "diagnosis/diagnose.h"

namespace mm {

/// `--method search|posterior`, which --help does not list.
inline void addMethodOption(CLI::App& command, DiagnosisMethod& method) {
  static const std::map<std::string, DiagnosisMethod> names = {{"search", DiagnosisMethod::kSearch},
                                                               {"posterior", DiagnosisMethod::kPosterior}};
  command.add_option("--method", method, "how causes are found: search or posterior")
      ->transform(CLI::CheckedTransformer(names))
      ->group("");
}

}  // namespace mm
