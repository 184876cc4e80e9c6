#include <cmath>
#include <filesystem>
#include <iostream>
#include <optional>

#include "base/error.h"
#include "base/text.h"
#include "base/units.h"
#include "base/utc_now.h"
#include "calibration_file/atomic_file.h"
#include "calibration_file/calibration_yaml.h"
#include "machine/machine_fit.h"
#include "report/certificate.h"
#include "report/certificate_figures.h"
#include "report/certificate_seal.h"
#include "report/dcc.h"
#include "session/session_hash.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/exit_status.h"
#include "tools/output_files.h"
#include "tools/outside_programs.h"
#include "tools/progress_bar.h"
#include "tools/session_input.h"
#include "tools/store_options.h"
#include "tools/uncertainty_options.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

struct CertificateCommand {
  std::string calibration, bag, output, check, sign, key;
  std::vector<std::string> tasks;
  CertificateFacts facts;
  UncertaintyOptions uncertainty;
  FitOptions fit;
  StoreOptions store;
  OutputFiles files;
};

namespace fs = std::filesystem;

/// The calibration's file: the one named, else that of its id in the store or in a machine's folder of it;
/// empty: it is not at hand.
std::string fileAtHand(const CertificateCommand& c, const std::string& id) {
  if (!c.calibration.empty()) return c.calibration;
  try {
    const fs::path root = c.store.store().folder();
    if (CalibrationStore(root).keeps(id)) return (root / (id + ".yaml")).string();
    std::error_code failed;
    for (const fs::directory_entry& part : fs::directory_iterator(root, failed))
      if (part.is_directory() && CalibrationStore(part.path()).keeps(id))
        return (part.path() / (id + ".yaml")).string();
  } catch (const InputError&) {  // no store, or an id of a foreign seal
  }
  return {};
}

/// The calibration that is at hand, held against the seal. @throw InputError: it is another one.
Calibration heldAgainstSeal(const CertificateCommand& c, const std::string& file,
                            const CertificateSeal& seal) {
  Calibration calibration = loadCalibration(file);
  if (calibration.id != seal.calibration)
    throw InputError(c.check + ": is of calibration " + seal.calibration + ", " + file + " is " +
                     calibration.id + "; take the certificate of this calibration");
  const std::string checksum = checksumIn(readFile(file), file);
  if (!seal.checksum.empty() && checksum != seal.checksum)
    throw InputError(c.check + ": was issued for the file with CRC-64 " + seal.checksum + ", " + file +
                     " has " + checksum + ": the calibration has changed since; issue a new certificate");
  if (!seal.session.empty() && calibration.sessionHash != seal.session)
    throw InputError(c.check + ": was issued for a calibration by session " + seal.session + ", " + file +
                     " is by " + calibration.sessionHash + "; take the certificate of this calibration");
  return calibration;
}

/// One line of what was compared.
std::string sessionAgainstSeal(const CertificateCommand& c, const Calibration& calibration,
                               const CertificateSeal& seal) {
  const std::string named = c.bag.empty() ? calibration.sessionSource : c.bag;
  std::error_code failed;
  if (seal.session.empty()) return "session: not recorded in the seal";
  if (named.empty() || (c.bag.empty() && !fs::is_regular_file(named, failed)))
    return "session: not available; name its bag to compare it";
  const std::string hash = sessionHash(loadSession(named, calibration, c.fit.space));
  if (hash == seal.session) return "session " + named + ": the one by which it was calibrated, hash " + hash;
  // Another file of that name proves nothing; one that was named does.
  if (c.bag.empty())
    return "session: not available (" + named + " is another one); name its bag to compare it";
  throw InputError(c.check + ": is of a calibration by session " + seal.session + ", " + named + " is " +
                   hash + "; name the bag by which it was calibrated");
}

/// What was compared with a certificate of these contents, a line each.
std::string comparedWith(const CertificateCommand& c, const CertificateSeal& seal) {
  const std::string file = fileAtHand(c, seal.calibration);
  if (file.empty())
    return "calibration file: not available; name it, or its folder with --store, to compare it\n";
  const Calibration calibration = heldAgainstSeal(c, file, seal);
  return "calibration file " + file + ": " +
         (seal.checksum.empty() ? "of this id; the seal does not record its CRC-64"
                                : "the one that was certified, CRC-64 " + seal.checksum) +
         "\n" + sessionAgainstSeal(c, calibration, seal) + "\n";
}

std::string whichCertificate(const CertificateSeal& seal) {
  return (seal.number.empty() ? std::string() : "certificate id: " + seal.number + "\n") + "calibration " +
         seal.calibration + "\n";
}

