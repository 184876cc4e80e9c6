#pragma once
#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/connect.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <condition_variable>
#include <fstream>
#include <mutex>

#include "base/error.h"
#include "session_files.h"
#include "web_client.h"
#include "workbench/server.h"

namespace mm::test {

using namespace std::chrono_literals;
namespace beast = boost::beast;

/// Counts what reaches it: nothing of what is refused may.
class CountingHandler : public WebHandler {
 public:
  WebAnswer get(const std::string& path) override {
    ++gets;
    if (path == "/big") return big;
    if (path == "/throws") throw InputError("it cannot be had");
    return WebAnswer::text("page of " + path, "text/plain");
  }
  WebAnswer post(const std::string& path, const std::string&, std::string body, const std::string&) override {
    ++posts;
    return WebAnswer::text(path + " took " + std::to_string(body.size()), "text/plain");
  }
  std::string live() override {
    const std::lock_guard<std::mutex> lock(mutex);
    ++states;
    changed.notify_all();
    if (throws.exchange(false)) throw InputError("no state just now");
    return "\"load\":\"" + std::string(load, 'x') + "\"";
  }
  std::chrono::milliseconds period() override { return 2ms; }
  void came(std::uint64_t client) override { lastCame = client; }
  void heard(std::uint64_t client, const std::string& text) override {
    if (text != "heartbeat") throw InputError("unknown");
    const std::lock_guard<std::mutex> lock(mutex);
    lastHeard = client;
    changed.notify_all();
  }
  void gone(std::uint64_t client) override {
    const std::lock_guard<std::mutex> lock(mutex);
    lastGone = client;
    changed.notify_all();
  }
  template <typename Condition>
  bool wait(Condition condition) {
    std::unique_lock<std::mutex> lock(mutex);
    return changed.wait_for(lock, 20s, condition);
  }
  std::atomic<int> gets{0}, posts{0};
  std::atomic<std::size_t> load{10};
  std::atomic<std::uint64_t> lastCame{0};
  std::atomic<bool> throws{false};
  std::uint64_t states = 0;  // asked for
  WebAnswer big;
  std::mutex mutex;
  std::condition_variable changed;
  std::uint64_t lastHeard = 0, lastGone = 0;
};

class ServerTest : public ::testing::Test {
 protected:
  ServerOptions options_;
  CountingHandler handler_;
  std::unique_ptr<Server> server_;

  void start() { server_ = std::make_unique<Server>(options_, handler_); }
  std::string host() const { return "127.0.0.1:" + std::to_string(server_->port()); }
  std::string request(const std::string& line, const std::string& more = "",
                      const std::string& body = "") const {
    return line + " HTTP/1.1\r\nHost: " + host() + "\r\n" + more + "\r\n" + body;
  }
  std::string withToken(const std::string& path) const { return path + "?token=" + server_->token(); }
  /// One request in a connection of its own, which it asks to be closed.
  std::string answerTo(const std::string& text) const {
    RawClient client(server_->port());
    client.send(text);
    return client.readToEnd();
  }
  static int status(const std::string& answer) {
    return answer.rfind("HTTP/1.1 ", 0) == 0 ? std::stoi(answer.substr(9, 3)) : 0;
  }
  /// Nothing that was sent before has done harm.
  void expectAlive() {
    const int before = handler_.gets;
    const std::string answer = answerTo(request("GET " + withToken("/alive"), "Connection: close\r\n"));
    EXPECT_EQ(status(answer), 200) << answer.substr(0, 300);
    EXPECT_NE(answer.find("page of /alive"), std::string::npos);
    EXPECT_EQ(handler_.gets, before + 1);
  }
  /// What is answered to a live connection that is refused.
  std::string upgrade(const std::string& origin, const std::string& token) const {
    return answerTo(
        request("GET /live?token=" + token,
                "Origin: " + origin +
                    "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                    "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"));
  }
  using RawClient = test::RawClient;
};

/// A browser's side of the live connection.
class LiveClient {
 public:
  LiveClient(const Server& server, const std::string& origin, const std::string& token) {
    boost::asio::ip::tcp::socket& tcp = beast::get_lowest_layer(socket_).socket();
    tcp.connect({boost::asio::ip::address_v4::loopback(), static_cast<unsigned short>(server.port())});
    const std::string host = "127.0.0.1:" + std::to_string(server.port());
    socket_.set_option(beast::websocket::stream_base::decorator([&](beast::websocket::request_type& r) {
      if (!origin.empty()) r.set(beast::http::field::origin, origin);
    }));
    socket_.handshake(host, "/live?token=" + token, error_);
  }
  bool open() const { return !error_; }
  std::string read() {
    beast::flat_buffer buffer;
    socket_.read(buffer, error_);
    return error_ ? std::string() : beast::buffers_to_string(buffer.data());
  }
  void write(const std::string& text) { socket_.write(boost::asio::buffer(text), error_); }
  void drop() { beast::get_lowest_layer(socket_).close(); }

 private:
  boost::asio::io_context context_;
  beast::websocket::stream<beast::tcp_stream> socket_{context_};
  beast::error_code error_;
};

inline std::uint64_t sequenceOf(const std::string& state) {
  const std::size_t at = state.find("\"sequence\":");
  return at == std::string::npos ? 0 : std::stoull(state.substr(at + 11));
}

/// Memory of this process, KB.
inline long residentKb() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmRSS:", 0) == 0) return std::stol(line.substr(6));
  return 0;
}

}  // namespace mm::test
