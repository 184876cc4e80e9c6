#include "report/dcc.h"

#include <tinyxml2.h>

#include <algorithm>
#include <boost/locale/utf.hpp>
#include <cmath>
#include <map>
#include <sstream>

#include "base/format.h"
#include "base/text.h"
#include "base/units.h"
#include "base/version.h"
#include "report/certificate_facts.h"
#include "report/certificate_figures.h"

namespace mm {
namespace {

using tinyxml2::XMLElement;

constexpr const char* kDccVersion = "3.3.0";
constexpr const char* kNotStated = "not stated";
constexpr const char* kUnknownCountry = "ZZ";  // of ISO 3166-1, left to its users
constexpr const char* kCoverageFactor = "2";

/// Text as XML may hold it: UTF-8 without control characters, no blanks at its ends, never empty.
std::string xmlText(const std::string& text) {
  using Utf8 = boost::locale::utf::utf_traits<char>;
  std::string clean;
  for (auto at = text.begin(); at != text.end();) {
    const auto begin = at;
    const auto c = Utf8::decode(at, text.end());
    const bool noCharacter = !boost::locale::utf::is_valid_codepoint(c) || c == 0xFFFE || c == 0xFFFF;
    if (noCharacter) at = begin + 1;
    clean += noCharacter ? "?" : c < 0x20 || c == 0x7F ? " " : std::string(begin, at);
  }
  const std::string trimmed(trim(clean));
  return trimmed.empty() ? kNotStated : trimmed;
}

XMLElement& add(XMLElement& parent, const char* name) { return *parent.InsertNewChildElement(name); }

void addLeaf(XMLElement& parent, const char* name, const std::string& text) {
  add(parent, name).SetText(xmlText(text).c_str());
}

/// An element with text in a language: dcc:textType, dcc:richContentType.
XMLElement& addText(XMLElement& parent, const char* name, const std::string& text) {
  XMLElement& element = add(parent, name);
  XMLElement& content = add(element, "dcc:content");
  content.SetAttribute("lang", "en");
  content.SetText(xmlText(text).c_str());
  return element;
}

/// dcc:contactType: who, and where.
void addContact(XMLElement& parent, const char* name, const std::string& who, const std::string& place) {
  XMLElement& contact = add(parent, name);
  addText(contact, "dcc:name", who);
  addText(add(contact, "dcc:location"), "dcc:further", place);
}

void addIdentification(XMLElement& list, const char* issuer, const std::string& value, const char* name) {
  XMLElement& identification = add(list, "dcc:identification");
  addLeaf(identification, "dcc:issuer", issuer);
  addLeaf(identification, "dcc:value", value);
  addText(identification, "dcc:name", name);
}

std::string dateOf(const std::string& time) { return time.substr(0, 10); }

void addSoftware(XMLElement& list, const std::string& release) {
  XMLElement& software = add(list, "dcc:software");
  addText(software, "dcc:name", "measuring_machine");
  addLeaf(software, "dcc:release", release);
  addLeaf(software, "dcc:type", "application");
}

void addCoreData(XMLElement& data, const Certificate& c) {
  const Calibration& k = c.calibration;
  const std::string country = countryOf(c.facts.place);
  XMLElement& core = add(data, "dcc:coreData");
  addLeaf(core, "dcc:countryCodeISO3166_1", country.empty() ? kUnknownCountry : country);
  addLeaf(core, "dcc:usedLangCodeISO639_1", "en");
  addLeaf(core, "dcc:mandatoryLangCodeISO639_1", "en");
  addLeaf(core, "dcc:uniqueIdentifier", c.number);
  XMLElement& ids = add(core, "dcc:identifications");
  addIdentification(ids, "calibrationLaboratory", k.id, kDccCalibrationId);
  addIdentification(ids, "calibrationLaboratory", c.checksum, kDccFileChecksum);
  if (!k.sessionHash.empty()) addIdentification(ids, "calibrationLaboratory", k.sessionHash, kDccSessionHash);
  const std::string measured = dateOfMeasurement(k);
  for (const char* date : {"dcc:beginPerformanceDate", "dcc:endPerformanceDate"})
    addLeaf(core, date, dateOf(measured.empty() ? c.facts.issued : measured));
  addLeaf(core, "dcc:performanceLocation", "other");
  addLeaf(core, "dcc:issueDate", dateOf(c.facts.issued));
  if (c.replaces.empty()) return;
  XMLElement& replaced = add(core, "dcc:reportAmendedSubstituted");
  addLeaf(replaced, "dcc:typeOfChange", "substituted");
  addLeaf(replaced, "dcc:replacedUniqueIdentifier", c.replaces);
}

XMLElement& addStatement(XMLElement& list, const std::string& name) {
  XMLElement& statement = add(list, "dcc:statement");
  addText(statement, "dcc:name", name);
  return statement;
}

void addDeclaration(XMLElement& list, const std::string& name, const std::string& text) {
  addText(addStatement(list, name), "dcc:declaration", text);
}

std::string rangesOf(const Domain& d) {
  std::string text;
  for (const std::vector<StatedFact>& ranges : {axisRanges(d), covariateRanges(d)})
    for (const StatedFact& range : ranges) text += (text.empty() ? "" : "; ") + range.name + " " + range.text;
  return text;
}

void addStatements(XMLElement& data, const Certificate& c) {
  XMLElement& list = add(data, "dcc:statements");
  XMLElement& uncertainty = addStatement(list, "uncertainty");
  addLeaf(uncertainty, "dcc:norm", "JCGM 100:2008");
  addLeaf(uncertainty, "dcc:norm", "JCGM 101:2008");
  addText(uncertainty, "dcc:declaration",
          "Expanded uncertainty: the standard uncertainty multiplied by the coverage factor k = 2, which for "
          "a normal distribution corresponds to a coverage probability of about 95 %.");
  addDeclaration(list, "metrological traceability of the reference", c.facts.traceability);
  if (isSimulated(c.calibration)) addDeclaration(list, "origin of the session", kSimulatedNotice);
  addDeclaration(list, "decision rule", decisionRule(c));
  if (dateOfMeasurement(c.calibration).empty())
    addDeclaration(list, "date of measurement",
                   "date of measurement not recorded; the dates of performance are that of issue");
  addDeclaration(list, "scope of the results", scopeOfResults(c.calibration));
  if (c.calibration.domain.sensors.empty()) addDeclaration(list, "temperature", "not recorded");
  if (!c.tasks.empty())
    for (const StatedFact& fact : conditionsOfPrediction(c))
      addDeclaration(list, "condition of the prediction: " + fact.name, fact.text);
  addDeclaration(list, "range of validity", rangesOf(c.calibration.domain));
  for (const Wandering& w : c.calibration.drift)
    addDeclaration(list, timesRecorded(c.calibration.domain) ? "drift seen" : "variation seen",
                   driftText(c.calibration.domain, w));
  addDeclaration(list, "model", modelLeaves(c.calibration));
  for (const CertifiedTask& task : c.tasks) {
    for (const std::string& why : task.result.outside)
      addDeclaration(list, "validity: " + task.result.task, "The calibration does not hold " + why);
    if (task.asked && task.verdicts.empty())
      addDeclaration(list, "conformity: " + task.result.task,
                     "No statement of conformity: " + joined(task.noConformity, "; "));
    for (const TaskVerdict& v : task.verdicts) {
      XMLElement& statement =
          addStatement(list, (v.measured ? "conformity: " : "prediction: ") + task.result.task);
      addLeaf(statement, "dcc:norm", "ISO 14253-1:2017");
      addText(statement, "dcc:declaration", headOf(task, v) + ": " + v.inWords);
      if (v.measured && v.conformity != Conformity::kUndecided)  // a program reads this, and no words
        addLeaf(statement, "dcc:conformity", v.conformity == Conformity::kConforms ? "pass" : "fail");
    }
  }
  if (!c.facts.remark.empty()) addDeclaration(list, "remark", c.facts.remark);
}

XMLElement& addPerson(XMLElement& list, const std::string& name, const char* role) {
  XMLElement& person = add(list, "dcc:respPerson");
  addText(add(person, "dcc:person"), "dcc:name", name);
  addLeaf(person, "dcc:role", role);
  return person;
}

void addAdministrativeData(XMLElement& root, const Certificate& c, bool toBeSigned) {
  XMLElement& data = add(root, "dcc:administrativeData");
  addSoftware(add(data, "dcc:dccSoftware"), kVersion);
  addCoreData(data, c);
  XMLElement& item = add(add(data, "dcc:items"), "dcc:item");
  addText(item, "dcc:name", c.calibration.machineName);
  addIdentification(add(item, "dcc:identifications"), "manufacturer", c.facts.serial, "serial number");
  XMLElement& laboratory = add(data, "dcc:calibrationLaboratory");
  addContact(laboratory, "dcc:contact", c.facts.laboratory, c.facts.place);
  addLeaf(laboratory, "dcc:cryptElectronicSignature", toBeSigned ? "true" : "false");
  XMLElement& persons = add(data, "dcc:respPersons");
  addPerson(persons, c.facts.operatorName, "operator");
  if (!c.facts.authorisedBy.empty())
    addLeaf(addPerson(persons, c.facts.authorisedBy, "authorised by"), "dcc:mainSigner", "true");
  addContact(data, "dcc:customer", c.facts.customer, "");
  addStatements(data, c);
}

/// The D-SI's name of one factor of a unit; empty: it has none.
std::optional<std::string> dsiFactor(const std::string& name) {
  static const std::map<std::string, std::string> kNames = {
      {"1", ""},           {"um", "\\micro\\metre"},    {"mm", "\\milli\\metre"}, {"m", "\\metre"},
      {"deg", "\\degree"}, {"arcsec", "\\arcsecond"},   {"rad", "\\radian"},      {"mrad", "\\milli\\radian"},
      {"K", "\\kelvin"},   {"degC", "\\degreecelsius"}, {"s", "\\second"},        {"min", "\\minute"},
      {"h", "\\hour"},     {"%", "\\percent"}};
  const auto found = kNames.find(name);
  if (found == kNames.end()) return std::nullopt;
  return found->second;
}

/// si:real, or text where the D-SI has no such unit.
void addQuantity(XMLElement& parent, const char* element, const StatedFigure& f) {
  XMLElement& quantity = add(parent, element);
  addText(quantity, "dcc:name", f.of.empty() ? f.name : f.of + ": " + f.name);
  if (!f.note.empty()) addText(quantity, "dcc:description", f.note);
  const std::optional<std::string> unit = dsiUnit(f.unit);
  if (!unit) {
    addText(quantity, "dcc:noQuantity",
            f.value + (f.expanded.empty() ? "" : ", U = " + f.expanded + " (k = 2)") + ", unit " + f.unit);
    return;
  }
  XMLElement& real = add(quantity, "si:real");
  addLeaf(real, "si:value", f.value);
  addLeaf(real, "si:unit", *unit);
  if (!f.standard.empty())
    addLeaf(add(add(real, "si:measurementUncertaintyUnivariate"), "si:standardMU"), "si:valueStandardMU",
            f.standard);
  if (f.expanded.empty()) return;
  XMLElement& expanded = add(add(real, "si:measurementUncertaintyUnivariate"), "si:expandedMU");
  addLeaf(expanded, "si:valueExpandedMU", f.expanded);
  addLeaf(expanded, "si:coverageFactor", kCoverageFactor);
  addLeaf(expanded, "si:coverageProbability", f.coverage);
  if (!f.distribution.empty()) addLeaf(expanded, "si:distribution", f.distribution);
}

void addMethods(XMLElement& results, const Certificate& c) {
  XMLElement& methods = add(results, "dcc:usedMethods");
  XMLElement& estimation = add(methods, "dcc:usedMethod");
  addText(estimation, "dcc:name", "Estimation of the parameters: " + c.calibration.method);
  XMLElement& propagation = add(methods, "dcc:usedMethod");
  addText(propagation, "dcc:name", "Propagation of distributions through simulated measurements");
  addLeaf(propagation, "dcc:norm", "JCGM 101:2008");
  addLeaf(propagation, "dcc:norm", "ISO/TS 15530-4");
  addSoftware(add(results, "dcc:usedSoftware"), c.calibration.software);
}

void addReference(XMLElement& results, const Certificate& c) {
  if (!c.calibration.artifact && !(c.conditions.artifactScale > 0.0) && !(c.conditions.artifactRadius > 0.0))
    return;
  const CalibratedBy a = c.calibration.artifact.value_or(CalibratedBy());
  XMLElement& equipment = add(add(results, "dcc:measuringEquipments"), "dcc:measuringEquipment");
  addText(equipment, "dcc:name",
          !c.calibration.artifact ? "not recorded in the calibration file"
          : a.features > 0        ? a.name
                                  : "independent instrument");
  addIdentification(add(equipment, "dcc:identifications"), "owner", a.serial, "serial number");
  XMLElement& stated = add(equipment, "dcc:measuringEquipmentQuantities");
  const auto state = [&](const char* name, double expanded, const char* unit) {
    if (expanded > 0.0) {
      addQuantity(stated, "dcc:measuringEquipmentQuantity", {{}, name, format("%.2g", expanded), {}, unit});
      return;
    }
    XMLElement& quantity = add(stated, "dcc:measuringEquipmentQuantity");
    addText(quantity, "dcc:name", name);
    addText(quantity, "dcc:noQuantity", "not stated; taken as exact");
  };
  if (a.features > 0) {
    state("largest U (k = 2) of a position", 2.0 * a.centreStd / kMicrometre, "um");
    state("largest U (k = 2) of a radius", 2.0 * a.radiusStd / kMicrometre, "um");
  }
  if (c.conditions.artifactScale > 0.0 || a.features == 0)
    state("U (k = 2) of the scale, stated for the predicted results", 2e6 * c.conditions.artifactScale,
          "um/m");
  if (c.conditions.artifactRadius > 0.0)
    state("U (k = 2) of the reference ball's radius, stated for the predicted results",
          2.0 * c.conditions.artifactRadius / kMicrometre, "um");
}

void addConditions(XMLElement& results, const Domain& d) {
  if (d.sensors.empty()) return;
  XMLElement& list = add(results, "dcc:influenceConditions");
  for (std::size_t s = 0; s < d.sensors.size(); ++s) {
    XMLElement& condition = add(list, "dcc:influenceCondition");
    addText(condition, "dcc:name", "temperature " + d.sensors[s]);
    XMLElement& range = add(condition, "dcc:data");
    if (!std::isfinite(d.sensorLower[s]) || !std::isfinite(d.sensorUpper[s])) {
      addText(range, "dcc:text", "not recorded");
      continue;
    }
    for (const auto& [name, value] : {std::pair{"lowest", d.sensorLower[s]}, {"highest", d.sensorUpper[s]}})
      addQuantity(range, "dcc:quantity", {{}, name, format("%.1f", value), {}, "degC"});
  }
}

void addResults(XMLElement& root, const Certificate& c) {
  XMLElement& results = add(root, "dcc:measurementResults");
  addMethods(results, c);
  addReference(results, c);
  addConditions(results, c.calibration.domain);
  for (const StatedGroup& group : statedGroups(c)) {
    if (group.figures.empty()) continue;
    XMLElement& result = add(results, "dcc:measurementResult");
    addText(result, "dcc:name", group.title);
    addText(result, "dcc:description", nameOf(group.origin));
    XMLElement& one = add(add(result, "dcc:results"), "dcc:result");
    addText(one, "dcc:name", group.title);
    XMLElement& list = add(add(one, "dcc:data"), "dcc:list");
    for (const StatedFigure& figure : group.figures) addQuantity(list, "dcc:quantity", figure);
  }
}

}  // namespace

std::optional<std::string> dsiUnit(const std::string& unit) {
  std::istringstream parts(unit);
  std::string text;
  bool below = false;  // a fraction line
  for (std::string part; std::getline(parts, part, '/'); below = true) {
    const std::size_t raised = part.find('^');
    const std::string power = raised == std::string::npos ? "1" : part.substr(raised + 1);
    const std::optional<std::string> factor = dsiFactor(part.substr(0, raised));
    if (!factor || power.size() != 1 || power < "1" || power > "9") return std::nullopt;
    if (factor->empty()) continue;
    text += *factor;
    if (below || power != "1") text += "\\tothe{" + std::string(below ? "-" : "") + power + "}";
  }
  if (unit.empty() || unit.back() == '/') return std::nullopt;
  return text.empty() ? "\\one" : text;
}

std::string countryOf(const std::string& place) {
  const std::string text(trim(place)), last(trim(text.substr(text.rfind(',') + 1)));
  const bool code =
      text.rfind(',') != std::string::npos && last.size() == 2 &&
      std::all_of(last.begin(), last.end(), [](unsigned char c) { return c >= 'A' && c <= 'Z'; });
  return code ? last : std::string();
}

std::string dccOf(const Certificate& c, const SigningKey* key) {
  tinyxml2::XMLDocument document;
  document.InsertEndChild(document.NewDeclaration());
  XMLElement* root = document.NewElement("dcc:digitalCalibrationCertificate");
  document.InsertEndChild(root);
  root->SetAttribute("xmlns:dcc", "https://ptb.de/dcc");
  root->SetAttribute("xmlns:si", "https://ptb.de/si");
  root->SetAttribute("xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance");
  root->SetAttribute("xsi:schemaLocation", "https://ptb.de/dcc https://ptb.de/dcc/v3.3.0/dcc.xsd");
  root->SetAttribute("schemaVersion", kDccVersion);
  addAdministrativeData(*root, c, key != nullptr);
  addResults(*root, c);
  if (key != nullptr) addSignatureTemplate(*root, *key);
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

}  // namespace mm
