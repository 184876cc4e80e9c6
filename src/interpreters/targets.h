#pragma once
#include <filesystem>
#include <memory>

#include "interpreters/interpreter.h"

namespace mm {

/// Each reads the files of its target in `folder`; files, rules and sources in docs/interpreters.md.
/// @throw InputError for what the controller would refuse.
std::unique_ptr<Interpreter> interpretLinuxcnc(const std::filesystem::path& folder);
std::unique_ptr<Interpreter> interpretKlipper(const std::filesystem::path& folder);
std::unique_ptr<Interpreter> interpretMarlin(const std::filesystem::path& folder);
std::unique_ptr<Interpreter> interpretReprapfirmware(const std::filesystem::path& folder);
std::unique_ptr<Interpreter> interpretGrblhal(const std::filesystem::path& folder);
std::unique_ptr<Interpreter> interpretSiemens(const std::filesystem::path& folder);
std::unique_ptr<Interpreter> interpretHeidenhain(const std::filesystem::path& folder);
std::unique_ptr<Interpreter> interpretFanuc(const std::filesystem::path& folder);
std::unique_ptr<Interpreter> interpretBeckhoff(const std::filesystem::path& folder);
std::unique_ptr<Interpreter> interpretIsg(const std::filesystem::path& folder);
std::unique_ptr<Interpreter> interpretCsv(const std::filesystem::path& folder);

}  // namespace mm
