#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "verification/calibration_changes.h"
#include "verification/trend.h"

namespace mm {

/// How many parameters have a trend, and which.
std::string trendSentence(const std::vector<ParameterTrend>& trends);
/// What `mm history --trend --json` prints. @param store its folder. @param left ids that were left out:
/// damaged, or of another machine.
std::string trendJson(const std::vector<ParameterTrend>& trends, const std::string& store,
                      const std::vector<std::string>& left);
/// The same as a table for people.
std::string trendText(const std::vector<ParameterTrend>& trends);
/// The same as one HTML file without links to others: a picture a parameter, significant trends first.
/// @param machine as in the calibrations. @param plotly as of loadReportFiles. @throw InputError as that.
std::string trendPage(const std::vector<ParameterTrend>& trends, const std::string& store,
                      const std::vector<std::string>& left, const std::string& machine,
                      const std::filesystem::path& plotly);

/// What `mm history --compare` prints.
std::string changesText(const CalibrationChanges& changes);

}  // namespace mm
