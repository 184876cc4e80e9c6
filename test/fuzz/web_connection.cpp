// What a client of the workbench sends, letter by letter, to a server on the loopback: HTTP, and frames of a
// live connection. Its host is `bench`, its token 0123456789abcdef0123456789abcdef.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <cerrno>

#include "fuzz_support.h"
#include "workbench/server.h"

namespace {

const char* const kToken = "0123456789abcdef0123456789abcdef";

class Handler : public mm::WebHandler {
 public:
  mm::WebAnswer get(const std::string& path) override { return answer(path, 0); }
  mm::WebAnswer post(const std::string& path, const std::string& /*query*/, std::string body,
                     const std::string& /*who*/) override {
    return answer(path, body.size());
  }
  std::string live() override { return "\"machine\":null"; }
  std::chrono::milliseconds period() override { return std::chrono::milliseconds(20); }
  void came(std::uint64_t /*client*/) override { ++cameCount; }
  void heard(std::uint64_t /*client*/, const std::string& text) override {
    if (text != "heartbeat") throw mm::InputError("a page says 'heartbeat' and nothing else");
  }
  void gone(std::uint64_t /*client*/) override { ++goneCount; }
  std::atomic<long> calls{0}, cameCount{0}, goneCount{0};

 private:
  mm::WebAnswer answer(const std::string& path, std::size_t size) {
    ++calls;
    if (path.empty() || path.front() != '/' || path.find("..") != std::string::npos)
      mm::fuzz::broken("a path is one of this server's");
    if (size > kLargestFile) mm::fuzz::broken("a body is bounded");
    return mm::WebAnswer::text("page", "text/plain");
  }

 public:
  static constexpr std::size_t kLargestFile = 2000;
};

mm::ServerOptions options() {
  mm::ServerOptions options;
  options.token = kToken;
  options.hosts = {"bench:80"};
  options.largestBody = 500;
  options.largestUpload = Handler::kLargestFile;
  options.requestsASecond = 1e9;
  options.headerTime = std::chrono::seconds(60);  // who says no more is let go at once, not after a time
  return options;
}

/// Sends all of it and reads to the end. @return what was answered.
std::string talk(unsigned port, const std::string& text) {
  const int s = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (s < 0 || ::connect(s, reinterpret_cast<sockaddr*>(&to), sizeof to) != 0)
    mm::fuzz::broken("the server takes connections");
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t n = ::send(s, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;  // it has turned us away
    sent += static_cast<std::size_t>(n);
  }
  ::shutdown(s, SHUT_WR);
  std::string got;
  for (;;) {
    pollfd wait{s, POLLIN, 0};
    const int ready = ::poll(&wait, 1, 30000);
    if (ready < 0 && errno == EINTR) continue;  // the fuzzer's own clock
    if (ready <= 0) mm::fuzz::broken("who says no more is answered, or let go");
    char buffer[65536];
    const ssize_t n = ::recv(s, buffer, sizeof buffer, 0);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    got.append(buffer, static_cast<std::size_t>(n));
  }
  ::close(s);
  return got;
}

/// Percent signs resolved where they can be.
std::string resolved(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%' && i + 2 < text.size() && std::isxdigit(static_cast<unsigned char>(text[i + 1])) &&
        std::isxdigit(static_cast<unsigned char>(text[i + 2]))) {
      out += static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      out += text[i];
    }
  }
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Handler& handler = *new Handler;
  static mm::Server& server = *new mm::Server(options(), handler);
  static int count = 0;
  const std::string text = mm::fuzz::textOf(data, size);
  const long calls = handler.calls, came = handler.cameCount;
  const std::string answer = talk(server.port(), text);
  const bool shown = resolved(text).find(kToken) != std::string::npos;
  if (!shown && (handler.calls != calls || handler.cameCount != came))
    mm::fuzz::broken("nothing without the token");
  if (!shown && answer.rfind("HTTP/1.1 2", 0) == 0) mm::fuzz::broken("no answer without the token");
  if (!answer.empty() && answer.rfind("HTTP/1.1 ", 0) != 0) mm::fuzz::broken("an answer is HTTP");
  if (++count % 16 == 0) {
    const std::string page = talk(server.port(), std::string("GET /x?token=") + kToken +
                                                     " HTTP/1.1\r\nHost: bench\r\nConnection: close\r\n\r\n");
    if (page.rfind("HTTP/1.1 200", 0) != 0) mm::fuzz::broken("it lives: " + page);
    if (handler.goneCount < came) mm::fuzz::broken("who came has gone");
  }
  return 0;
}
