#include "ros_bridge/ending.h"

#include <ros/init.h>
#include <ros/network.h>
#include <ros/time.h>
#include <ros/xmlrpc_manager.h>

#include <atomic>
#include <csignal>

namespace mm {
namespace {

std::atomic<bool> asked{false};
static_assert(std::atomic<bool>::is_always_lock_free, "it is set by a signal");

void ask(int /*signal*/) { asked = true; }

}  // namespace

void endWhileRosLives() {
  struct sigaction ours {};
  ours.sa_handler = ask;
  sigemptyset(&ours.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (signal == SIGHUP && before.sa_handler == SIG_IGN) continue;
    sigaction(signal, &ours, nullptr);
  }
  ros::XMLRPCManager::instance()->unbind("shutdown");
  ros::XMLRPCManager::instance()->bind("shutdown",
                                       [](XmlRpc::XmlRpcValue& /*request*/, XmlRpc::XmlRpcValue& answer) {
                                         asked = true;
                                         answer = ros::xmlrpc::responseInt(1, "", 0);
                                       });
}

bool endAsked() { return asked; }

void waitForEnd() {
  while (!asked && ros::ok()) ros::WallDuration(0.02).sleep();
}

}  // namespace mm
