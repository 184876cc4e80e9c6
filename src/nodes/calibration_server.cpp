#include "nodes/calibration_server.h"

#include <measuring_machine/Progress.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <sstream>

#include "base/error.h"
#include "base/requested_file.h"
#include "calibration_file/calibration_fit.h"
#include "calibration_file/calibration_yaml.h"
#include "report/json.h"
#include "report/text.h"
#include "report/verify_json.h"
#include "ros_bridge/bag_session.h"
#include "ros_bridge/message_conversion.h"
#include "ros_bridge/node_support.h"
#include "ros_bridge/residual_markers.h"
#include "session/joined.h"
#include "session/session_hash.h"
#include "session/session_summary.h"
#include "verification/verify.h"
#include "verification/verify_words.h"
#include "workflow/learning.h"

namespace mm {
namespace {

/// A path within a flow mapping of YAML.
std::string inYaml(const std::string& path) {
  const bool plain = std::all_of(path.begin(), path.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '/' || c == '.' || c == '_' || c == '-';
  });
  return plain ? path : "\"" + path + "\"";
}

/// The sentence in lines that rviz shows whole.
std::string inLines(const std::string& sentence) {
  constexpr std::size_t kMost = 50;  // letters
  std::istringstream words(sentence);
  std::string text;
  std::size_t length = 0;
  for (std::string word; words >> word; length += word.size() + 1) {
    if (length > 0 && length + word.size() > kMost) {
      text += "\n";
      length = 0;
    } else if (length > 0) {
      text += " ";
    }
    text += word;
  }
  return text;
}

}  // namespace

CalibrationServer::CalibrationServer(ros::NodeHandle node, ros::NodeHandle own, const Machine& machine)
    : own_(own),
      machine_(machine),
      store_(storeFolder(own, machine)),
      threads_(static_cast<unsigned>(numberParameter(own, "threads", 0, 0, 1024))),
      residualScale_(numberParameter(own, "residual_scale", 0.0, 0.0, 1e9)),
      prefix_(framePrefix(own)),
      live_(node),
      job_([this](const Job::State& state) { publishProgress(state); }),
      calibrateAction_(own, "calibrate", job_,
                       [this](const auto& goal, auto& result) { calibrateSession(goal, result); }),
      diagnoseAction_(own, "diagnose", job_,
                      [this](const auto& goal, auto& result) { diagnoseSession(goal, result); }),
      updater_(node, own, ros::this_node::getName()) {
  refuseUnknownParameters(own, {"store", "threads", "residual_scale", "frame_prefix"});
  progressOut_ = own.advertise<measuring_machine::Progress>("progress", 100, true);
  ledgerOut_ = own.advertise<std_msgs::String>("ledger", 10, true);
  verdictOut_ = own.advertise<visualization_msgs::Marker>("verdict", 1, true);
  residualsOut_ = own.advertise<visualization_msgs::MarkerArray>("residuals", 10, true);
  changedOut_ = own.advertise<std_msgs::String>("changed", 10, true);
  offerTask<measuring_machine::Calibrate>(
      "calibrate", [this](auto& request, auto& response) { calibrateSession(request, response); });
  offerTask<measuring_machine::Compare>(
      "compare", [this](auto& request, auto& response) { compare(request, response); });
  offerTask<measuring_machine::Diagnose>(
      "diagnose", [this](auto& request, auto& response) { diagnoseSession(request, response); });
  offerTask<measuring_machine::AddEffect>("add_effect", [this](auto& request, auto& response) {
    change(request.effect, &mm::addEffect, response);
  });
  offerTask<measuring_machine::RemoveEffect>("remove_effect", [this](auto& request, auto& response) {
    change(request.effect, &mm::removeEffect, response);
  });
  offerTask<measuring_machine::Verify>("verify",
                                       [this](auto& request, auto& response) { verify(request, response); });
  services_.push_back(
      offer<measuring_machine::Promote>(own, "promote", [this](auto& request, auto& response) {
        response.message = activate(&CalibrationStore::promote, request.calibration_id) + " is active";
      }));
  services_.push_back(
      offer<measuring_machine::Rollback>(own, "rollback", [this](auto& request, auto& response) {
        response.message = activate(&CalibrationStore::rollback, request.calibration_id) + " is active again";
      }));
  services_.push_back(
      offer<measuring_machine::Cancel>(own, "cancel", [this](auto&, auto& response) { cancel(response); }));
  publishProgress(Job::State());
  updater_.setHardwareID("calibration_server");
  updater_.add("session", this, &CalibrationServer::diagnoseNode);
  timer_ =
      node.createWallTimer(ros::WallDuration(0.5), [this](const ros::WallTimerEvent&) { updater_.update(); });
}