/// A digital certificate: the signature, if it has one. @throw InputError: it was changed after it was
/// signed.
int checkDcc(const CertificateCommand& c, const std::string& xml) {
  const DccContents dcc = dccContents(xml, c.check);
  std::string finding;
  if (!dcc.signature.there) {
    if (dcc.signatureAnnounced)
      throw InputError(c.check +
                       ": says that it is signed, but has no signature; ask the issuer for the original");
    finding = "not signed: whether it was changed cannot be determined\n";
  } else {
    requireXmlSigner();
    if (!signatureIsValid(xml, dcc.signature.publicKey, dcc.signature.fingerprint))
      throw InputError(
          c.check +
          ": its signature is not valid: it was changed after it was signed; ask the issuer for the "
          "original");
    const bool known = !c.key.empty();
    if (known && fingerprintIn(readFile(c.key), c.key) != dcc.signature.fingerprint)
      throw InputError(c.check + ": is not signed with " + c.key + ", but with the key of SHA-256 " +
                       dcc.signature.fingerprint + "; ask the issuer which key is theirs");
    finding = "signature valid: unchanged since it was signed with " +
              (known ? c.key + "\n"
                     : "the key of SHA-256 " + dcc.signature.fingerprint +
                           "\nwhose key that is, only the issuer can say; name theirs with --key\n");
  }
  const std::string compared = dcc.calibration.empty() ? std::string() : comparedWith(c, dcc);  // may refuse
  std::cout << finding << whichCertificate(dcc) << compared;
  return dcc.signature.there ? kDone : kAnswerIsNo;
}

int checkIssued(const CertificateCommand& c) {
  const std::string content = readFile(c.check);
  if (isDcc(content)) return checkDcc(c, content);
  if (!c.key.empty())
    throw InputError("--key " + c.key + ": only an XML certificate has a signature, and " + c.check +
                     " is none; leave --key out");
  const CertificateSeal seal = checkCertificate(content, c.check);
  const std::string compared = comparedWith(c, seal);  // may refuse
  std::cout << "content matches its checksum, which has no key: whoever can write the file can renew it\n"
            << whichCertificate(seal) << compared << "SHA-256 " << seal.sha256 << '\n';
  return kDone;
}

CertifiedSession heldAgainst(const CertificateCommand& c, const Calibration& calibration) {
  CalibrateOptions options = c.fit.checked();
  if (c.uncertainty.repeatabilityUm > 0.0)
    options.repeatability = c.uncertainty.repeatabilityUm * kMicrometre;
  const Session session = loadSession(c.bag, calibration, c.fit.space);
  const CalibrationResult compared =
      withBar("comparing", options, [&] { return compareCalibration(session, calibration, options); });
  CertifiedSession held;
  held.path = c.bag;
  held.sameSession = !calibration.sessionHash.empty() && calibration.sessionHash == sessionHash(session);
  held.observations = static_cast<std::int64_t>(session.observations.size());
  held.angular = !std::isfinite(compared.figures.rms);
  held.uncorrected = held.angular ? compared.before.rmsAngular : compared.before.rms;
  held.corrected = held.angular ? compared.figures.rmsAngular : compared.figures.rms;
  held.positioning = axisPositioning(compared);
  return held;
}

/// Whether a line can be measured in every calibrated volume; a laser or a rotary machine states its own
/// tasks.
bool hasVolume(const Domain& d) {
  return ((d.tipUpper - d.tipLower).array() >= kMillimetre).any() && !d.laser;
}

std::vector<CertifiedTask> certifiedTasks(CertificateCommand& c, const Calibration& calibration) {
  std::vector<std::string> texts = c.tasks;
  if (texts.empty() && hasVolume(calibration.domain)) texts = {"iso10360-2"};
  std::vector<CertifiedTask> tasks;
  for (const std::string& text : texts) {
    UncertaintyOptions options = c.uncertainty;
    options.task = text;
    const bool lengths = text == "iso10360-2" || startsWith(text, "distance:");
    if (!lengths) options.mpe.clear();
    if (text != "iso10360-2") options.mpeProbingUm = kNotMeasured;
    if (text == "iso10360-2" && !options.mpe.empty()) options.toleranceUm = kNotMeasured;
    ProgressBar bar("measuring");
    options.trials.progress = [&](double share) { bar.show(share, text); };
    CertifiedTask task;
    task.result = taskUncertaintyOf(calibration, options);
    task.verdicts = verdictsOf(task.result, options.asked());
    task.asked = !task.verdicts.empty();
    tasks.push_back(std::move(task));
  }
  return tasks;
}

