#include "report/dcc_signature.h"

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <tinyxml2.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "base/error.h"
#include "base/text.h"

namespace mm {
namespace {

constexpr const char* kExclusive = "http://www.w3.org/2001/10/xml-exc-c14n#";
constexpr const char* kEnveloped = "http://www.w3.org/2000/09/xmldsig#enveloped-signature";
constexpr const char* kSha256 = "http://www.w3.org/2001/04/xmlenc#sha256";
constexpr const char* kRsaSha256 = "http://www.w3.org/2001/04/xmldsig-more#rsa-sha256";
constexpr const char* kEcdsaSha256 = "http://www.w3.org/2001/04/xmldsig-more#ecdsa-sha256";
constexpr const char* kDerNamespace = "http://www.w3.org/2009/xmldsig11#";
constexpr int kShortestRsa = 2048;  // bits

template <typename T, void (*release)(T*)>
struct Releaser {
  void operator()(T* t) const { release(t); }
};
using PublicKeyPointer = std::unique_ptr<EVP_PKEY, Releaser<EVP_PKEY, EVP_PKEY_free>>;
using X509Pointer = std::unique_ptr<X509, Releaser<X509, X509_free>>;
using BioPointer = std::unique_ptr<BIO, Releaser<BIO, BIO_free_all>>;

BioPointer bioOf(const std::string& bytes) {
  return BioPointer(BIO_new_mem_buf(bytes.data(), static_cast<int>(bytes.size())));
}

/// Asked for the password of an encrypted key: none, instead of waiting at the terminal.
int noPassword(char* /*buffer*/, int /*size*/, int /*writing*/, void* /*asked*/) { return -1; }

std::string base64Of(const std::vector<unsigned char>& bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  const int size = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), bytes.data(),
                                   static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(size));
  return text;
}

std::vector<unsigned char> bytesOf(const std::string& base64) {
  std::string packed;
  for (const char c : base64)
    if (kBlanks.find(c) == std::string_view::npos) packed += c;
  std::vector<unsigned char> bytes(3 * (packed.size() / 4) + 3);
  const int size = packed.size() % 4 != 0
                       ? -1
                       : EVP_DecodeBlock(bytes.data(), reinterpret_cast<const unsigned char*>(packed.data()),
                                         static_cast<int>(packed.size()));
  if (size < 0) return {};
  const std::size_t padding = packed.size() - std::min(packed.size(), packed.find_last_not_of('=') + 1);
  bytes.resize(static_cast<std::size_t>(size) - std::min<std::size_t>(padding, 2));
  return bytes;
}

std::vector<unsigned char> derOf(EVP_PKEY* key) {
  unsigned char* der = nullptr;
  const int size = i2d_PUBKEY(key, &der);
  std::vector<unsigned char> bytes(der, der + std::max(size, 0));
  OPENSSL_free(der);
  return bytes;
}

std::string fingerprintOf(const std::vector<unsigned char>& der) {
  return sha256Of(std::string(der.begin(), der.end()));
}

X509Pointer certificateIn(const std::string& pem) {
  const BioPointer bio = bioOf(pem);
  return X509Pointer(PEM_read_bio_X509(bio.get(), nullptr, noPassword, nullptr));
}

PublicKeyPointer privateKeyIn(const std::string& pem) {
  const BioPointer bio = bioOf(pem);
  return PublicKeyPointer(PEM_read_bio_PrivateKey(bio.get(), nullptr, noPassword, nullptr));
}

using tinyxml2::XMLConstHandle;
using tinyxml2::XMLElement;

XMLElement* addElement(XMLElement& parent, const char* name, const char* algorithm = nullptr) {
  XMLElement* element = parent.InsertNewChildElement(name);
  if (algorithm != nullptr) element->SetAttribute("Algorithm", algorithm);
  return element;
}

/// Name without its prefix.
std::string localName(const XMLElement& element) {
  const std::string name = element.Name();
  return name.substr(name.find(':') + 1);
}

std::vector<const XMLElement*> childrenNamed(const XMLElement& parent, const std::string& name) {
  std::vector<const XMLElement*> all;
  for (const XMLElement* e = parent.FirstChildElement(); e != nullptr; e = e->NextSiblingElement())
    if (localName(*e) == name) all.push_back(e);
  return all;
}

const XMLElement* onlyChild(const XMLElement* parent, const std::string& name) {
  if (parent == nullptr) return nullptr;
  const auto all = childrenNamed(*parent, name);
  return all.size() == 1 ? all.front() : nullptr;
}

