#pragma once
#include <string>

#include "report/dcc_signature.h"

namespace mm {

// Names of the identifications of a digital certificate.
inline constexpr const char* kDccCalibrationId = "calibration id";
inline constexpr const char* kDccFileChecksum = "CRC-64 of the calibration file";
inline constexpr const char* kDccSessionHash = "hash of the session";

/// What a digital certificate says of itself.
struct DccContents {
  std::string number, calibration, checksum, session;  // those of CertificateSeal; empty: not told
  bool signatureAnnounced = false;                     // by the laboratory's data
  DccSignature signature;
};

/// Whether a file is to be read as a DCC: it has its root and is not a page or a PDF, whatever else stands in
/// it. A seal of these says nothing of it: everybody can append one.
bool isDcc(const std::string& content);

/// @throw InputError: no DCC, or a signature that does not cover the whole of it.
DccContents dccContents(const std::string& xml, const std::string& source);

}  // namespace mm
