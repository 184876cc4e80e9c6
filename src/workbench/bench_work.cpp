#include "workbench/bench_work.h"

#include <cmath>

#include "base/error.h"
#include "base/json_text.h"
#include "base/names_of.h"
#include "base/text.h"
#include "calibration_file/calibration_fit.h"
#include "calibration_file/calibration_yaml.h"
#include "design/moves.h"
#include "effects/effect_words.h"
#include "effects/registry.h"
#include "model/observed_domain.h"
#include "report/json.h"
#include "session/joined.h"
#include "session/session_summary.h"
#include "workbench/calibration_documents.h"
#include "workbench/sent_yaml.h"

namespace mm {
namespace {

constexpr std::size_t kLongestFormula = 500, kMostSteps = 10;

std::string withDoubt(const std::string& done, const CalibrationResult& result) {
  const std::vector<std::string> doubts = doubtsOf(result);
  return doubts.empty() ? done : done + "; " + doubts.front();
}

/// A formula as an effect; its start values as the text says, comma after comma.
EffectSpec formulaSpec(const std::string& direction, const std::string& formula, const std::string& start) {
  EffectSpec spec("formula");
  spec.set("direction", direction).set("formula", formula);
  if (!start.empty())
    return parseEffectSpec(spec.yaml().substr(0, spec.yaml().size() - 1) + ", start: [" + start + "]}",
                           "start");
  return spec;
}

}  // namespace

BenchWork::BenchWork(BenchOptions options, BenchSources sources, Documents& documents, Job& job,
                     LiveMachine* live)
    : options_(std::move(options)),
      sources_(std::move(sources)),
      documents_(documents),
      job_(job),
      live_(live) {
  if (!options_.store.empty()) store_.emplace(options_.store);
}

const Session& BenchWork::session() const {
  if (!session_)
    throw InputError("no session is open; import a file, drop a bag onto the page, or measure a plan");
  return *session_;
}

const Calibration& BenchWork::calibration() const {
  if (!calibration_) throw InputError("there is no calibration yet; calibrate first");
  return *calibration_;
}

CalibrateOptions BenchWork::options() const { return calibratingIn(job_, options_.threads); }

std::string BenchWork::begin() {
  documents_.put("catalogue", catalogueDocument());
  if (!options_.calibration.empty()) {
    calibration_ = loadCalibration(options_.calibration);
    kept_ = false;
  }
  if (!options_.bag.empty()) return open(options_.bag, options_.bag.filename().string());
  if (live_ != nullptr) {
    showMachine(live_->machine());
    if (store_) showStore();
    try {
      return openLive();
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& e) {
      return e.what();  // what is measured from now on can be taken later
    }
  }
  return "no session is open";
}

void BenchWork::take(Session session, const std::string& shownAs) {
  // a fit without effects is of its own session alone
  if (calibration_ && !kept_ && calibration_->effects.empty()) calibration_.reset();
  if (calibration_) checkMachine(*calibration_, session);
  chooseStore(session);
  job_.step("checking the point set", 0.0);
  auto taken = std::make_shared<const Session>(std::move(session));
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    domain_ = std::make_shared<const Domain>(observedDomain(*taken));
    session_ = std::move(taken);
  }
  earlier_ = {};
  forget({"points", "compare", "diagnosis", "moves", "report", "verify"});
  shownAs_ = shownAs;
  showMachine(session_->machine);
  documents_.put("session", sessionDocument(*session_, shownAs_));
  documents_.put("heat", heatDocument(*session_));
  if (calibration_) {
    nominalResiduals();
    show();
  } else {
    firstFit();
  }
}

/// Of the folders that are not named by the options, the one of the machine that measured.
void BenchWork::chooseStore(const Session& session) {
  if (!options_.store.empty()) return;
  const std::filesystem::path folder = CalibrationStore::defaultFolder() / folderOf(session.machine, space_);
  if (store_ && store_->folder() == folder) return;
  store_.emplace(folder);
  kept_ = false;  // the calibration in hand is not in this one
}

