#include <condition_variable>
#include <iostream>
#include <thread>

#include "base/error.h"
#include "ros_bridge/bag_session.h"
#include "ros_bridge/package_folder.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/exit_status.h"
#include "tools/interrupt.h"
#include "tools/output_files.h"
#include "tools/session_input.h"
#include "workbench/access.h"
#include "workbench/bench.h"
#include "workbench/server.h"

namespace mm {
namespace {

struct WorkbenchCommand {
  BenchOptions bench;
  ServerOptions server;
  Bags bags;
  std::string calibration, store, space;
};

BenchSources sourcesOf(const std::string& space) {
  BenchSources sources;
  sources.readBag = [space](const std::filesystem::path& bag, const ProgressCallback& progress,
                            const Machine* fallback) {
    return readSessionBags(bagPaths(bag.string()), progress, fallback, {space, !space.empty()});
  };
  sources.writeBag = [](const Session& session, const std::filesystem::path& file,
                        const std::vector<MotionSample>& motion, const ProgressCallback& progress) {
    OutputFiles files;
    files.bag("output", file.string(), "imported from " + session.rowFile);
    files.check();
    files.write(file.string(), session, progress, motion);
  };
  sources.spaceOf = [space](const std::filesystem::path& bag) { return bagSpace(bag.string(), space); };
  sources.packageFolder = packageFolder;
  return sources;
}

int runWorkbench(WorkbenchCommand& c) {
  using namespace std::chrono_literals;
  c.bench.bag = c.bags.joined();
  c.bench.calibration = c.calibration;
  c.bench.store = c.store;
  c.server.token = newToken();
  Bench bench(c.bench, sourcesOf(c.space), c.server.token, nullptr);
  bench.begin();
  Interrupt::check();
  Server server(c.server, bench);
  bench.onNews([&server] { server.wake(); });
  std::cout << server.url() << std::endl;
  while (!Interrupt::asked()) std::this_thread::sleep_for(50ms);
  bench.onNews({});
  return kStopped;  // the way in which it ends
}

}  // namespace

void addWorkbenchCommand(CLI::App& app, int& exitStatus) {
  auto [c, command] = addCommand<WorkbenchCommand>(
      app, exitStatus, runWorkbench, "workbench", "Serve the workbench, a page in the browser, until Ctrl-C");
  c.bags.declare(command,
                 "the session, or several to evaluate together; without one, import a file on the page");
  command.get_option("bag")->required(false);
  command.add_option("--calibration", c.calibration,
                     "the calibration to start with (default: a model without effects)");
  standardOption(command, "--port", c.server.port, wholeNumberWithin(0, 65535),
                 "port to listen on; 0: any free port");
  command
      .add_option("--address", c.server.address,
                  "address to listen on; access is protected by the token only")
      ->capture_default_str();
  command.add_option("--host", c.server.hosts,
                     "further name by which a browser reaches it; needed with --address 0.0.0.0; repeatable");
  command.add_option("--store", c.store, "folder of calibrations, as for mm promote");
  standardOption(command, "--threads", c.bench.threads, wholeNumberWithin(0, 1024),
                 "number of threads; 0: one per core; does not affect the result");
  declareNamespace(command, c.space);
  command.footer(
      "Prints the address to open in a browser on this computer, including the access token. A calibration "
      "with an\n"
      "added effect is stored in the folder of calibrations as candidate.\n"
      "A file that the page imports is written as a bag beside the session's, else into the current folder.\n"
      "Example:\n"
      "  mm workbench plate.bag");
}

}  // namespace mm
