#pragma once
#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "workbench/web_handler.h"

namespace mm {

class HttpConnection;
class LiveSocket;

struct ServerOptions {
  std::string address = "127.0.0.1";      // every one (0.0.0.0, ::) needs one of `hosts`
  unsigned port = 0;                      // 0: any that is free
  std::string token;                      // empty: a new one
  std::vector<std::string> hosts;         // further names under which it is reached
  std::size_t largestBody = 64 << 10;     // bytes
  std::size_t largestImport = 256 << 10;  // of a preview or an import, which bring a URDF and an artifact
  std::size_t largestUpload = 256 << 20, largestHeader = 8 << 10;  // bytes
  std::size_t mostConnections = 256, mostWaiting = 128, mostSockets = 24;
  std::chrono::milliseconds undisturbed{500};   // before one that has not shown the token gives way
  double requestsASecond = 1000.0;              // of all clients that showed the token
  double messagesASecond = 20.0;                // of each live connection; what is more is not heard
  std::chrono::milliseconds headerTime{5000};   // from its first to its last letter
  std::chrono::milliseconds bodyTime{60000};    // the same of a body
  std::chrono::milliseconds answerTime{30000};  // until a client has taken its answer
  std::chrono::milliseconds idleTime{20000};    // of a live connection that answers no ping
};

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

/// An HTTP server on one thread with one WebSocket a client (`/live`). Each live connection holds the latest
/// state that it was not sent yet and no other: whoever is slow misses states and holds nobody up. A
/// connection that has not shown the token gives way to newer ones once it has had its time to; until then
/// they wait with the kernel, so that who comes in the midst of many still finishes its request.
class Server {
 public:
  /// Listens at once. @param handler must outlive it. @throw InputError: the port is taken, the address is
  /// not one of this computer.
  Server(ServerOptions options, WebHandler& handler);
  ~Server();  ///< ends every connection
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  unsigned port() const { return port_; }                      ///< that it listens on
  const std::string& token() const { return options_.token; }  ///< that each request shows
  /// Of the page, with the token; where every address is listened on, by a name or address that another
  /// computer can use too.
  std::string url() const;
  /// A state is due now, not only after the period. From any thread.
  void wake();

 private:
  friend class HttpConnection;  // each shares the rest, in the server's own thread
  friend class LiveSocket;
  void trusted(HttpConnection* connection);  ///< has shown the token
  void left(HttpConnection* connection);     ///< has ended
  void left(LiveSocket* socket);             ///< has ended; the handler is told
  /// The place for a file that is sent, kept as long as it is held; null: another has it.
  std::shared_ptr<void> placeForUpload();
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
  std::list<std::shared_ptr<HttpConnection>> waiting_, trusted_;  // without the token, and with; oldest first
  std::list<std::shared_ptr<LiveSocket>> sockets_;
  std::weak_ptr<void> upload_;
  std::uint64_t clients_ = 0, sequence_ = 0;
  std::chrono::steady_clock::time_point told_;  // the last state
  std::atomic<bool> waking_{false};
  std::thread thread_;
};

}  // namespace mm
