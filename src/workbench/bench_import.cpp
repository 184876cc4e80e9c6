// Somebody's file of measurements: looked at as `mm import` reads it, then written as a bag and opened.
#include <algorithm>
#include <system_error>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "base/text.h"
#include "import/import_format.h"
#include "import/import_preview.h"
#include "session/artifact_file.h"
#include "session/session_summary.h"
#include "session/text_file.h"
#include "workbench/bench_work.h"
#include "workbench/request_body.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostNames = 99;  // that are tried for a bag

/// What stands behind the last slash of either kind.
std::string lastPart(const std::string& path) { return path.substr(path.find_last_of("/\\") + 1); }

bool isTaken(const fs::path& file) {
  std::error_code error;
  return fs::symlink_status(file, error).type() != fs::file_type::not_found;
}

Json formatJson(const ImportFormat& f) { return {{"name", f.name}, {"what", f.what}}; }
Json choiceJson(const ColumnChoice& c) {
  return {{"value", c.value}, {"words", c.words}, {"group", c.group}};
}

ControllerCompensation compensationOf(const std::string& told) {
  ControllerCompensation stated;
  if (told.empty()) return stated;
  if (told != "none")
    throw InputError("compensation: is '" + personsName(told) + "', but must be none, or left empty");
  stated.stated = ControllerCompensation::Stated::kNone;
  return stated;
}

}  // namespace

std::shared_ptr<const Session> BenchWork::opened() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return session_;
}

fs::path BenchWork::importFolder() const {
  if (!options_.folder.empty()) return options_.folder;
  const fs::path beside = options_.bag.parent_path();
  return beside.empty() ? fs::current_path() : beside;
}

fs::path BenchWork::bagFor(const std::string& output) const {
  const bool plain = !output.empty() && output.front() != '.' && output == shownFileName(output) &&
                     output.find_first_of("/\\:") == std::string::npos;
  if (!plain || !endsWith(output, ".bag"))
    throw InputError("'" + shownFileName(output) +
                     "' is not a plain name that ends in .bag; the bag is written into " +
                     importFolder().string());
  const fs::path file = importFolder() / output;
  if (isTaken(file)) throw InputError(file.string() + ": exists already; name another file");
  return file;
}

std::string BenchWork::freeBagName(const std::string& file) const {
  std::string stem = fs::path(file).stem().string();
  std::replace(stem.begin(), stem.end(), ':', '_');
  stem.erase(0, std::min(stem.find_first_not_of('.'), stem.size()));
  if (stem.empty()) stem = "imported";
  std::string name = stem + ".bag";
  for (std::size_t n = 2; n <= kMostNames && isTaken(importFolder() / name); ++n)
    name = stem + "_" + std::to_string(n) + ".bag";
  return name;
}

std::string BenchWork::receive(const std::string& name, std::shared_ptr<const std::string> content) {
  ImportFile file{0, lastPart(name), std::move(content)};
  file.lines = TextFile(file.name, *file.content).lines().size();  // else it is refused here
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    file.number = file_.number + 1;
    file_ = file;
  }
  documents_.remove("preview");
  offerFile();
  return file.name + " is here: " + std::to_string(file.lines) + " lines";
}

void BenchWork::offerFile() {
  const std::lock_guard<std::mutex> lock(mutex_);
  documents_.put("import", jsonLine({{"number", file_.number},
                                     {"name", file_.name},
                                     {"bytes", file_.content->size()},
                                     {"lines", file_.lines},
                                     {"output", freeBagName(file_.name)},
                                     {"folder", importFolder().string()},
                                     {"formats", jsonList(importFormats(), formatJson)}}));
}

BenchWork::ImportFile BenchWork::fileOf(const ImportWish& wish) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!file_.content) throw InputError("no file of measurements was sent; choose one first");
  if (file_.number != wish.file)
    throw InputError("another file was sent meanwhile, " + file_.name +
                     "; look at that one, or send yours again");
  return file_;
}

/// @throw InputError: what the wish takes from the session in hand is not of the one that the page saw.
void BenchWork::checkInHand(const ImportWish& wish) const {
  const bool machine = wish.machine.empty() && wish.urdf.empty();
  const bool artifact = wish.artifactOfSession && wish.artifact.empty();
  const auto numbers = documents_.numbers();
  const auto session = numbers.find("session");
  if ((machine || artifact) && wish.session != (session == numbers.end() ? 0 : session->second))
    throw InputError("another session was opened meanwhile; look again");
}