void CalibrationServer::diagnoseNode(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const Job::State running = job_.state();
  const std::string wrong = live_.complaint();
  status.summary(wrong.empty() ? DiagnosticStatus::OK : DiagnosticStatus::WARN,
                 !wrong.empty() ? wrong : (running.task.empty() ? "ready" : "busy: " + running.task));
  status.add("observations of the live session", live_.observations());
  status.add("task", running.task);
  status.add("stage", running.stage);
  status.add("store", store_.folder().string());
}

template <typename Service, typename Work>
void CalibrationServer::offerTask(const std::string& name, Work work) {
  services_.push_back(offer<Service>(own_, name, [this, name, work](auto& request, auto& response) {
    job_.run(name, [&] { work(request, response); });
  }));
}

void CalibrationServer::publishProgress(const Job::State& state) {
  measuring_machine::Progress message;
  message.header.stamp = ros::Time::now();
  message.task = state.task;
  message.stage = state.stage;
  message.share = state.share;
  progressOut_.publish(message);
  calibrateAction_.tell(state);
  diagnoseAction_.tell(state);
}

CalibrateOptions CalibrationServer::options() { return calibratingIn(job_, threads_); }

CalibrationServer::SessionPtr CalibrationServer::openSession(const std::string& bag,
                                                             const Machine& fallback) {
  const auto opened = [&](Session session, const std::string& space) {
    lastBag_ = bag;
    lastSpace_ = space;
    return last_ = std::make_shared<const Session>(std::move(session));
  };
  if (bag.empty()) {
    job_.step("collecting the live session", 0.0);
    return opened(live_.session(fallback), machineSpace());
  }
  const bool beside = bag.back() == ':';  // "s.bag:" is that bag and the live session
  const std::string recorded = beside ? bag.substr(0, bag.size() - 1) : bag;
  Session session =
      readSessionBags(bagPaths(recorded), [this](double share) { job_.step("reading the bag", share); },
                      &fallback, {machineSpace(), false});
  if (beside) session = joined({std::move(session), live_.session(fallback)});
  if (!session.warning.empty()) ROS_WARN("%s: %s", bag.c_str(), session.warning.c_str());
  for (const std::string& line : setAsideLines(session)) ROS_WARN("%s: %s", bag.c_str(), line.c_str());
  return opened(std::move(session), beside ? machineSpace() : bagSpace(recorded, machineSpace()));
}

/// The session that a calibration was made from: the last one used, its bag, or the live one.
CalibrationServer::SessionPtr CalibrationServer::sessionOf(const Calibration& calibration) {
  if (last_ && sessionHash(*last_) == calibration.sessionHash) return last_;
  const Machine machine(calibration.urdf, calibration.machineName);
  const std::string& source = calibration.sessionSource;
  const std::vector<std::string> bags = source.empty() ? std::vector<std::string>() : bagPaths(source);
  if (!bags.empty() && std::all_of(bags.begin(), bags.end(), namesFile))
    return openSession(calibration.sessionSource, machine);
  if (live_.observations() > 0) return openSession({}, machine);
  throw InputError("the session of calibration '" + calibration.id + "' (" + calibration.sessionSource +
                   ") no longer exists; calibrate again first");
}

ModelSpec CalibrationServer::modelFrom(const std::string& model, const Session& session) const {
  ModelSpec spec;
  if (model.empty()) {
    const CalibrationStore::Active active = store_.active();
    if (!active.calibration)
      throw InputError(
          "no model is given, and no calibration is active whose model could be used; name a model file");
    spec.effects = active.calibration->effects;
    return spec;
  }
  if (namesFile(model)) {
    spec = loadModelSpec(requestedYaml(model, "model"));
    checkMachine(spec, std::filesystem::path(model).parent_path(), session);
  } else if (model.find(':') != std::string::npos) {
    spec = parseModelSpec(model, "model of the request");
    checkMachine(spec, {}, session);
  } else {
    throw InputError("model '" + model.substr(0, 200) + "' is neither a file (seen from " +
                     std::filesystem::current_path().string() +
                     ") nor YAML; give an absolute path, or e.g. 'effects: [{type: scale, axis: x}]'");
  }
  return spec;
}

