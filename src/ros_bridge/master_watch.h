#pragma once
#include <ros/master.h>

#include <atomic>
#include <map>
#include <string>
#include <thread>
#include <vector>

namespace mm {

/// Keeps a node findable when the ROS master ends and another one comes: roscpp registers only once. Looks
/// every second whether the master knows this node; where it does not, registers every topic and service
/// again and sets those of the node's and of the machine's parameters that the new master has not. What is
/// connected goes on meanwhile. Says what happens on /rosout. Has a thread of its own, from `ros::init` on.
class MasterWatch {
 public:
  MasterWatch();
  ~MasterWatch();
  MasterWatch(const MasterWatch&) = delete;
  MasterWatch& operator=(const MasterWatch&) = delete;

 private:
  void run();
  void look();
  void remember();
  bool registerAgain();  ///< false: not all could be told; tried again at the next look
  bool call(const std::string& method, const std::vector<std::string>& words,
            XmlRpc::XmlRpcValue& answer) const;

  bool known_ = false;  // the master knew this node once
  bool away_ = false;   // the master does not answer
  int turns_ = 0;
  int master_ = 0;                               // its process
  std::map<std::string, std::string> services_;  // and where each of them is
  std::map<std::string, XmlRpc::XmlRpcValue> parameters_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace mm