Machine BenchWork::machineOf(const ImportWish& wish, const Session* like) const {
  const std::string name = personsName(lastPart(wish.machine));
  if (!wish.urdf.empty()) {
    const std::string stem = fs::path(name).stem().string();
    return Machine(wish.urdf, stem.empty() ? "machine" : stem);
  }
  if (wish.machine.empty() && like != nullptr) return like->machine;
  if (wish.machine.empty() && live_ != nullptr) return live_->machine();
  if (wish.machine.empty()) throw InputError("no machine is named; choose the one that measured");
  if (wish.machine != name || name.find(".urdf") != std::string::npos)
    throw InputError("machine: '" + name + "' is a file; choose its URDF, so that it is sent");
  return Machine::load(name);
}

ImportPreview BenchWork::read(const ImportWish& wish, const ImportFile& file, const Machine& machine,
                              const Session* like, const ProgressCallback& progress) const {
  ImportRequest request;
  request.file = file.name;
  request.content = file.content;
  request.format = wish.format;
  request.mappingText = trim(wish.mapping).empty() ? "" : wish.mapping;
  std::optional<Artifact> artifact;
  if (!wish.artifact.empty()) artifact = parseArtifact(wish.artifact, "artifact");
  if (wish.artifact.empty() && wish.artifactOfSession) {
    if (like == nullptr) throw InputError("no session is open of which the artifact could be taken");
    artifact = like->artifact;
  }
  return previewImport(request, machine, artifact ? &*artifact : nullptr, compensationOf(wish.compensation),
                       progress);
}

std::string BenchWork::preview(const ImportWish& wish) {
  const ImportFile file = fileOf(wish);
  const std::shared_ptr<const Session> like = opened();
  checkInHand(wish);
  const Machine machine = machineOf(wish, like.get());
  const ImportPreview found = read(wish, file, machine, like.get(), {});
  ImportRequest shown;
  shown.file = file.name;
  const std::optional<Session>& session = found.imported.session;
  documents_.put("preview",
                 jsonLine(jsonObject({previewJson(shown, found, ""),
                                      {{"number", file.number},
                                       {"asked_by", wish.asked},
                                       {"machine", machine.name()},
                                       {"keys", jsonList(found.imported.columns, &UnderstoodColumn::key)},
                                       {"column_choices", jsonList(columnChoices(machine), choiceJson)},
                                       {"summary", session ? summarize(*session) : ""}}})));
  if (found.faults.empty()) return file.name + ": " + found.imported.format + ", can be imported";
  return file.name + ": cannot be imported yet";
}

std::string BenchWork::import(const ImportWish& wish) {
  const ImportFile file = fileOf(wish);
  const std::shared_ptr<const Session> like = opened();
  checkInHand(wish);
  const Machine machine = machineOf(wish, like.get());
  const fs::path bag = bagFor(wish.output);
  const auto reading = [this](double share) { job_.step("reading the file", share); };
  const ImportPreview found = [&] {
    const CancelScope scope([this] { return job_.cancelled(); });
    return read(wish, file, machine, like.get(), reading);
  }();
  if (!found.faults.empty())
    throw InputError(
        found.faults.front() +
        (found.faults.size() > 1 ? " (and " + std::to_string(found.faults.size() - 1) + " more)" : ""));
  sources_.writeBag(*found.imported.session, bag, found.imported.motion,
                    [this](double share) { job_.step("writing the bag", share); });
  offerFile();
  const UrdfOrigin origin = !wish.urdf.empty()                        ? UrdfOrigin::kSent
                            : wish.machine.empty() && like != nullptr ? origin_
                                                                      : UrdfOrigin::kThisComputer;
  try {
    return "written to " + bag.string() + "; " + openBag(bag, wish.output, origin);
  } catch (const Cancelled&) {
    throw Cancelled(bag.string() + " is written; cancelled while it was opened");
  } catch (const Error& e) {
    throw InputError(bag.string() + " is written, but not opened: " + e.what());
  }
}

}  // namespace mm
