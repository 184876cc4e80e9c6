#pragma once
#include <ros/serialization.h>
#include <ros/service_traits.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <string>
#include <thread>
#include <vector>

namespace mm {

/// Services of ROS on a port of their own, each connection in a thread of its own: what the node's one thread
/// for sockets reads meanwhile, of whatever size, holds none of them up, and none of these another. To every
/// client they are services as any others (TCPROS). What is longer than these services need is refused.
class DirectServer {
 public:
  /// Listens. @throw Error when there is no port.
  DirectServer();
  /// Takes the services away from the master and ends every connection; calls that are answered now are
  /// waited for.
  ~DirectServer();
  DirectServer(const DirectServer&) = delete;
  DirectServer& operator=(const DirectServer&) = delete;

  /// @param name resolved. @param work is called in the thread of the connection, with the name that the
  /// caller gives of itself. Before `begin`.
  template <typename Service>
  void add(const std::string& name,
           std::function<void(const std::string& caller, const typename Service::Request&,
                              typename Service::Response&)>
               work) {
    namespace traits = ros::service_traits;
    Entry entry;
    entry.type = traits::DataType<Service>::value();
    entry.md5 = traits::MD5Sum<Service>::value();
    entry.answer = [work](const std::string& caller, std::vector<std::uint8_t>& bytes) {
      typename Service::Request request;
      typename Service::Response response;
      ros::serialization::IStream in(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
      ros::serialization::deserialize(in, request);
      work(caller, request, response);
      bytes.resize(ros::serialization::serializationLength(response));
      ros::serialization::OStream out(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
      ros::serialization::serialize(out, response);
    };
    services_.emplace(name, std::move(entry));
  }
  /// Takes connections, and tells the master of the services.
  void begin();
  /// Takes connections that nobody was told of. @return the port.
  std::uint16_t listen();
  /// One connection, from its greeting to its end; in the thread of whoever calls.
  void serve(int socket);

 private:
  using Fields = std::map<std::string, std::string>;
  struct Entry {
    std::string type, md5;
    std::function<void(const std::string&, std::vector<std::uint8_t>&)> answer;  // request in, response out
  };
  struct Connection {
    int socket = -1;
    std::atomic<bool> ended{false};
    std::thread thread;
  };

  void accept();
  const Entry* greet(int socket, Fields& fields);
  void tell(const std::string& method) const;

  std::map<std::string, Entry> services_;
  int listener_ = -1;
  std::uint16_t port_ = 0;
  std::atomic<bool> ending_{false};
  bool told_ = false;                  // the master was
  std::list<Connection> connections_;  // of the accepting thread, and of the destructor after it
  std::thread thread_;
};

}  // namespace mm
