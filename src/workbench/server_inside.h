#pragma once
#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <thread>

#include "workbench/server.h"

namespace mm {

class HttpConnection;
class LiveSocket;

/// A budget that fills at a steady rate up to one second's worth.
class RateLimit {
 public:
  explicit RateLimit(double perSecond) : perSecond_(perSecond), left_(perSecond) {}  ///< full at first
  /// Takes one. @return whether there was one.
  bool take(std::chrono::steady_clock::time_point now);

 private:
  double perSecond_, left_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// What the connections of a server share. Everything but `wake` and `stop` is for its own thread.
class Server::Inside {
 public:
  Inside(ServerOptions options, WebHandler& handler);

  void begin();  ///< accepts, and starts the thread
  void stop();   ///< ends the connections and the thread
  void wake();   ///< sends the state now

  const ServerOptions& options() const { return options_; }         ///< with a token
  WebHandler& handler() { return handler_; }                        ///< as given
  const std::vector<std::string>& hosts() const { return hosts_; }  ///< under which it is reached
  unsigned port() const { return port_; }                           ///< that it listens on
  RateLimit& rate() { return rate_; }                               ///< of all requests together
  std::string url() const;                                          ///< of the page, with the token

  void joined(const std::shared_ptr<HttpConnection>& connection);  ///< has shown no token yet
  void trusted(HttpConnection* connection);                        ///< has shown it
  void left(HttpConnection* connection);                           ///< has ended
  /// Whether one more live connection is allowed.
  bool roomForSocket() const { return sockets_.size() < options_.mostSockets; }
  void joined(const std::shared_ptr<LiveSocket>& socket);  ///< asks to be live
  void left(LiveSocket* socket);                           ///< has ended; the handler is told
  /// The place for a file that is sent, kept as long as it is held; null: another has it.
  std::shared_ptr<void> placeForUpload();
  /// A number for a live connection.
  std::uint64_t nextClient() { return ++clients_; }

 private:
  void accept();                                              // the next, once there is a place for it
  void acceptAt(std::chrono::steady_clock::time_point when);  // or as soon as a place is free
  void admit(boost::asio::ip::tcp::socket socket);
  void tick();
  void tickAt(std::chrono::steady_clock::time_point when);

  ServerOptions options_;
  WebHandler& handler_;
  boost::asio::io_context context_{1};
  boost::asio::ip::tcp::acceptor acceptor_{context_};
  boost::asio::steady_timer timer_{context_}, pause_{context_};
  std::vector<std::string> hosts_;
  unsigned port_ = 0;
  RateLimit rate_;
  std::list<std::shared_ptr<HttpConnection>> waiting_, trusted_;  // oldest first
  std::list<std::shared_ptr<LiveSocket>> sockets_;
  std::weak_ptr<void> upload_;
  std::uint64_t clients_ = 0, sequence_ = 0;
  std::chrono::steady_clock::time_point told_;  // the last state
  std::atomic<bool> waking_{false};
  std::thread thread_;
};

}  // namespace mm
