#include "report/report_curve.h"

#include <cmath>
#include <sstream>

#include "base/error.h"
#include "base/number_text.h"
#include "calibration_file/atomic_file.h"

namespace mm {

ConvergenceCurve readConvergenceCurve(const std::filesystem::path& file) {
  const std::string name = file.string();
  ConvergenceCurve curve;
  curve.name = file.filename().string();
  std::istringstream in(readFile(file));
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (number == 1) {
      curve.angular = line == "generation,rms_arcsec";
      if (!curve.angular && line != "generation,rms_um")
        throw InputError(name +
                         ": line 1: the columns must be generation,rms_um or generation,rms_arcsec; mm "
                         "calibrate --curve " +
                         name + " writes such a file");
      continue;
    }
    if (line.empty()) continue;
    const std::size_t comma = line.find(',');
    double generation = 0.0, rms = 0.0;
    if (comma == std::string::npos || !parseNumber(line.substr(0, comma), generation) ||
        !parseNumber(line.substr(comma + 1), rms) || !std::isfinite(generation) || !std::isfinite(rms))
      throw InputError(name + ": line " + std::to_string(number) + ": '" + line +
                       "' is not a generation and an RMS, e.g. 12,0.61");
    curve.generation.push_back(generation);
    curve.rms.push_back(rms);
  }
  if (curve.rms.empty())
    throw InputError(name +
                     ": contains no generation; a calibration by least_squares has no curve, use --method "
                     "staged_mutation or niching");
  return curve;
}

}  // namespace mm