bool hasAlgorithm(const XMLElement* element, const std::string& algorithm) {
  const char* is = element == nullptr ? nullptr : element->Attribute("Algorithm");
  return is != nullptr && is == algorithm;
}

std::size_t signaturesBelow(const XMLElement& parent) {
  std::size_t count = 0;
  for (const XMLElement* e = parent.FirstChildElement(); e != nullptr; e = e->NextSiblingElement())
    count += (localName(*e) == "Signature" ? 1 : 0) + signaturesBelow(*e);
  return count;
}

/// Whether it covers the whole document, itself left out, with algorithms that are not broken.
bool coversTheDocument(const XMLElement& signature) {
  const XMLElement* info = onlyChild(&signature, "SignedInfo");
  const XMLElement* reference = onlyChild(info, "Reference");
  const XMLElement* transforms = onlyChild(reference, "Transforms");
  if (transforms == nullptr) return false;
  const char* uri = reference->Attribute("URI");
  const auto steps = childrenNamed(*transforms, "Transform");
  const XMLElement* method = onlyChild(info, "SignatureMethod");
  return uri != nullptr && *uri == '\0' && steps.size() == 2 && hasAlgorithm(steps[0], kEnveloped) &&
         hasAlgorithm(steps[1], kExclusive) && steps[0]->NoChildren() && steps[1]->NoChildren() &&
         hasAlgorithm(onlyChild(info, "CanonicalizationMethod"), kExclusive) &&
         hasAlgorithm(onlyChild(reference, "DigestMethod"), kSha256) &&
         (hasAlgorithm(method, kRsaSha256) || hasAlgorithm(method, kEcdsaSha256)) &&
         childrenNamed(signature, "Object").empty();
}

std::string pemOf(const std::vector<unsigned char>& der) {
  std::string body = base64Of(der), pem = "-----BEGIN PUBLIC KEY-----\n";
  for (std::size_t at = 0; at < body.size(); at += 64) pem += body.substr(at, 64) + "\n";
  return pem + "-----END PUBLIC KEY-----\n";
}

DccSignature signatureIn(const XMLElement& root, const std::string& source) {
  const std::size_t count = signaturesBelow(root);
  if (count == 0) return {};
  const XMLElement* signature = onlyChild(&root, "Signature");
  const XMLElement* key =
      signature == nullptr ? nullptr : onlyChild(onlyChild(signature, "KeyInfo"), "DEREncodedKeyValue");
  if (count != 1 || signature == nullptr || signature != root.LastChildElement() ||
      !coversTheDocument(*signature) || key == nullptr || key->GetText() == nullptr)
    throw InputError(source +
                     ": its signature does not cover the whole document in the form that mm writes; verify "
                     "it with the program that signed it");
  const std::vector<unsigned char> der = bytesOf(key->GetText());
  DccSignature found;
  found.there = true;
  found.publicKey = pemOf(der);
  found.fingerprint = fingerprintIn(found.publicKey, source);
  const XMLElement* name = onlyChild(onlyChild(signature, "KeyInfo"), "KeyName");
  if (name == nullptr || name->GetText() == nullptr || name->GetText() != found.fingerprint)
    throw InputError(source +
                     ": its signature names another key than it carries; ask the issuer for the original");
  return found;
}

std::string textBelow(const XMLConstHandle& parent, const char* name) {
  const XMLElement* element = parent.FirstChildElement(name).ToElement();
  return element == nullptr || element->GetText() == nullptr ? std::string() : element->GetText();
}

}  // namespace

SigningKey signingKeyOf(const std::string& pem, const std::string& source) {
  const PublicKeyPointer key = privateKeyIn(pem);
  if (!key)
    throw InputError(
        source + (pem.find("ENCRYPTED") != std::string::npos
                      ? ": the key is encrypted; give one without a password: openssl pkey -in KEY -out PLAIN"
                      : ": no private key in PEM; make one with openssl genpkey -algorithm RSA -pkeyopt "
                        "rsa_keygen_bits:3072 -out key.pem"));
  const int type = EVP_PKEY_base_id(key.get());
  if (type != EVP_PKEY_EC && (type != EVP_PKEY_RSA || EVP_PKEY_bits(key.get()) < kShortestRsa))
    throw InputError(source + ": is neither an RSA key of 2048 bits or more nor an EC key; name another one");
  const std::vector<unsigned char> der = derOf(key.get());
  SigningKey stated;
  stated.method = type == EVP_PKEY_EC ? kEcdsaSha256 : kRsaSha256;
  stated.publicKey = base64Of(der);
  stated.fingerprint = fingerprintOf(der);
  if (const X509Pointer certificate = certificateIn(pem)) {
    EVP_PKEY* certified = X509_get0_pubkey(certificate.get());
    if (certified == nullptr || derOf(certified) != der)
      throw InputError(source + ": its X.509 certificate is of another key; put that of this key first");
    unsigned char* bytes = nullptr;
    const int size = i2d_X509(certificate.get(), &bytes);
    stated.certificate = base64Of({bytes, bytes + std::max(size, 0)});
    OPENSSL_free(bytes);
  }
  return stated;
}

