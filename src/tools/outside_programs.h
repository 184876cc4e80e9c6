#pragma once
#include <filesystem>
#include <string>

namespace mm {

// What `mm certificate` leaves to programs that are made for it. @throw InputError, all of them: the program
// is not on the path, or failed; the message says what to do.

/// WeasyPrint, which prints a page on paper, is there.
void requirePdfPrinter();
/// Prints a page on paper. @param html the page, one file. @return the bytes of the PDF.
std::string printedPdf(const std::string& html);

/// xmlsec1, which signs and verifies XML, is there.
void requireXmlSigner();
/// Fills in the signature that stands empty in a document. @param key file of the private key. @param name of
/// the key in the document.
std::string signedXml(const std::string& prepared, const std::filesystem::path& key, const std::string& name);
/// Whether the signature of a document is valid for a public key (PEM). @param name of the key in the
/// document.
bool signatureIsValid(const std::string& xml, const std::string& publicKey, const std::string& name);

}  // namespace mm
