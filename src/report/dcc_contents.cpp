#include "report/dcc_contents.h"

#include <tinyxml2.h>

#include "base/error.h"
#include "base/text.h"

namespace mm {
namespace {

std::string textBelow(const tinyxml2::XMLElement* parent, const char* name) {
  const tinyxml2::XMLElement* element = parent == nullptr ? nullptr : parent->FirstChildElement(name);
  return element == nullptr || element->GetText() == nullptr ? std::string() : element->GetText();
}

}  // namespace

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
  const tinyxml2::XMLElement* root = read ? document.RootElement() : nullptr;
  if (root == nullptr || std::string(root->Name()) != "dcc:digitalCalibrationCertificate")
    throw InputError(source +
                     ": is no digital calibration certificate (dcc:digitalCalibrationCertificate), or is "
                     "truncated; name another file");
  DccContents found;
  const tinyxml2::XMLElement* data = root->FirstChildElement("dcc:administrativeData");
  const tinyxml2::XMLElement* core = data == nullptr ? nullptr : data->FirstChildElement("dcc:coreData");
  found.number = textBelow(core, "dcc:uniqueIdentifier");
  const tinyxml2::XMLElement* ids =
      core == nullptr ? nullptr : core->FirstChildElement("dcc:identifications");
  for (const tinyxml2::XMLElement* id = ids == nullptr ? nullptr
                                                       : ids->FirstChildElement("dcc:identification");
       id != nullptr; id = id->NextSiblingElement("dcc:identification")) {
    const std::string name = textBelow(id->FirstChildElement("dcc:name"), "dcc:content"),
                      value = textBelow(id, "dcc:value");
    if (name == kDccCalibrationId) found.calibration = value;
    if (name == kDccFileChecksum) found.checksum = value;
    if (name == kDccSessionHash) found.session = value;
  }
  const tinyxml2::XMLElement* laboratory =
      data == nullptr ? nullptr : data->FirstChildElement("dcc:calibrationLaboratory");
  found.signatureAnnounced = textBelow(laboratory, "dcc:cryptElectronicSignature") == "true";
  found.signature = signatureIn(*root, source);
  return found;
}

}  // namespace mm
