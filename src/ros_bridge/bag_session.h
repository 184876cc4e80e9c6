#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "session/motion.h"
#include "session/progress.h"
#include "session/session.h"

namespace mm {

/// What the topics of a bag's series begin with.
inline const std::string kTemperatureTopics = "/temperature/", kCovariateTopics = "/covariate/";
/// Latched std_msgs/String, compensationJson: what the controller compensated while it measured.
inline const std::string kCompensationTopic = "/controller_compensation";

/// Latched std_msgs/String, Session::timesAssumed: the stamps tell the order of the rows alone.
inline const std::string kTimesAssumedTopic = "/times_assumed";

/// Which of several machines in one bag: the namespace that its topics stand in ("" or "/": none).
struct BagNamespace {
  std::string name;
  bool required = false;  // false: taken where it holds a session; else the only one there is
};

/// Reads a session from a bag: /probe/contact, /reference, `/temperature/<sensor>`, `/covariate/<name>`,
/// /joint_states, /artifact, /robot_description, /controller_compensation and /times_assumed; other topics
/// are left alone. Contacts are sorted by their header's stamp; t = 0 is the stamp of /artifact (else the
/// earliest of these topics; see SessionCollector). Of an imported session /imported_from names the CSV, and
/// the headers' `seq` count its lines. Directions of travel that were recorded nowhere are assumed (see
/// assumeTravel). A truncated or unindexed bag is read up to the damage, and `Session::warning` says so.
/// @param fallback the machine of a bag without /robot_description; may be null. All topics may stand in one
/// namespace (/machine1/probe/contact); where several hold a session, `where` chooses. A contact, reference
/// or logged value that is wrong is set aside by its topic and number, and the session is the rest. @throw
/// InputError when it is no bag, holds no session (names the topics found), holds several and none is chosen,
/// or a topic has another type.
Session readSessionBag(const std::filesystem::path& file, const ProgressCallback& progress = {},
                       const Machine* fallback = nullptr, const BagNamespace& where = {});

/// "a.bag:b.bag" as paths, as services and the workbench are given several. @throw InputError: one is empty.
std::vector<std::string> bagPaths(const std::string& bags);
/// Several sessions as one (session/joined.h). @throw InputError, as that and readSessionBag.
Session readSessionBags(const std::vector<std::string>& bags, const ProgressCallback& progress = {},
                        const Machine* fallback = nullptr, const BagNamespace& where = {});

/// Namespace of the nodes that measured a bag's session, "/" or "/m1"; empty: no node did (mm imported or
/// simulated it), or the bag is cut short and nobody knows. @param bags as bagPaths. @param wanted where
/// there are several.
std::string bagSpace(const std::string& bags, const std::string& wanted = {});

/// How a bag came about, in words for people: "recorded on a machine", "imported from plate.csv" or
/// "simulated"; "damaged" when its index cannot be read, as a recording that was killed leaves it.
/// @throw UnreadableFile: the disk does not give it.
std::string bagOrigin(const std::filesystem::path& file);

/// Writes a prepared session, with what was set aside in it, as a bag that gives the same session back to the
/// bit (times to 1 ns). Written under a temporary name, then renamed: the final name never holds half a bag.
/// @param motion ascending in time, goes to /joint_states: it tells the direction of the last motion where a
/// measurement was made at standstill.
/// @throw InputError when it cannot be written, e.g. because the disk is full.
void writeSessionBag(const Session& session, const std::filesystem::path& file,
                     const ProgressCallback& progress = {}, const std::vector<MotionSample>& motion = {});

}  // namespace mm