Calibration CalibrationServer::calibrationFrom(const std::string& idOrPath) const {
  if (!idOrPath.empty()) return namesFile(idOrPath) ? loadCalibration(idOrPath) : store_.load(idOrPath);
  const CalibrationStore::Active candidate = store_.candidate();
  if (candidate.calibration) return *candidate.calibration;
  const CalibrationStore::Active active = store_.active();
  if (active.calibration) return *active.calibration;
  throw InputError("there is no calibration yet in " + store_.folder().string() + "; call calibrate first");
}

std::string CalibrationServer::nextCall(const std::string& service, const std::string& request) const {
  const std::string call = "next: rosservice call " + own_.resolveName(service) + " " + request;
  ROS_INFO("%s", call.c_str());
  return call;
}

std::string CalibrationServer::keep(Recalibration& done, const Session& session, std::uint8_t& success,
                                    std::string& message) {
  done.calibration.sessionSpace = lastSpace_;
  const std::string id = store_.add(done.calibration);
  const std::vector<std::string> doubts = doubtsOf(done.result);
  const std::string doubt = done.result.cancelled ? "cancelled; the best result so far is kept"
                            : doubts.empty()      ? ""
                                                  : doubts.front();
  success = doubt.empty();
  message = doubt.empty() ? "candidate " + id : doubt + " (candidate " + id + ")";
  const std::string misfit = misfitOf(done.calibration, machine_, machineSpace());
  if (!misfit.empty()) addWords(message, "it cannot be promoted here: " + misfit);
  addWords(message, lossText(session));
  addWords(message, errorText(done.result, done.calibration.ledger.back().rmsBefore));
  if (success != 0)
    addWords(message, nextCall("diagnose", lastBag_.empty() ? "'{}'" : "'{bag: " + inYaml(lastBag_) + "}'"));
  ledgerOut_.publish(toText(ledgerText(done.calibration, !std::isfinite(done.result.figures.rms))));
  residualsOut_.publish(residualMarkers(done.result, residualScale_, prefix_ + "workpiece"));
  return id;
}

template <typename Asked, typename Answer>
void CalibrationServer::calibrateSession(const Asked& asked, Answer& answer) {
  CalibrateOptions fit = options();
  fit.method = methodOf(asked.method.empty() ? nameOf(fit.method) : asked.method);
  fit.seed = asked.seed != 0 ? asked.seed : fit.seed;
  const SessionPtr session = openSession(asked.bag, machine_);
  Recalibration done = recalibrate(*session, modelFrom(asked.model, *session), fit);
  answer.calibration_id = keep(done, *session, answer.success, answer.message);
  answer.json = calibrateJson(done.result);
}

void CalibrationServer::compare(const measuring_machine::Compare::Request& request,
                                measuring_machine::Compare::Response& response) {
  const Calibration calibration = calibrationFrom(request.calibration);
  const SessionPtr session = openSession(request.bag, Machine(calibration.urdf, calibration.machineName));
  const Comparison compared = compareWith(*session, calibration, options());
  const CalibrationResult& fit = compared.fit;
  response.json = compareJson(fit, compared.where);
  residualsOut_.publish(residualMarkers(fit, residualScale_, prefix_ + "workpiece"));
  response.message = "compared with calibration " + calibration.id;
  addWords(response.message,
           errorText(fit, std::isfinite(fit.before.rms) ? fit.before.rms : fit.before.rmsAngular));
  addWords(response.message, lossText(*session));
}

template <typename Asked, typename Answer>
void CalibrationServer::diagnoseSession(const Asked& asked, Answer& answer) {
  const Calibration calibration = calibrationFrom(asked.calibration);
  const SessionPtr session = openSession(asked.bag, Machine(calibration.urdf, calibration.machineName));
  const Diagnosis diagnosis = diagnoseCalibration(*session, calibration, diagnosing(options()));
  job_.step("answering", 1.0);  // a search that was cut short is no verdict
  answer.json = diagnoseJson(diagnosis);
  answer.message = diagnosis.sentence;
  verdictOut_.publish(
      wordsIn(prefix_ + "workpiece", "verdict", inLines(diagnosis.sentence), {0.0, 0.0, 0.03}));
  addWords(answer.message, lossText(*session));
  addWords(answer.message, errorText(diagnosis));
  addWords(answer.message, nextAfter(diagnosis, calibration));
}

