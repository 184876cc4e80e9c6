#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

namespace mm {

/// What a client gets.
struct WebAnswer {
  unsigned status = 200;
  std::string type = "application/json";
  std::shared_ptr<const std::string> body;  // null: none
  std::string fileName;                     // not empty: to be kept under this name
  std::string policy;                       // Content-Security-Policy; empty: nothing may be loaded

  /// `{"message": …}`: refusals and confirmations are sentences.
  static WebAnswer say(unsigned status, const std::string& message);
  /// A text of its own.
  static WebAnswer text(std::string body, std::string type = "application/json");
};

/// What stands behind the server. Every call comes from the server's own thread, one at a time, from clients
/// that showed the token: it must answer at once and leave long work to another thread. Whatever it throws is
/// answered as `{"message": what()}`.
class WebHandler {
 public:
  virtual ~WebHandler() = default;
  /// @param path without token and query.
  virtual WebAnswer get(const std::string& path) = 0;
  /// @param query as it came. @param who says who asks, for the log.
  virtual WebAnswer post(const std::string& path, const std::string& query, std::string body,
                         const std::string& who) = 0;
  /// The state of this moment: the members of a JSON object without its braces.
  virtual std::string live() = 0;
  /// How long it is until the next state is due.
  virtual std::chrono::milliseconds period() = 0;
  /// The live connection of this number is open.
  virtual void came(std::uint64_t client) = 0;
  /// A message of the client whose live connection has this number.
  virtual void heard(std::uint64_t client, const std::string& text) = 0;
  /// Its live connection has ended, however.
  virtual void gone(std::uint64_t client) = 0;
};

}  // namespace mm
