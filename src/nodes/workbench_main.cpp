#include <ros/console.h>

#include <chrono>
#include <cmath>
#include <sstream>

#include "nodes/ros_machine.h"
#include "ros_bridge/bag_session.h"
#include "ros_bridge/effect_plugins.h"
#include "ros_bridge/node_support.h"
#include "ros_bridge/package_folder.h"
#include "workbench/access.h"
#include "workbench/bench.h"
#include "workbench/open_browser.h"
#include "workbench/server.h"

namespace {

mm::BenchSources sources() {
  mm::BenchSources sources;
  const std::string space = mm::machineSpace();
  sources.readBag = [space](const std::filesystem::path& bag, const mm::ProgressCallback& progress,
                            const mm::Machine* fallback) {
    return mm::readSessionBags(mm::bagPaths(bag.string()), progress, fallback, {space, false});
  };
  sources.writeBag = [](const mm::Session& session, const std::filesystem::path& file,
                        const std::vector<mm::MotionSample>& motion, const mm::ProgressCallback& progress) {
    mm::writeSessionBag(session, file, progress, motion);
  };
  sources.spaceOf = [space](const std::filesystem::path& bag) { return mm::bagSpace(bag.string(), space); };
  sources.packageFolder = mm::packageFolder;
  return sources;
}

/// `~port`, `~address`, `~hosts` (separated by spaces), `~store`, `~threads`, `~bag` (a recorded session to
/// begin with), `~open` (a browser), `~heartbeat` (s, without one for so long the machine is stopped),
/// `~frame_prefix`. Sets `~url`.
void serve(ros::NodeHandle node, ros::NodeHandle own) {
  mm::refuseUnknownParameters(own, {"port", "address", "hosts", "store", "threads", "bag", "open",
                                    "heartbeat", "frame_prefix", "url"});
  mm::loadEffectPlugins([](const std::string& line) { ROS_WARN("%s", line.c_str()); });
  const mm::Machine machine = mm::machineFromParameter(node);
  ros::AsyncSpinner spinner(3);
  mm::RosMachine live(node, machine, mm::framePrefix(own));
  spinner.start();
  mm::BenchOptions options;
  options.bag = mm::textParameter(own, "bag", "");
  options.store = mm::storeFolder(own, machine);
  options.threads = static_cast<unsigned>(mm::numberParameter(own, "threads", 0, 0, 1024));
  options.heartbeat =
      std::chrono::milliseconds(std::lround(1e3 * mm::numberParameter(own, "heartbeat", 0.9, 0.5, 10.0)));
  mm::ServerOptions listen;
  listen.address = mm::textParameter(own, "address", "127.0.0.1");
  listen.port = static_cast<unsigned>(mm::numberParameter(own, "port", 0, 0, 65535));
  std::istringstream hosts(mm::textParameter(own, "hosts", ""));
  for (std::string host; hosts >> host;) listen.hosts.push_back(host);
  listen.token = mm::newToken();
  mm::Bench bench(options, sources(), listen.token, &live);
  bench.begin();
  mm::endWhileRosLives();
  mm::Server server(listen, bench);
  bench.onNews([&server] { server.wake(); });
  own.setParam("url", server.url());
  ROS_INFO("workbench: %s", server.url().c_str());
  if (mm::flagParameter(own, "open", false) && !mm::openBrowser(server.url()))
    ROS_WARN("no browser could be opened; open the address above yourself");
  mm::waitForEnd();
  bench.onNews({});
}

}  // namespace

int main(int argc, char** argv) { return mm::runNode(argc, argv, "workbench", serve); }
