#pragma once
#include <filesystem>
#include <string>

#include "calibration_file/calibration.h"

namespace mm {

/// Version of the layout written here. A reader refuses what is newer.
inline constexpr int kCalibrationSchema = 1;

/// The file's text. Its first line is the checksum of every byte that follows, so that any damage is found;
/// numbers are SI and read back to the bit; a comment beside each parameter gives it in the unit of people.
/// @throw InputError when the calibration contradicts itself (sizes, indices).
std::string calibrationYaml(const Calibration& calibration);

/// @param source path for messages. @throw InputError: damaged, newer schema, unknown, missing or unfit key,
/// by name.
Calibration parseCalibration(const std::string& text, const std::string& source);

/// Completes `id`, `created` and `software` where they are empty. The id is the UTC stamp and the first
/// digits of the checksum of the content.
void completeCalibration(Calibration& calibration);

/// Completes and writes one file, atomically. @throw InputError: full disk, no permission, bad path.
void saveCalibration(Calibration& calibration, const std::filesystem::path& file);
/// @throw InputError as parseCalibration, or when it cannot be read.
Calibration loadCalibration(const std::filesystem::path& file);

}  // namespace mm