/// A store that cannot be read is no reason to issue nothing, but one that was named is.
std::optional<StoreRecord> recordOf(const CertificateCommand& c, const Calibration& calibration) {
  try {
    return storeRecord(c.store.storeFor(calibration), calibration);
  } catch (const InputError& e) {
    if (!c.store.folder.empty()) throw;
    warn(std::string("the history of use is left out: ") + e.what());
    return std::nullopt;
  }
}

/// Whether the name of a file ends so, in small letters or capitals.
bool isNamed(const std::string& file, const char* ending) { return endsWith(lower(file), ending); }

/// A store that cannot be used is no reason to issue nothing.
template <typename Use>
void withStore(const Certificate& certificate, const Use& use) {
  if (!certificate.store) return;
  try {
    use(CalibrationStore(certificate.store->folder));
  } catch (const InputError& e) {
    warn(std::string("this issue is not listed in the store: ") + e.what());
  }
}

/// Gives this issue its number: the next of those that the store of the calibration lists. It replaces the
/// one whose file it overwrites, and no other: a second copy for another customer leaves the first valid.
void numberIssue(const IssueNumber& before, Certificate& certificate) {
  IssueNumber number{certificate.calibration.id, issueStamp(), before.count + 1};
  if (before.count > 0) certificate.replaces = before.text();
  withStore(certificate, [&](const CalibrationStore& store) {
    for (const CalibrationStore::Issue& i : store.issues())
      if (i.id == number.calibration) number.count = std::max(number.count, i.count + 1);
  });
  certificate.number = number.text();
}

/// Lists it in the store, once it is written: what nobody holds was not issued.
void listIssue(const CertificateCommand& c, const Certificate& certificate) {
  const IssueNumber number = IssueNumber::parsed(certificate.number);
  withStore(certificate, [&](const CalibrationStore& store) {
    const std::string form = isNamed(c.output, ".xml") ? "digital" : "paper";
    store.noteIssue({number.stamp, number.calibration, form, number.count});
  });
}

/// The certificate as the file that was asked for.
std::string contentOf(const CertificateCommand& c, const Certificate& certificate,
                      const std::optional<SigningKey>& key) {
  if (isNamed(c.output, ".xml")) {
    const std::string xml = dccOf(certificate, key ? &*key : nullptr);
    return key ? signedXml(xml, c.sign, key->fingerprint) : xml;
  }
  std::string content = certificatePage(certificate);
  if (isNamed(c.output, ".pdf")) content = printedPdf(content);
  const Calibration& calibration = certificate.calibration;
  return sealedCertificate(
      content, {calibration.id, certificate.number, certificate.checksum, calibration.sessionHash, {}});
}