std::string fingerprintIn(const std::string& pem, const std::string& source) {
  if (const X509Pointer certificate = certificateIn(pem))
    if (EVP_PKEY* key = X509_get0_pubkey(certificate.get())) return fingerprintOf(derOf(key));
  const BioPointer bio = bioOf(pem);
  PublicKeyPointer key(PEM_read_bio_PUBKEY(bio.get(), nullptr, noPassword, nullptr));
  if (!key) key = privateKeyIn(pem);
  if (!key)
    throw InputError(source + ": no public key, private key or X.509 certificate in PEM; name the issuer's");
  return fingerprintOf(derOf(key.get()));
}

void addSignatureTemplate(XMLElement& root, const SigningKey& key) {
  XMLElement* signature = addElement(root, "ds:Signature");
  signature->SetAttribute("xmlns:ds", "http://www.w3.org/2000/09/xmldsig#");
  XMLElement* info = addElement(*signature, "ds:SignedInfo");
  addElement(*info, "ds:CanonicalizationMethod", kExclusive);
  addElement(*info, "ds:SignatureMethod", key.method.c_str());
  XMLElement* reference = addElement(*info, "ds:Reference");
  reference->SetAttribute("URI", "");
  XMLElement* transforms = addElement(*reference, "ds:Transforms");
  addElement(*transforms, "ds:Transform", kEnveloped);
  addElement(*transforms, "ds:Transform", kExclusive);
  addElement(*reference, "ds:DigestMethod", kSha256);
  addElement(*reference, "ds:DigestValue");
  addElement(*signature, "ds:SignatureValue");
  XMLElement* about = addElement(*signature, "ds:KeyInfo");
  addElement(*about, "ds:KeyName")->SetText(key.fingerprint.c_str());
  if (!key.certificate.empty())
    addElement(*addElement(*about, "ds:X509Data"), "ds:X509Certificate")->SetText(key.certificate.c_str());
  XMLElement* bytes = addElement(*about, "dsig11:DEREncodedKeyValue");
  bytes->SetAttribute("xmlns:dsig11", kDerNamespace);
  bytes->SetText(key.publicKey.c_str());
}

bool isDcc(const std::string& content) {
  return !startsWith(content, "%PDF-") && !startsWith(content, "<!DOCTYPE html>") &&
         content.find("digitalCalibrationCertificate") != std::string::npos;
}

DccContents dccContents(const std::string& xml, const std::string& source) {
  tinyxml2::XMLDocument document;
  // A type definition could make other programs read another text than this one.
  const bool read = document.Parse(xml.data(), xml.size()) == tinyxml2::XML_SUCCESS &&
                    document.RootElement() != nullptr && xml.find("<!DOCTYPE") == std::string::npos &&
                    xml.find("<!ENTITY") == std::string::npos;
  const XMLElement* root = read ? document.RootElement() : nullptr;
  if (root == nullptr || std::string(root->Name()) != "dcc:digitalCalibrationCertificate")
    throw InputError(source +
                     ": is no digital calibration certificate (dcc:digitalCalibrationCertificate), or is "
                     "truncated; name another file");
  DccContents found;
  const XMLConstHandle data = XMLConstHandle(root).FirstChildElement("dcc:administrativeData"),
                       core = data.FirstChildElement("dcc:coreData"),
                       ids = core.FirstChildElement("dcc:identifications");
  found.number = textBelow(core, "dcc:uniqueIdentifier");
  for (const XMLElement* id = ids.FirstChildElement("dcc:identification").ToElement(); id != nullptr;
       id = id->NextSiblingElement("dcc:identification")) {
    const std::string name = textBelow(XMLConstHandle(id).FirstChildElement("dcc:name"), "dcc:content"),
                      value = textBelow(XMLConstHandle(id), "dcc:value");
    if (name == kDccCalibrationId) found.calibration = value;
    if (name == kDccFileChecksum) found.checksum = value;
    if (name == kDccSessionHash) found.session = value;
  }
  found.signatureAnnounced = textBelow(data.FirstChildElement("dcc:calibrationLaboratory"),
                                       "dcc:cryptElectronicSignature") == "true";
  found.signature = signatureIn(*root, source);
  return found;
}

}  // namespace mm
