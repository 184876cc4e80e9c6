#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "calibration_file/calibration_store.h"
#include "report/iso_tests.h"
#include "session/session.h"
#include "uncertainty/task_verdict.h"

namespace mm {

/// What no file knows: said by whoever issues the certificate. Empty: not stated.
struct CertificateFacts {
  std::string serial, operatorName, authorisedBy, laboratory, customer, place, traceability, remark;
  std::string issued;  // ISO 8601, UTC
};

/// A task that the certificate states, with its decisions. Its figures are predicted: nobody measured them.
struct CertifiedTask {
  TaskUncertainty result;
  std::vector<TaskVerdict> verdicts;      // empty where conformity cannot be decided
  bool asked = false;                     // for conformity
  std::vector<std::string> noConformity;  // why it cannot be decided (decideConformity); empty: it can
};

/// How far the calibrated machine is off its scale along one axis, the others in the middle of their ranges.
struct CorrectionCurve {
  std::string axis, unit;                             // unit of `at`
  std::vector<double> at;                             // mm or deg
  std::vector<Eigen::Vector3d> correction, expanded;  // um, workpiece; expanded: k = 2
};

/// The calibration held against a session.
struct CertifiedSession {
  std::string path;
  bool sameSession = false;  // by which it was calibrated
  std::int64_t observations = 0;
  double uncorrected = kNotMeasured, corrected = kNotMeasured;  // RMS, m (rad where `angular`)
  bool angular = false;
  std::vector<AxisPositioning> positioning;
};

/// Something that happened to the calibrations of a machine in their store.
struct StoreEvent {
  std::string time, id;  // ISO 8601, UTC; of the calibration
  std::string what;  // "made active", "compared with fresh points: helped, 3.12 ± 0.08 → 0.31 ± 0.06 µm (k =
                     // 2) at 54 points"
  std::string until;  // of what was made active: when another one was; empty: it still is, or none
};

/// What the store knows of a calibration and of those before and after it.
struct StoreRecord {
  std::string folder;
  bool active = false;             // at the time of issue
  std::vector<StoreEvent> events;  // oldest first
};

/// @return empty where the store does not keep the calibration. Calibrations of other machines in the store
/// are left out. @throw InputError: the store cannot be read.
std::optional<StoreRecord> storeRecord(const CalibrationStore& store, const Calibration& calibration);

/// Everything that stands on a certificate.
struct Certificate {
  Calibration calibration;
  std::string number;    // of this issue
  std::string replaces;  // number of the issue that it replaces; empty: none is known
  CertificateFacts facts;
  std::vector<CertifiedTask> tasks;
  TaskConditions conditions;  // under which they are predicted; what they state of the reference too
  int points = 0;             // of a feature, as TaskOptions
  std::vector<CorrectionCurve> curves;
  std::optional<CertifiedSession> session;
  std::optional<StoreRecord> store;  // empty: no store keeps it
  std::string checksum;              // CRC-64 of the calibration's file
};

/// Curves of the correction over each axis that was calibrated over a range, by as many points as follow it;
/// none where an input is not known.
std::vector<CorrectionCurve> correctionCurves(const Calibration& calibration);

/// The page: one HTML file without script or links, laid out for A4. Names from users' files are data, never
/// markup. @throw InputError: a file of the package is missing.
std::string certificatePage(const Certificate& certificate);

}  // namespace mm
