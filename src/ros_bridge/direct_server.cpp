#include "ros_bridge/direct_server.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <ros/console.h>
#include <ros/header.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <ros/xmlrpc_manager.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <optional>

#include "base/error.h"

namespace mm {
namespace {

constexpr std::uint32_t kLongestFields = 16384, kLongestRequest = 4096;  // bytes
constexpr std::size_t kMostConnections = 200;
constexpr std::chrono::seconds kGreeting(2);  // for a client to say what it wants, and to take an answer
constexpr int kLookAgain = 50;                // ms between looks whether the end has come

using Clock = std::chrono::steady_clock;

/// @param until however little of it arrives now and then; none: for ever.
bool readAll(int socket, void* to, std::size_t bytes, std::optional<Clock::time_point> until) {
  auto* at = static_cast<std::uint8_t*>(to);
  while (bytes > 0) {
    if (until) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(*until - Clock::now()).count();
      pollfd ready{socket, POLLIN, 0};
      if (left <= 0 || poll(&ready, 1, static_cast<int>(left)) <= 0) return false;
    }
    const ssize_t got = recv(socket, at, bytes, 0);
    if (got <= 0) return false;
    at += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

/// Writes `first`, a length and as many bytes.
bool writeBlock(int socket, const std::string& first, const std::uint8_t* block, std::uint32_t size) {
  std::string all = first;
  all.append(reinterpret_cast<const char*>(&size), sizeof size);
  all.append(reinterpret_cast<const char*>(block), size);
  for (std::size_t done = 0; done < all.size();) {
    const ssize_t sent = send(socket, all.data() + done, all.size() - done, MSG_NOSIGNAL);
    if (sent <= 0) return false;
    done += static_cast<std::size_t>(sent);
  }
  return true;
}

/// A length and as many bytes. @return false: the connection ended, or it was more than `most`.
bool readBlock(int socket, std::uint32_t most, std::vector<std::uint8_t>& bytes,
               std::optional<Clock::time_point> until = {}) {
  std::uint32_t length = 0;  // little-endian, as the machines that ROS runs on
  if (!readAll(socket, &length, sizeof length, until) || length > most) return false;
  bytes.reserve(1);  // roscpp counts on from where they begin, also where there are none
  bytes.resize(length);
  return readAll(socket, bytes.data(), bytes.size(), until);
}

bool writeHeader(int socket, const ros::M_string& fields) {
  boost::shared_array<std::uint8_t> bytes;
  std::uint32_t size = 0;
  ros::Header::write(fields, bytes, size);
  return writeBlock(socket, {}, bytes.get(), size);
}

}  // namespace

DirectServer::DirectServer() {
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_ANY);
  socklen_t size = sizeof address;
  if (listener_ < 0 || ::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      ::listen(listener_, 64) != 0 ||
      getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    const std::string why = std::strerror(errno);
    if (listener_ >= 0) close(listener_);
    throw Error("no port for the stop service: " + why);
  }
  port_ = ntohs(address.sin_port);
}

DirectServer::~DirectServer() {
  ending_ = true;
  if (told_) tell("unregisterService");
  if (thread_.joinable()) thread_.join();
  for (Connection& connection : connections_) {
    ::shutdown(connection.socket, SHUT_RD);  // an answer that is on its way still leaves
    connection.thread.join();
    close(connection.socket);
  }
  close(listener_);
}

void DirectServer::begin() {
  listen();
  told_ = true;
  tell("registerService");
}

std::uint16_t DirectServer::listen() {
  thread_ = std::thread([this] { accept(); });
  return port_;
}

void DirectServer::tell(const std::string& method) const {
  for (const auto& service : services_) {
    XmlRpc::XmlRpcValue request, response, answer;
    request[0] = ros::this_node::getName();
    request[1] = service.first;
    request[2] = "rosrpc://" + ros::network::getHost() + ":" + std::to_string(port_);
    if (method == "registerService") request[3] = ros::XMLRPCManager::instance()->getServerURI();
    ros::master::execute(method, request, response, answer, method == "registerService");
  }
}

void DirectServer::accept() {
  while (!ending_) {
    pollfd ready{listener_, POLLIN, 0};
    if (poll(&ready, 1, kLookAgain) <= 0) continue;
    const int socket = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (socket < 0) continue;
    for (auto one = connections_.begin(); one != connections_.end();) {
      if (!one->ended) {
        ++one;
        continue;
      }
      one->thread.join();
      close(one->socket);
      one = connections_.erase(one);
    }
    if (connections_.size() >= kMostConnections) {
      ROS_ERROR_THROTTLE(1.0, "more than %zu connections to the stop service: one was refused",
                         kMostConnections);
      close(socket);
      continue;
    }
    Connection& connection = connections_.emplace_back();
    connection.socket = socket;
    connection.thread = std::thread([this, &connection] {
      try {
        serve(connection.socket);
      } catch (const std::exception& e) {
        ROS_ERROR("a stop request was not executed because it is damaged: %s", e.what());
      }
      ::shutdown(connection.socket, SHUT_RDWR);
      connection.ended = true;
    });
  }
}

/// The headers of both sides. @return the service; nullptr: there is none, which was said.
const DirectServer::Entry* DirectServer::greet(int socket, Fields& fields) {
  std::vector<std::uint8_t> header;
  if (!readBlock(socket, kLongestFields, header, Clock::now() + kGreeting)) return nullptr;
  for (std::size_t at = 0; at + 4 <= header.size();) {
    std::uint32_t length = 0;
    std::memcpy(&length, &header[at], sizeof length);
    at += 4;
    if (length > header.size() - at) return nullptr;
    const std::string field(header.begin() + static_cast<std::ptrdiff_t>(at),
                            header.begin() + static_cast<std::ptrdiff_t>(at + length));
    const std::size_t equals = field.find('=');
    if (equals != std::string::npos) fields[field.substr(0, equals)] = field.substr(equals + 1);
    at += length;
  }
  const auto found = services_.find(fields["service"]);
  std::string error;
  if (found == services_.end())
    error = "service [" + fields["service"] + "] is not here";
  else if (fields["md5sum"] != "*" && fields["md5sum"] != found->second.md5)
    error = "service [" + found->first + "] is a " + found->second.type + " of md5sum " + found->second.md5;
  if (!error.empty()) {
    writeHeader(socket, {{"error", error}});
    return nullptr;
  }
  const Entry& entry = found->second;
  const bool told = writeHeader(socket, {{"callerid", ros::this_node::getName()},
                                         {"md5sum", entry.md5},
                                         {"service", found->first},
                                         {"type", entry.type},
                                         {"request_type", entry.type + "Request"},
                                         {"response_type", entry.type + "Response"}});
  return told ? &entry : nullptr;
}

void DirectServer::serve(int socket) {
  const int on = 1;
  setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  setsockopt(socket, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
  const timeval patience{kGreeting.count(), 0};
  setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  Fields fields;
  const Entry* entry = greet(socket, fields);
  if (entry == nullptr || fields["probe"] == "1") return;
  const std::string called(1, '\1');
  std::vector<std::uint8_t> bytes;
  while (!ending_ && readBlock(socket, kLongestRequest, bytes)) {
    entry->answer(fields["callerid"], bytes);
    const bool told = writeBlock(socket, called, bytes.data(), static_cast<std::uint32_t>(bytes.size()));
    if (!told || fields["persistent"] != "1") return;
  }
}

}  // namespace mm