std::filesystem::path BenchWork::logFile() const {
  return store_ ? store_->folder() / "workbench.log" : std::filesystem::path();
}

void BenchWork::forget(std::initializer_list<const char*> documents) {
  for (const char* name : documents) documents_.remove(name);
}

std::string BenchWork::open(const std::filesystem::path& bag, const std::string& shownAs) {
  return openBag(bag, shownAs, bag.filename() != shownAs ? UrdfOrigin::kSent : UrdfOrigin::kThisComputer);
}

std::string BenchWork::openBag(const std::filesystem::path& bag, const std::string& shownAs,
                               UrdfOrigin origin) {
  const std::optional<Machine> fallback =
      calibration_ ? std::optional<Machine>(Machine(calibration_->urdf, calibration_->machineName))
                   : std::nullopt;
  Session session = sources_.readBag(
      bag, [this](double share) { job_.step("reading the bag", share); }, fallback ? &*fallback : nullptr);
  space_ = sources_.spaceOf(bag);
  if (bag.filename() != shownAs) session.source = shownAs;  // the file will be gone
  origin_ = origin;
  take(std::move(session), shownAs);
  const std::string loss = lossText(*session_);
  return shownAs + ": " + std::to_string(session_->observations.size()) + " observations" +
         (loss.empty() ? "" : "; " + loss);
}

std::string BenchWork::openLive(bool beside) {
  if (live_ == nullptr) throw InputError("there is no machine: this workbench shows a recorded session");
  space_ = live_->space();
  origin_ = UrdfOrigin::kThisComputer;
  const std::string shownAs = beside && session_ ? shownAs_ + " and its moves" : "live session";
  take(beside && session_ ? joined({*session_, live_->session()}) : live_->session(), shownAs);
  return shownAs + ": " + std::to_string(session_->observations.size()) + " observations";
}

/// What a machine without any correction leaves: the first "before".
void BenchWork::nominalResiduals() {
  if (calibration_->effects.empty()) return;
  CalibrateOptions fit = options();
  fit.method = Method::kLeastSquares;
  fit.rejectOutliers = false;
  job_.step("fitting the nominal machine", 0.0);
  const CalibrationResult nominal = mm::calibrate(*session_, modelFor(*session_, {}), fit);
  earlier_ = {"nominal machine", nominal.residuals};
}

/// A model without effects: what there is to explain.
void BenchWork::firstFit() {
  CalibrateOptions fit = options();
  fit.method = Method::kLeastSquares;
  ModelSpec model;
  model.machine = session_->machine.name();
  Recalibration done = recalibrate(*session_, model, fit);
  if (done.result.cancelled) throw Cancelled("stopped before the nominal machine was fitted");
  calibration_ = std::move(done.calibration);
  calibration_->sessionSpace = space_;
  kept_ = false;
  show();
}

void BenchWork::show() {
  job_.step("comparing", 0.0);
  const Comparison compared =
      compareWith(*session_, *calibration_, options(), [this](const CalibrationResult& fit) {
        documents_.put("points", pointsDocument(fit, earlier_));
        documents_.put("calibration", calibrationDocument(*calibration_, kept_));
      });
  documents_.put("compare", compareJson(compared.fit, compared.where));
  const std::size_t effects = calibration_->effects.size();
  earlier_ = {effects == 0 ? "nominal machine"
                           : "before: " + std::to_string(effects) + (effects == 1 ? " effect" : " effects"),
              compared.fit.residuals};
  showStore();
}

