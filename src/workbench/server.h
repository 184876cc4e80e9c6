#pragma once
#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "workbench/web_handler.h"

namespace mm {

struct ServerOptions {
  std::string address = "127.0.0.1";
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

  unsigned port() const;             ///< that it listens on
  const std::string& token() const;  ///< that each request shows
  /// Of the page, with the token; where every address is listened on, by a name or address that another
  /// computer can use too.
  std::string url() const;
  /// A state is due now, not only after the period. From any thread.
  void wake();

  class Inside;  ///< private to the sources of this folder

 private:
  std::unique_ptr<Inside> inside_;
};

}  // namespace mm
