#pragma once
#include <string>

#include "report/certificate_seal.h"

namespace tinyxml2 {
class XMLElement;
}

namespace mm {

// What a digital certificate says of itself, and its enveloped XML signature (W3C, XML Signature Syntax and
// Processing 1.1): what it covers and with which key. The cryptography is xmlsec1's.

// Names of the identifications of a digital certificate.
inline constexpr const char* kDccCalibrationId = "calibration id";
inline constexpr const char* kDccFileChecksum = "CRC-64 of the calibration file";
inline constexpr const char* kDccSessionHash = "hash of the session";

/// What the signature states of a private key, never the key itself.
struct SigningKey {
  std::string method;       // URI of the signature's algorithm
  std::string publicKey;    // SubjectPublicKeyInfo, DER, base64
  std::string certificate;  // X.509, DER, base64; empty: the file has none
  std::string fingerprint;  // SHA-256 of the public key's DER, hexadecimal
};

/// @param pem a private key, RSA of 2048 bits or more or EC, and perhaps its X.509 certificate. @param source
/// path for messages. @throw InputError: no such key, encrypted, too short; a certificate of another key.
SigningKey signingKeyOf(const std::string& pem, const std::string& source);

/// SHA-256 of a public key: of a PEM file with it, with its private key or with its certificate.
/// @throw InputError: the file has none.
std::string fingerprintIn(const std::string& pem, const std::string& source);

/// Puts the signature at the end of the root, its values empty: xmlsec1 fills them in.
void addSignatureTemplate(tinyxml2::XMLElement& root, const SigningKey& key);

/// The signature of a document.
struct DccSignature {
  bool there = false;       // else it is not signed
  std::string publicKey;    // PEM, of the key that the document names
  std::string fingerprint;  // of it
};

/// What a digital certificate says of itself: what a seal says, but for the SHA-256; empty: not told.
struct DccContents : CertificateSeal {
  bool signatureAnnounced = false;  // by the laboratory's data
  DccSignature signature;
};

/// Whether a file is to be read as a DCC: it has its root and is not a page or a PDF, whatever else stands in
/// it. A seal of these says nothing of it: everybody can append one.
bool isDcc(const std::string& content);

/// @throw InputError: no DCC; it has several signatures, or one that does not cover the whole document in the
/// form that mm writes.
DccContents dccContents(const std::string& xml, const std::string& source);

}  // namespace mm