void BenchWork::showStore() {
  documents_.put("history", historyDocument(*store_));
  std::optional<Calibration> active;
  try {
    active = store_->active().calibration;
  } catch (const InputError&) {
    // every calibration that was active is damaged: the history names them
  }
  const Calibration* candidate = calibration_ ? &*calibration_ : nullptr;
  documents_.put("correct", correctionDocument(active ? &*active : nullptr, candidate));
  if (!calibration_) return;
  Calibration whole = *calibration_;
  completeCalibration(whole);
  documents_.put("calibration.yaml", calibrationYaml(whole), "application/yaml", whole.id + ".yaml");
}

void BenchWork::keep(Recalibration& done) {
  done.calibration.sessionSpace = space_;
  if (done.result.cancelled) throw Cancelled("stopped before the model was refitted; nothing was changed");
  store_->add(done.calibration);
  calibration_ = done.calibration;  // add all goes on from it
  kept_ = true;
  forget({"diagnosis", "moves", "report", "export"});
  show();
}

std::string BenchWork::calibrate(const std::string& model, const std::string& method, std::uint64_t seed) {
  ModelSpec spec;
  if (model.empty()) {
    spec.effects = calibration().effects;
    spec.machine = calibration().machineName;  // only its name: take() compared the machines
  } else {
    spec = sentModel(model);
    checkMachine(spec, {}, session());
  }
  CalibrateOptions fit = options();
  fit.method = methodOf(method.empty() ? "least_squares" : method);
  if (seed != 0) fit.seed = seed;
  Recalibration done = recalibrate(session(), spec, fit);
  keep(done);
  return withDoubt("candidate " + calibration_->id, done.result);
}

void BenchWork::showDiagnosis(const Diagnosis& diagnosis) {
  documents_.put("diagnosis", diagnoseJson(diagnosis));
  documents_.put("moves", movesYaml(diagnosis.nextMeasurement, session()), "application/yaml", "moves.yaml");
}

std::string BenchWork::diagnose() {
  const Diagnosis diagnosis = diagnoseCalibration(session(), calibration(), diagnosing(options()));
  showDiagnosis(diagnosis);
  return diagnosis.sentence;
}

std::string BenchWork::change(const std::string& effect, Change change, const char* done) {
  const EffectSpec spec = parseEffectSpec(effect, "effect");
  Recalibration next = change(session(), calibration(), spec, options());
  keep(next);
  return withDoubt(inWords(spec) + done + ": candidate " + calibration_->id, next.result);
}

std::string BenchWork::add(const std::string& effect) { return change(effect, &mm::addEffect, " added"); }

std::string BenchWork::remove(const std::string& effect) {
  return change(effect, &mm::removeEffect, " taken back");
}

std::string BenchWork::addAll() {
  const Learned learned = learnAll(session(), calibration(), diagnosing(options()), kMostSteps,
                                   [this](const Diagnosis&, Recalibration& step) { keep(step); });
  if (learned.stopped)
    throw Cancelled("stopped after " + std::to_string(learned.steps) + " steps, which are kept");
  if (learned.diagnosis) showDiagnosis(*learned.diagnosis);
  return learned.sentence;
}

std::string BenchWork::judgeFormula(const std::string& direction, const std::string& formula,
                                    const std::string& start) const {
  std::shared_ptr<const Domain> domain;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    domain = domain_;
  }
  try {
    if (!domain) throw InputError("no session is open");
    if (formula.size() + start.size() > kLongestFormula)
      throw InputError("the formula has more than " + std::to_string(kLongestFormula) + " letters");
    const EffectSpec spec = formulaSpec(direction, formula, start);
    const EffectPtr effect = createEffect(spec, *domain);
    const std::string unknowns = joined(allNames(effect->parameters()), ", ");
    return jsonLine({{"ok", !unknowns.empty()},
                     {"message", unknowns.empty() ? "it has no unknown to estimate; write k1, k2 …"
                                                  : "can be added; " + unknowns + " will be estimated"},
                     {"effect", spec.yaml()}});
  } catch (const Error& e) {
    return jsonLine({{"ok", false}, {"message", e.what()}});
  }
}

}  // namespace mm
