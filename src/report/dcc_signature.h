#pragma once
#include <string>

namespace tinyxml2 {
class XMLElement;
}

namespace mm {

// XML signature (W3C, XML Signature Syntax and Processing 1.1) that is enveloped in a document: what it
// covers and with which key. The cryptography is xmlsec1's.

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
  bool there = false;
  std::string publicKey;    // PEM, of the key that the document names
  std::string fingerprint;  // of it
};

/// @return `there` false: it is not signed. @throw InputError: it has several signatures, or one that does
/// not cover the whole document in the form that mm writes.
DccSignature signatureIn(const tinyxml2::XMLElement& root, const std::string& source);

}  // namespace mm
