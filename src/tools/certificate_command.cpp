#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

#include "base/error.h"
#include "base/text.h"
#include "base/units.h"
#include "calibration_file/atomic_file.h"
#include "calibration_file/calibration_yaml.h"
#include "machine/machine_fit.h"
#include "report/certificate.h"
#include "report/certificate_seal.h"
#include "session/session_hash.h"
#include "tools/commands.h"
#include "tools/exit_status.h"
#include "tools/output_files.h"
#include "tools/pdf_printer.h"
#include "tools/progress_bar.h"
#include "tools/session_input.h"
#include "tools/store_options.h"
#include "tools/uncertainty_options.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

struct CertificateCommand {
  std::string calibration, bag, output, check;
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
                     " has " + checksum +
                     ": the calibration was changed since; issue a certificate of it anew");
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
  if (seal.session.empty()) return "session: the seal does not tell it";
  if (named.empty() || (c.bag.empty() && !fs::is_regular_file(named, failed)))
    return "session: not at hand; name its bag to compare it";
  const std::string hash = sessionHash(loadSession(named, calibration, c.fit.space));
  if (hash == seal.session) return "session " + named + ": the one by which it was calibrated, hash " + hash;
  // Another file of that name proves nothing; one that was named does.
  if (c.bag.empty()) return "session: not at hand (" + named + " is another one); name its bag to compare it";
  throw InputError(c.check + ": is of a calibration by session " + seal.session + ", " + named + " is " +
                   hash + "; name the bag by which it was calibrated");
}

void checkSeal(const CertificateCommand& c) {
  const CertificateSeal seal = checkCertificate(readFile(c.check), c.check);
  std::string compared;
  const std::string file = fileAtHand(c, seal.calibration);
  if (file.empty()) {
    compared = "calibration file: not at hand; name it, or its folder with --store, to compare it\n";
  } else {
    const Calibration calibration = heldAgainstSeal(c, file, seal);
    compared = "calibration file " + file + ": " +
               (seal.checksum.empty() ? "of this id; the seal does not tell its CRC-64"
                                      : "the one that was certified, CRC-64 " + seal.checksum) +
               "\n" + sessionAgainstSeal(c, calibration, seal) + "\n";
  }
  std::cout << "unchanged since it was issued; calibration " << seal.calibration << '\n'
            << compared << "SHA-256 " << seal.sha256 << '\n';
}

CertifiedSession heldAgainst(const CertificateCommand& c, const Calibration& calibration) {
  CalibrateOptions options = c.fit.checked();
  if (c.uncertainty.repeatabilityUm > 0.0)
    options.repeatability = c.uncertainty.repeatabilityUm * kMicrometre;
  const Session session = loadSession(c.bag, calibration, c.fit.space);
  ProgressBar bar("comparing");
  options.progress = [&](const std::string& stage, double share) { bar.show(share, stage); };
  const CalibrationResult compared = compareCalibration(session, calibration, options);
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
  int sides = 0;
  for (const double side : Eigen::Vector3d(d.tipUpper - d.tipLower)) sides += side >= kMillimetre ? 1 : 0;
  return sides >= 1 && !d.laser;
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
    std::cerr << "mm: warning: the history of use is left out: " << e.what() << std::endl;
    return std::nullopt;
  }
}

void runCertificate(CertificateCommand& c, int& exitStatus) {
  if (!c.check.empty()) return checkSeal(c);
  if (c.calibration.empty() || c.output.empty())
    throw InputError(std::string("certificate: ") +
                     (c.calibration.empty() ? "a calibration file" : "-o, the file to write,") +
                     " is missing; write mm certificate c.yaml -o certificate.pdf, or mm certificate --check "
                     "certificate.pdf");
  c.files.input(c.calibration);
  c.files.input(c.bag);
  c.files.output("-o", c.output, FileKind::kCertificate);
  c.files.check();
  const bool pdf = endsWith(lower(c.output), ".pdf"), html = endsWith(lower(c.output), ".html");
  if (!pdf && !html)
    throw InputError("-o " + c.output + ": a certificate is .pdf or .html; name a file that ends so");
  if (pdf) requirePdfPrinter();
  Certificate certificate;
  certificate.calibration = loadCalibration(c.calibration);
  const Calibration& calibration = certificate.calibration;
  certificate.facts = c.facts;
  certificate.checksum = checksumIn(readFile(c.calibration), c.calibration);
  certificate.store = recordOf(c, calibration);
  certificate.serial =
      !c.facts.serial.empty() ? c.facts.serial : serialOf(Machine(calibration.urdf, calibration.machineName));
  if (!c.bag.empty()) certificate.session = heldAgainst(c, calibration);
  certificate.tasks = certifiedTasks(c, calibration);
  certificate.curves = correctionCurves(calibration);
  std::string content = certificatePage(certificate);
  if (pdf) content = printedPdf(content);
  content = sealedCertificate(content, {calibration.id, certificate.checksum, calibration.sessionHash, {}});
  c.files.write(c.output, content);
  std::cout << "written to " << c.output << "\nSHA-256 " << checkCertificate(content, c.output).sha256
            << '\n';
  for (const CertifiedTask& task : certificate.tasks) {
    for (const std::string& why : task.result.outside)
      std::cerr << "mm: warning: " << task.result.task << ": the calibration does not hold " << why << '\n';
    if (!task.result.outside.empty()) exitStatus = kAnswerIsNo;
    for (const TaskVerdict& v : task.verdicts)
      if (v.conformity != Conformity::kConforms) exitStatus = kAnswerIsNo;
  }
}

}  // namespace

void addCertificateCommand(CLI::App& app, int& exitStatus) {
  auto c = std::make_shared<CertificateCommand>();
  CLI::App* command =
      app.add_subcommand("certificate", "A calibration certificate as PDF or page, with a seal");
  command->add_option("calibration", c->calibration, "the calibration file");
  command->add_option("bag", c->bag, "a session against which it is held");
  command->add_option("-o,--output", c->output, "certificate.pdf or certificate.html");
  command->add_option("--check", c->check,
                      "a certificate: was it changed? With a calibration (else that of the store) and a bag: "
                      "is it of these, to the byte?");
  command->add_option("--serial", c->facts.serial, "serial number (default: <serial> of the machine's URDF)");
  command->add_option("--operator", c->facts.operatorName, "who calibrated");
  command->add_option("--customer", c->facts.customer, "for whom");
  command->add_option("--place", c->facts.place, "where");
  command->add_option("--traceability", c->facts.traceability,
                      "of the artifact: its certificate, laboratory and date");
  command->add_option("--remark", c->facts.remark, "whatever else it shall say");
  command
      ->add_option("--task", c->tasks,
                   "a task whose uncertainty it states (mm uncertainty --help); once each "
                   "(default: iso10360-2)")
      ->take_all()
      ->allow_extra_args(false);
  c->uncertainty.declare(*command);
  c->store.declare(*command);
  c->files.declare(*command);
  declareNamespace(*command, c->fit.space);
  command->footer(
      "The last line of the file is the SHA-256 of all that stands before it.\n"
      "Examples:\n  mm certificate c.yaml s.bag -o certificate.pdf --operator \"E. Abbe\" --traceability "
      "\"ball plate "
      "17, PTB 2026-03\" --mpe 1.5,250\n  mm certificate --check certificate.pdf");
  command->callback([c, &exitStatus] { runCertificate(*c, exitStatus); });
}

}  // namespace mm
