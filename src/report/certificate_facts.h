#pragma once
#include <string>
#include <vector>

#include "report/certificate.h"

namespace mm {

// What a certificate says in words: page and digital certificate have it from here. Units as they are typed.

/// What is stated of something.
struct StatedFact {
  std::string name, text;
};

/// Whether the issuer knows it: neither empty nor "unknown".
bool isKnown(const std::string& fact);

/// Whether nobody measured: no certificate of a machine comes of it.
bool isSimulated(const Calibration& calibration);
inline constexpr const char* kSimulatedNotice = "SIMULATED: not a calibration of a machine";

/// "Calibration certificate"; "Record of calibration" where laboratory, serial number, customer, who answers
/// for it, traceability or date of measurement is not known (ISO/IEC 17025:2017, 7.8.2).
std::string titleOf(const Certificate& certificate);

/// When it was measured, ISO 8601, UTC; empty: its session has no date.
std::string dateOfMeasurement(const Calibration& calibration);

/// Under which conditions the tasks are predicted. What the issuer stated is marked, with what it replaces.
std::vector<StatedFact> conditionsOfPrediction(const Certificate& certificate);

/// Over which ranges the axes, and the covariates, were calibrated: "-12 to 12 mm".
std::vector<StatedFact> axisRanges(const Domain& domain);
std::vector<StatedFact> covariateRanges(const Domain& domain);

/// By which rule conformity is stated and what it rests on, or why none is stated.
std::string decisionRule(const Certificate& certificate);

/// What the results are valid for: item, ranges, reference temperature.
std::string scopeOfResults(const Calibration& calibration);

}  // namespace mm