int runCertificate(CertificateCommand& c) {
  if (!c.check.empty()) return checkIssued(c);
  if (c.calibration.empty() || c.output.empty())
    throw InputError(std::string("certificate: ") +
                     (c.calibration.empty() ? "a calibration file" : "-o, the file to write,") +
                     " is missing; write mm certificate c.yaml -o certificate.pdf, or mm certificate --check "
                     "certificate.pdf");
  c.files.input({c.calibration, c.bag, c.sign});
  c.files.output("-o", c.output, FileKind::kCertificate);
  c.files.check();
  const bool pdf = isNamed(c.output, ".pdf"), xml = isNamed(c.output, ".xml");
  if (!pdf && !xml && !isNamed(c.output, ".html"))
    throw InputError("-o " + c.output + ": a certificate is .pdf, .html or .xml; name a file that ends so");
  if (!c.sign.empty() && !xml)
    throw InputError("--sign " + c.sign + ": only an XML certificate is signed, and -o names " + c.output +
                     "; name a file that ends in .xml");
  if (!c.key.empty()) throw InputError("--key " + c.key + ": is for --check; sign with --sign");
  if (pdf) requirePdfPrinter();
  if (!c.sign.empty()) requireXmlSigner();
  std::optional<SigningKey> key;
  if (!c.sign.empty()) key = signingKeyOf(readFile(c.sign), c.sign);
  Certificate certificate;
  certificate.calibration = loadCalibration(c.calibration);
  const Calibration& calibration = certificate.calibration;
  certificate.facts = c.facts;
  certificate.facts.issued = utcNow();
  certificate.checksum = checksumIn(readFile(c.calibration), c.calibration);
  certificate.store = recordOf(c, calibration);
  if (certificate.facts.serial.empty())
    certificate.facts.serial = serialOf(Machine(calibration.urdf, calibration.machineName));
  if (!c.bag.empty()) certificate.session = heldAgainst(c, calibration);
  certificate.tasks = certifiedTasks(c, calibration);
  certificate.conditions = c.uncertainty.conditionsFor(calibration.domain);
  certificate.points = c.uncertainty.points.points;
  decideConformity(certificate);
  certificate.curves = correctionCurves(calibration);
  IssueNumber before;
  if (kindOf(c.output) == FileKind::kCertificate)
    before = issueIn(readFile(c.output), c.output, calibration.id);
  numberIssue(before, certificate);
  const std::string content = contentOf(c, certificate, key);
  c.files.write(c.output, content);
  listIssue(c, certificate);
  std::cout << "written to " << c.output << "\ncertificate id: " << certificate.number << '\n';
  if (!certificate.replaces.empty()) std::cout << "replaces the one of id: " << certificate.replaces << '\n';
  if (xml)
    std::cout << (key ? "signed with " + c.sign + ", public key SHA-256 " + key->fingerprint : "not signed")
              << '\n';
  else
    std::cout << "SHA-256 " << checkCertificate(content, c.output).sha256 << '\n';
  int status = kDone;
  for (const CertifiedTask& task : certificate.tasks) {
    if (task.asked && !task.noConformity.empty())
      warn(task.result.task + ": no statement of conformity: " + joined(task.noConformity, "; "));
    else
      for (const std::string& why : task.result.outside)
        warn(task.result.task + ": the calibration does not hold " + why);
    if (!task.result.outside.empty() || (task.asked && task.verdicts.empty())) status = kAnswerIsNo;
    for (const TaskVerdict& v : task.verdicts)
      if (v.conformity != Conformity::kConforms) status = kAnswerIsNo;
  }
  return status;
}

}  // namespace

void addCertificateCommand(CLI::App& app, int& exitStatus) {
  auto [c, command] = addCommand<CertificateCommand>(
      app, exitStatus, runCertificate, "certificate",
      "Write a calibration certificate as PDF, HTML or signed XML (DCC), or check one");
  command.add_option("calibration", c.calibration, "the calibration file");
  command.add_option("bag", c.bag, "a session to compare the calibration with");
  command.add_option("-o,--output", c.output, "certificate.pdf, certificate.html, or certificate.xml (DCC)");
  command.add_option(
      "--check", c.check,
      "check the signature or checksum of this certificate, and whether it belongs to the given "
      "calibration (default: that of the store) and bag");
  command.add_option("--sign", c.sign,
                     "sign an XML certificate with this private key (PEM, RSA or EC) by xmlsec1");
  command.add_option(
      "--key", c.key,
      "with --check: the issuer's public key or X.509 certificate (PEM), to compare the signature with");
  command.add_option("--serial", c.facts.serial, "serial number (default: <serial> of the machine's URDF)");
  command.add_option("--operator", c.facts.operatorName, "who calibrated");
  command.add_option("--authorised-by", c.facts.authorisedBy, "who authorises the certificate and signs it");
  command.add_option("--laboratory", c.facts.laboratory, "laboratory that issues the certificate");
  command.add_option("--customer", c.facts.customer, "for whom");
  command.add_option("--place", c.facts.place, "where, with the country's code at its end: \"Jena, DE\"");
  command.add_option("--traceability", c.facts.traceability,
                     "traceability of the artifact: its certificate, laboratory and date");
  command.add_option("--remark", c.facts.remark, "remark to print");
  repeatedOption(command, "--task", c.tasks,
                 "measurement task whose uncertainty is stated (mm uncertainty --help); repeatable "
                 "(default: iso10360-2)");
  c.uncertainty.declare(command);
  c.store.declare(command);
  c.files.declare(command);
  declareNamespace(command, c.fit.space);
  command.footer(
      "The last line of a PDF or HTML file is the SHA-256 of everything before it; a signed XML\n"
      "file by its signature. Conformity is stated only if the uncertainty of the artifact is.\n"
      "It is a record of calibration where laboratory, serial number, customer, operator, traceability or\n"
      "date of measurement is not known.\n"
      "Examples:\n"
      "  mm certificate c.yaml s.bag -o certificate.pdf --operator \"E. Abbe\" --traceability \"ball plate "
      "17, PTB 2026-03\" --mpe 1.5,250\n"
      "  mm certificate c.yaml -o certificate.xml --sign key.pem\n"
      "  mm certificate --check certificate.xml --key laboratory.pem");
}

}  // namespace mm
