#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace mm {

/// Convergence of a genetic algorithm: the best RMS of each generation.
struct ConvergenceCurve {
  std::string name;  // of the file, without its folder
  bool angular = false;
  std::vector<double> generation, rms;  // um, or arcsec where angular
};

/// Reads what `mm calibrate --curve` writes. @throw InputError naming file, line and remedy.
ConvergenceCurve readConvergenceCurve(const std::filesystem::path& file);

}  // namespace mm
