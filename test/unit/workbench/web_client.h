#pragma once
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <string>

namespace mm::test {

/// A client that sends what it is told, well formed or not.
class RawClient {
 public:
  explicit RawClient(unsigned port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof to) == 0;
  }
  ~RawClient() { ::close(socket_); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  bool connected() const { return connected_; }
  /// @return whether all of it was taken.
  bool send(const std::string& text) {
    std::size_t sent = 0;
    while (sent < text.size()) {
      const ssize_t n = ::send(socket_, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
      if (n <= 0) return false;
      sent += static_cast<std::size_t>(n);
    }
    return true;
  }
  /// Reads until the other side closes; at most 20 s of silence, see closed().
  std::string readToEnd() {
    while (readSome()) {
    }
    return std::move(got_);
  }
  /// Reads until `what` has come. @return everything so far; without `what` where the other side closed.
  std::string readUntil(const std::string& what) {
    while (got_.find(what) == std::string::npos && readSome()) {
    }
    return got_;
  }
  void forget() { got_.clear(); }
  /// Whether the other side has ended the connection, as far as was read.
  bool closed() const { return closed_; }

 private:
  bool readSome() {
    pollfd wait{socket_, POLLIN, 0};
    if (::poll(&wait, 1, 20000) <= 0) return false;
    char buffer[65536];
    const ssize_t n = ::recv(socket_, buffer, sizeof buffer, 0);
    if (n == 0 || (n < 0 && errno == ECONNRESET)) closed_ = true;
    if (n <= 0) return false;
    got_.append(buffer, static_cast<std::size_t>(n));
    return true;
  }
  int socket_;
  bool connected_ = false, closed_ = false;
  std::string got_;
};

}  // namespace mm::test