/// What is changed or promoted by default is the candidate, else the active one: of another there is no next.
std::string CalibrationServer::nextAfter(const Diagnosis& diagnosis, const Calibration& of) const try {
  if (of.id.empty() || calibrationFrom({}).id != of.id) return {};
  if (const EffectSpec* next = nextToAdd(diagnosis)) {
    nextCall("add_effect", "\"effect: '" + next->yaml() + "'\"");
    return "next: call " + own_.resolveName("add_effect") + " with effect " + next->yaml() +
           (diagnosis.nextMeasurement.empty() ? "" : ", or measure next_measurement of json first");
  }
  const bool complete = diagnosis.verdict == Verdict::kExplained;
  return complete && store_.linked("candidate") == of.id ? nextCall("promote", "'{}'") : std::string();
} catch (const InputError&) {
  return {};  // the verdict does not wait for a folder
}

template <typename Response>
void CalibrationServer::change(const std::string& effect, Change change, Response& response) {
  const EffectSpec spec = parseEffectSpec(effect, "effect");
  const Calibration before = calibrationFrom({});
  const SessionPtr session = sessionOf(before);
  Recalibration done = change(*session, before, spec, options());
  keep(done, *session, response.success, response.message);
  response.json = changeJson(done.result, done.calibration.ledger);
}

std::string CalibrationServer::activate(Activation how, const std::string& id) {
  const std::string active = (store_.*how)(id, [this](const Calibration& calibration) {
    const std::string misfit = misfitOf(calibration, machine_, machineSpace());
    if (!misfit.empty()) throw InputError(misfit);
  });
  changedOut_.publish(toText(active));
  return active;
}

std::string CalibrationServer::takenBack(const std::string& id, bool& done) {
  if (store_.linked("active") != id)
    return "calibration " + id + " is not the active calibration, so nothing is rolled back";
  try {
    return "rolled back: " + activate(&CalibrationStore::rollback, {}) + " is active again";
  } catch (const InputError& e) {
    done = false;
    return std::string("not rolled back: ") + e.what();
  }
}

void CalibrationServer::verify(const measuring_machine::Verify::Request& request,
                               measuring_machine::Verify::Response& response) {
  std::string name = request.calibration;
  if (name.empty()) name = store_.linked("active");
  if (name.empty())
    throw InputError("no calibration is active in " + store_.folder().string() +
                     "; promote one first, or name the calibration to verify");
  const Calibration calibration = calibrationFrom(name);
  const SessionPtr session = openSession(request.bag, Machine(calibration.urdf, calibration.machineName));
  VerifyOptions how;
  how.loaded = request.loaded != 0;
  if (!request.export_folder.empty())
    how.exported = std::make_shared<const LoadedExport>(request.export_folder, calibration);
  how.calibrate = options();
  const Verification found = mm::verify(*session, calibration, how);
  job_.step("answering", 1.0);  // a verdict that was cut short is none
  response.json = verifyJson(found);
  response.message = found.inWords;
  if (request.automatic_rollback != 0 && found.verdict != VerifyVerdict::kHelped) {
    bool done = true;
    const std::string kept = whyKept(found);
    response.message += "; " + (kept.empty() ? takenBack(calibration.id, done) : kept);
    response.success = done;
  }
  for (const std::string& more : {axesText(found), whyNotFresh(calibration, *session), lossText(*session),
                                  keepAnswer(store_, calibration, *session, found)})
    addWords(response.message, more);
}

void CalibrationServer::cancel(measuring_machine::Cancel::Response& response) {
  const Job::State running = job_.cancel();
  response.success = !running.task.empty();
  response.message = running.task.empty() ? "nothing is running"
                                          : "'" + running.task + "' was asked to stop (" +
                                                (running.stage.empty() ? "begins" : running.stage) +
                                                "); its caller gets the answer";
}

}  // namespace mm
