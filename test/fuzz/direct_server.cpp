// What a client of the driver's stop sends: the greeting, and calls.
#include "ros_bridge/direct_server.h"

#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <sys/socket.h>
#include <unistd.h>

#include "fuzz_support.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static mm::DirectServer* const server = [] {
    auto* const one = new mm::DirectServer;
    one->add<std_srvs::Trigger>("/stop",
                                [](const std::string&, const std_srvs::TriggerRequest&,
                                   std_srvs::TriggerResponse& response) { response.success = true; });
    one->add<std_srvs::SetBool>("/halt",
                                [](const std::string& caller, const std_srvs::SetBoolRequest& request,
                                   std_srvs::SetBoolResponse& response) {
                                  response.success = request.data;
                                  response.message = caller;
                                });
    return one;
  }();
  int ends[2];
  constexpr std::size_t kMost = 600;  // bytes: what is answered to so many calls, nobody needs to read
  if (size > kMost || socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0) return 0;
  if (send(ends[0], data, size, MSG_DONTWAIT) == static_cast<ssize_t>(size)) {
    shutdown(ends[0], SHUT_WR);
    try {
      server->serve(ends[1]);
    } catch (const ros::serialization::StreamOverrunException&) {
      // A request that is too short; the server says so, and the connection ends.
    }
  }
  close(ends[0]);
  close(ends[1]);
  return 0;
}
