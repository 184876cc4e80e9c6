#pragma once
#include <filesystem>
#include <string>

namespace mm {

/// @throw InputError: xmlsec1, which signs and verifies XML, is not on the path.
void requireXmlSigner();

/// Fills in the signature that stands empty in a document. @param key file of the private key. @param name of
/// the key in the document. @throw InputError: it cannot be signed; the message says why.
std::string signedXml(const std::string& prepared, const std::filesystem::path& key, const std::string& name);

/// Whether the signature of a document is valid for a public key (PEM). @param name of the key in the
/// document. @throw InputError: xmlsec1 cannot be run.
bool signatureIsValid(const std::string& xml, const std::string& publicKey, const std::string& name);

}  // namespace mm
