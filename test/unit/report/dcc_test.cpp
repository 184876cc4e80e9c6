// A digital certificate has the structure of PTB's schema, the figures of the page, and says what its
// signature covers.
#include "report/dcc.h"

#include <gtest/gtest.h>
#include <openssl/ec.h>
#include <openssl/pem.h>
#include <openssl/rsa.h>
#include <tinyxml2.h>

#include <cstdlib>
#include <memory>

#include "base/error.h"
#include "compensation_support.h"
#include "model/model_spec.h"
#include "report/certificate_figures.h"
#include "session_files.h"

namespace mm {
namespace {

Certificate certificateOfOneTask(const std::string& task, bool measured = false) {
  Certificate c;
  c.calibration = test::calibrationOf(Machine::load("three_axis"),
                                      {parseEffectSpec("{type: scale, axis: x}", "effect"),
                                       parseEffectSpec("{type: backlash, axis: y}", "effect")});
  Calibration& k = c.calibration;
  k.id = "20260301T093000Z-00c0ffee";
  k.created = "2026-03-01T09:30:00Z";
  k.software = "1.2.3";
  k.method = "least_squares";
  k.sessionHash = "feed";
  k.domain.tipLower = Eigen::Vector3d::Constant(-0.02);
  k.domain.tipUpper = Eigen::Vector3d::Constant(0.02);
  k.values[0].value = 123.4e-6;
  k.values[0].std = 2e-6;
  k.covariance(0, 0) = 4e-12;
  k.values[1].fixed = true;
  k.artifact = CalibratedBy{"plate <no. 7>", 9, false, 1e-3, 0.05, 0.2e-6, 0.0};
  k.rms = k.heldOutRms = k.repeatability = 0.3e-6;
  c.number = k.id + "-20260302T080000123Z-2";
  c.replaces = k.id + "-20260302T080000000Z-1";
  c.facts.serial = "M-17";
  c.checksum = "0123456789abcdef";
  c.facts.operatorName =
      std::string("E. \xC3\x84 \x01 \xFF") + "bbe";  // a control character and a wrong byte
  c.facts.authorisedBy = "C. Zeiss";
  c.facts.laboratory = "L & Co";
  c.facts.place = "Jena, DE";
  c.facts.issued = "2026-03-02T08:00:00Z";
  c.session.emplace();
  c.session->path = "s.bag";
  c.session->uncorrected = 9.87e-6;
  c.session->corrected = 0.654e-6;
  const Model model(Machine::load("three_axis"), k.domain, k.effects);
  const auto made = makeTask(task, {}, model);
  MonteCarloOptions options;
  options.trials = 2000;
  CertifiedTask stated;
  stated.result = taskUncertainty(*made, VirtualMachine(k, *made, {}), options);
  stated.asked = true;
  ToleranceAsked asked;
  asked.tolerance = 5e-6;
  if (measured) asked.measured = stated.result.quantities[stated.result.headline].quantity.nominal;
  stated.verdicts = verdictsOf(stated.result, asked);
  c.tasks.push_back(stated);
  return c;
}

struct PemFile {
  std::string text;
  explicit PemFile(EVP_PKEY* key, bool publicAlone = false) {
    const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> held(key, EVP_PKEY_free);
    const std::unique_ptr<BIO, decltype(&BIO_free)> bio(BIO_new(BIO_s_mem()), BIO_free);
    if (publicAlone)
      PEM_write_bio_PUBKEY(bio.get(), key);
    else
      PEM_write_bio_PrivateKey(bio.get(), key, nullptr, nullptr, 0, nullptr, nullptr);
    char* bytes = nullptr;
    const long size = BIO_get_mem_data(bio.get(), &bytes);
    text.assign(bytes, static_cast<std::size_t>(size));
  }
};

/// Exit status of xmllint with the grammar of the structure. @param said what it printed.
int validated(const std::string& xml, std::string& said) {
  const test::Folder folder;
  const std::string file = folder.write("dcc.xml", xml).string(), out = folder.path("out").string();
  const int status = std::system(
      ("xmllint --noout --relaxng test/data/dcc/dcc.rng '" + file + "' >'" + out + "' 2>&1").c_str());
  said = test::readAll(out);
  return WEXITSTATUS(status);
}

std::string replacedIn(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(Dcc, HasTheStructureOfTheSchema) {
  const SigningKey key = signingKeyOf(PemFile(EVP_EC_gen("P-256")).text, "key.pem");
  for (const char* task : {"iso10360-2", "distance:-10,0,0:10,0,0", "position:0,0,0"}) {
    const Certificate c = certificateOfOneTask(task);
    for (const SigningKey* with : {static_cast<const SigningKey*>(nullptr), &key}) {
      std::string said;
      EXPECT_EQ(validated(dccOf(c, with), said), 0) << said;
    }
  }
  // The grammar refuses what the schema does.
  const std::string xml = dccOf(certificateOfOneTask("position:0,0,0", true));
  std::string said;
  ASSERT_EQ(validated(xml, said), 0) << said;
  constexpr int kNotValid = 3;  // xmllint: well-formed, and not what the grammar asks
  for (const auto& [from, to] :
       {std::pair<const char*, const char*>{"<si:coverageFactor>2<", "<si:coverageFactor>0.5<"},
        {"<dcc:mainSigner>true", "<dcc:mainSigner>yes"},
        {"<dcc:issueDate>2026-03-02", "<dcc:issueDate>2026-13-02"},
        {"schemaVersion=\"3.3.0\"", "schemaVersion=\"2.0.0\""},
        {"<dcc:conformity>pass", "<dcc:conformity>passes"},
        {"\\micro\\metre", "um"}})
    EXPECT_EQ(validated(replacedIn(xml, from, to), said), kNotValid) << to << said;
}

/// Texts of every element of this name, in the order of the document.
void collectTexts(const tinyxml2::XMLElement& parent, const std::string& name,
                  std::vector<std::string>& texts) {
  for (const auto* e = parent.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    if (name == e->Name() && e->GetText() != nullptr) texts.emplace_back(e->GetText());
    collectTexts(*e, name, texts);
  }
}

TEST(Dcc, ItsFiguresAreThoseOfThePage) {
  for (const char* task : {"iso10360-2", "distance:-10,0,0:10,0,0"}) {
    const Certificate c = certificateOfOneTask(task);
    const std::string page = certificatePage(c);
    tinyxml2::XMLDocument document;
    ASSERT_EQ(document.Parse(dccOf(c).c_str()), tinyxml2::XML_SUCCESS);
    std::size_t figures = 0, uncertain = 0;
    const auto* results = document.RootElement()->FirstChildElement("dcc:measurementResults");
    std::vector<std::string> values, expanded;
    for (const auto* r = results->FirstChildElement("dcc:measurementResult"); r != nullptr;
         r = r->NextSiblingElement("dcc:measurementResult")) {
      collectTexts(*r, "si:value", values);
      collectTexts(*r, "si:valueExpandedMU", expanded);
    }
    for (const StatedGroup& group : statedGroups(c))
      for (const StatedFigure& f : group.figures) {
        ASSERT_LT(figures, values.size());
        EXPECT_EQ(values[figures], f.value);
        EXPECT_NE(page.find("<td class=\"n\">" + f.value + "</td>"), std::string::npos)
            << f.name << " " << f.value;
        ++figures;
        if (f.expanded.empty()) continue;
        ASSERT_LT(uncertain, expanded.size());
        EXPECT_EQ(expanded[uncertain++], f.expanded);
        // A length in mm has its U in um on the page: the same digits.
        const bool inMicrometres = f.unit == "mm";
        const std::string u = f.expanded, shown = inMicrometres ? " µm</td>" : "</td>";
        bool found = page.find(">" + u + "</td>") != std::string::npos;
        for (std::size_t at = page.find(shown); inMicrometres && !found && at != std::string::npos;
             at = page.find(shown, at + 1)) {
          const std::size_t from = page.rfind('>', at) + 1;
          found = std::abs(std::strtod(page.substr(from, at - from).c_str(), nullptr) -
                           1000.0 * std::stod(u)) < 1e-9;
        }
        EXPECT_TRUE(found) << f.name << " U " << u;
      }
    EXPECT_EQ(figures, values.size());
    EXPECT_EQ(uncertain, expanded.size());
    EXPECT_GT(uncertain, 1U);
  }
}

TEST(Dcc, SaysWhatItIsOf) {
  const Certificate c = certificateOfOneTask("position:0,0,0");
  const std::string xml = dccOf(c);
  for (const char* part :
       {"<dcc:uniqueIdentifier>20260301T093000Z-00c0ffee-20260302T080000123Z-2<",
        "<dcc:replacedUniqueIdentifier>20260301T093000Z-00c0ffee-20260302T080000000Z-1<",
        "<dcc:countryCodeISO3166_1>DE<", "M-17", "L &amp; Co", "plate &lt;no. 7&gt;", "E. Ä   ?bbe",
        "not stated; taken as exact", "predicted, not measured", "<si:coverageProbability>0.95<",
        "<si:distribution>normal<", "held by a convention", "\\micro\\metre\\metre\\tothe{-1}",
        "Predicted, no test was made: ", "uncertainty: 2 s of the fit; reference not included",
        "informative, without uncertainty"})
    EXPECT_NE(xml.find(part), std::string::npos) << part;
  const std::string test10360 = dccOf(certificateOfOneTask("iso10360-2"));
  for (const char* part : {"ISO 10360-2 (predicted, no test was made): ", "<si:valueStandardMU>"})
    EXPECT_NE(test10360.find(part), std::string::npos) << part;
  // A program reads the element and no words: none says "no", where nothing is stated, or "pass", where
  // nothing was measured.
  EXPECT_EQ(xml.find("<dcc:traceable>"), std::string::npos);
  EXPECT_NE(xml.find("The traceability of the reference is not stated"), std::string::npos);
  EXPECT_EQ(xml.find("<dcc:conformity>"), std::string::npos);
  Certificate tested = certificateOfOneTask("position:0,0,0", true);
  tested.tasks[0].result.outside = {"at 30 degC"};
  tested.facts.traceability = "ball plate 17";
  tested.calibration.degreesOfFreedom = 5.0;
  const std::string test = dccOf(tested);
  for (const char* part :
       {"<dcc:conformity>pass<", "Of the measured value that the issuer states: ", "ball plate 17",
        "The calibration does not hold at 30 degC", "Student's t, 5 degrees of freedom",
        "<si:coverageProbability>0.90<"})  // of a table of t: 0.898 within 2
    EXPECT_NE(test.find(part), std::string::npos) << part;
  // Where the calibration does not hold, nothing is decided, not even of a measured value.
  Certificate outside = tested;
  outside.calibration.artifact->radiusStd = 0.1e-6;
  decideConformity(outside);
  const std::string beyond = dccOf(outside);
  EXPECT_EQ(beyond.find("<dcc:conformity>"), std::string::npos);
  EXPECT_NE(beyond.find("No statement of conformity: the calibration does not hold at 30 degC"),
            std::string::npos);
  // What the issuer typed to change U, and what nobody recorded.
  Certificate changed = c;
  changed.conditions.repeatability = 0.1e-6;
  changed.facts.traceability = "Unknown";
  for (const char* part :
       {"0.100 um, stated by the issuer; calibration: 0.300 um", "Decision rule: ISO 14253-1:2017",
        "date of measurement not recorded", "<dcc:beginPerformanceDate>2026-03-02<",
        "The traceability of the reference is not stated", "C. Zeiss"})
    EXPECT_NE(dccOf(changed).find(part), std::string::npos) << part;
  EXPECT_EQ(dccOf(changed).find("<dcc:traceable>"), std::string::npos);
  changed.facts.authorisedBy.clear();
  EXPECT_EQ(dccOf(changed).find("<dcc:mainSigner>"), std::string::npos);
  changed.calibration.sessionEpoch = 1767225600.0;
  EXPECT_NE(dccOf(changed).find("<dcc:beginPerformanceDate>2026-01-01<"), std::string::npos);

  const DccContents read = dccContents(xml, "c.xml");
  EXPECT_EQ(read.number, c.number);
  EXPECT_EQ(read.calibration, c.calibration.id);
  EXPECT_EQ(read.session, "feed");
  EXPECT_EQ(read.checksum, c.checksum);
  EXPECT_FALSE(read.signature.there);
  EXPECT_FALSE(read.signatureAnnounced);

  Certificate undecided = c;
  undecided.tasks[0].verdicts.clear();
  undecided.tasks[0].noConformity = {"radius_std_um is not stated"};
  const std::string without = dccOf(undecided);
  EXPECT_EQ(without.find("<dcc:conformity>"), std::string::npos);
  EXPECT_NE(without.find("No statement of conformity: radius_std_um is not stated"), std::string::npos);

  EXPECT_EQ(countryOf("Jena, DE "), "DE");
  for (const char* none : {"", "DE", "Jena", "Jena, De", "Jena, DEU"}) EXPECT_EQ(countryOf(none), "") << none;
}

TEST(Dcc, UnitsAreThoseOfTheDSi) {
  EXPECT_EQ(dsiUnit("um"), "\\micro\\metre");
  EXPECT_EQ(dsiUnit("um/m"), "\\micro\\metre\\metre\\tothe{-1}");
  EXPECT_EQ(dsiUnit("um/m^3"), "\\micro\\metre\\metre\\tothe{-3}");
  EXPECT_EQ(dsiUnit("um/K/m"), "\\micro\\metre\\kelvin\\tothe{-1}\\metre\\tothe{-1}");
  EXPECT_EQ(dsiUnit("1"), "\\one");
  EXPECT_EQ(dsiUnit("1/m"), "\\metre\\tothe{-1}");
  for (const char* none : {"", "um/unit", "furlong", "um/m^x", "um/"}) EXPECT_FALSE(dsiUnit(none)) << none;
}

TEST(DccSignature, TakesRsaAndEcKeysAndNoOthers) {
  for (EVP_PKEY* made : {EVP_RSA_gen(2048), EVP_EC_gen("P-256")}) {
    EVP_PKEY_up_ref(made);
    const std::string publicKey = PemFile(made, true).text, privateKey = PemFile(made).text;
    const SigningKey key = signingKeyOf(privateKey, "key.pem");
    EXPECT_EQ(key.fingerprint, fingerprintIn(publicKey, "public.pem"));
    EXPECT_EQ(key.fingerprint, fingerprintIn(privateKey, "key.pem"));
    EXPECT_EQ(key.publicKey.find("PRIVATE"), std::string::npos);
    const DccContents read = dccContents(dccOf(certificateOfOneTask("position:0,0,0"), &key), "c.xml");
    EXPECT_TRUE(read.signature.there);
    EXPECT_TRUE(read.signatureAnnounced);
    EXPECT_EQ(read.signature.publicKey, publicKey);
    EXPECT_EQ(read.signature.fingerprint, key.fingerprint);
    EXPECT_THROW(signingKeyOf(publicKey, "public.pem"), InputError);
  }
  EXPECT_THROW(signingKeyOf(PemFile(EVP_RSA_gen(1024)).text, "short.pem"), InputError);
  EXPECT_THROW(signingKeyOf("", "empty.pem"), InputError);
  EXPECT_THROW(fingerprintIn("no key", "text"), InputError);
}

// A signature counts only where it covers the whole document: nothing is beside it, and nothing is left out.
TEST(DccSignature, MustCoverTheWholeDocument) {
  const SigningKey key = signingKeyOf(PemFile(EVP_EC_gen("P-256")).text, "key.pem");
  const std::string xml = dccOf(certificateOfOneTask("position:0,0,0"), &key);
  EXPECT_TRUE(dccContents(xml, "c.xml").signature.there);
  const std::string twice =
      xml.substr(xml.find("<ds:Signature "), xml.find("</ds:Signature>") + 15 - xml.find("<ds:Signature "));
  const std::string other = signingKeyOf(PemFile(EVP_EC_gen("P-256")).text, "other.pem").publicKey;
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"URI=\"\"", "URI=\"#part\""},
           {"xmldsig#enveloped-signature", "xpath"},
           {"</dcc:measurementResults>", "</dcc:measurementResults>" + twice},
           {"<dcc:coreData>", "<dcc:coreData>" + twice},
           {"</ds:Signature>", "</ds:Signature><dcc:comment/>"},
           {"xmldsig-more#ecdsa-sha256", "xmldsig-more#hmac-sha256"},
           {"2001/04/xmlenc#sha256", "2000/09/xmldsig#sha1"},
           {"<ds:KeyInfo>", "<ds:Object/><ds:KeyInfo>"},
           {key.publicKey, other},
           {key.publicKey, "AAAA"},
           {"<dcc:digitalCalibrationCertificate ", "<!DOCTYPE x []><dcc:digitalCalibrationCertificate "}})
    EXPECT_THROW(dccContents(replacedIn(xml, from, to), "c.xml"), InputError) << to.substr(0, 80);
  for (const std::string& none : {std::string(), std::string("<a/>"), xml.substr(0, xml.size() / 2)})
    EXPECT_THROW(dccContents(none, "c.xml"), InputError);
}

}  // namespace
}  // namespace mm
