#include "workbench/server.h"

#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/connect.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <condition_variable>
#include <fstream>
#include <mutex>
#include <thread>

#include "base/error.h"
#include "session_files.h"
#include "web_client.h"

namespace mm {
namespace {

using namespace std::chrono_literals;
namespace beast = boost::beast;

/// Counts what reaches it: nothing of what is refused may.
class CountingHandler : public WebHandler {
 public:
  WebAnswer get(const std::string& path) override {
    ++gets;
    if (path == "/throws") throw InputError("it cannot be had");
    return WebAnswer::text("page of " + path, "text/plain");
  }
  WebAnswer post(const std::string& path, const std::string&, std::string body, const std::string&) override {
    ++posts;
    return WebAnswer::text(path + " took " + std::to_string(body.size()), "text/plain");
  }
  std::string live() override { return "\"load\":\"" + std::string(load, 'x') + "\""; }
  std::chrono::milliseconds period() override { return 2ms; }
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

TEST_F(ServerTest, AnswersWhoShowsTheToken) {
  start();
  EXPECT_NE(server_->url().find("http://127.0.0.1:"), std::string::npos);
  expectAlive();
  const std::string byHeader =
      answerTo(request("GET /x", "X-Workbench-Token: " + server_->token() + "\r\nConnection: close\r\n"));
  EXPECT_EQ(status(byHeader), 200);
  const std::string byPath =
      answerTo(request("GET /t/" + server_->token() + "/app/main.js", "Connection: close\r\n"));
  EXPECT_NE(byPath.find("page of /app/main.js"), std::string::npos);
  const std::string post = answerTo(
      request("POST " + withToken("/action/add"), "Connection: close\r\nContent-Length: 4\r\n", "abcd"));
  EXPECT_NE(post.find("/action/add took 4"), std::string::npos);
  const std::string thrown = answerTo(request("GET " + withToken("/throws"), "Connection: close\r\n"));
  EXPECT_EQ(status(thrown), 400);
  EXPECT_NE(thrown.find("it cannot be had"), std::string::npos);
  for (const char* header : {"Content-Security-Policy: default-src 'none'", "X-Content-Type-Options: nosniff",
                             "Cache-Control: no-store", "Referrer-Policy: no-referrer"})
    EXPECT_NE(byPath.find(header), std::string::npos) << header;
}

TEST_F(ServerTest, RefusesForeignersBeforeAnythingIsAsked) {
  start();
  const std::string target = withToken("/x");
  const std::string line = "GET " + target + " HTTP/1.1\r\n", mine = "Host: " + host() + "\r\n";
  EXPECT_EQ(status(answerTo(line + "Host: evil.example\r\n\r\n")), 421);
  EXPECT_EQ(status(answerTo(line + "\r\n")), 421);
  EXPECT_EQ(status(answerTo(line + mine + mine + "\r\n")), 421);
  EXPECT_EQ(status(answerTo(line + "Host: 127.0.0.1:1\r\n\r\n")), 421);
  for (const char* origin : {"http://evil.example", "null", "https://127.0.0.1", "http://127.0.0.1"})
    EXPECT_EQ(status(answerTo(line + mine + "Origin: " + origin + "\r\n\r\n")), 403) << origin;
  EXPECT_EQ(status(answerTo(request("GET /x"))), 403);
  EXPECT_EQ(status(answerTo(request("GET /x?token="))), 403);
  EXPECT_EQ(status(answerTo(request("GET /x?token=" + std::string(32, '0')))), 403);
  EXPECT_EQ(status(answerTo(request("GET /t/" + std::string(32, '0') + "/x"))), 403);
  EXPECT_EQ(status(answerTo(request("POST /action/add", "Content-Length: 2\r\n", "{}"))), 403);
  EXPECT_EQ(status(answerTo(request("PUT " + target))), 405);
  EXPECT_EQ(status(answerTo(request("OPTIONS " + target))), 405);
  EXPECT_EQ(handler_.gets + handler_.posts, 0);
  expectAlive();
}

TEST_F(ServerTest, NoPathOfAClientIsAPathOnDisk) {
  start();
  for (const char* path :
       {"/../../etc/passwd", "/app/%2e%2e/%2e%2e/etc/passwd", "/app/..%5c..%5cx", "/a%00.js"})
    EXPECT_EQ(status(answerTo(request("GET " + withToken(path)))), 400) << path;
  EXPECT_EQ(status(answerTo(request("GET " + std::string(600, '/')))), 400);
  EXPECT_EQ(handler_.gets, 0);
  expectAlive();
}

TEST_F(ServerTest, WhatIsNotHttpIsTurnedAway) {
  start();
  for (const std::string& text :
       {std::string("\r\n\r\n"), std::string("GET\r\n\r\n"), std::string("GET / HTTP/9.9\r\n\r\n"),
        std::string("\x16\x03\x01\x02\x00\x01\x00", 7), std::string(3000, '\0'),
        std::string("G E T / HTTP/1.1\r\n\r\n"), request("GET " + withToken("/x"), "Content-Length: -1\r\n"),
        request("POST " + withToken("/x"), "Transfer-Encoding: chunked\r\n", "zz\r\n")}) {
    const std::string answer = answerTo(text + "\r\n\r\n");
    EXPECT_NE(status(answer), 200) << text.substr(0, 40);
  }
  EXPECT_EQ(
      status(answerTo("GET " + withToken("/x") + " HTTP/1.1\r\nX: " + std::string(20000, 'a') + "\r\n\r\n")),
      431);
  EXPECT_EQ(handler_.gets + handler_.posts, 0);
  expectAlive();
}

TEST_F(ServerTest, BodiesAreBounded) {
  options_.largestBody = 1000;
  options_.largestUpload = 2000;
  start();
  EXPECT_EQ(status(answerTo(request("POST " + withToken("/action/add"), "Content-Length: 1001\r\n"))), 413);
  // said from its header alone: nothing of a gigabyte is read
  EXPECT_EQ(status(answerTo(request("POST " + withToken("/upload"), "Content-Length: 1073741824\r\n"))), 413);
  EXPECT_EQ(
      status(answerTo(request("POST " + withToken("/upload"), "Content-Length: 99999999999999999999\r\n"))),
      400);
  std::string chunks;
  for (int i = 0; i < 50; ++i) chunks += "32\r\n" + std::string(50, 'x') + "\r\n";
  EXPECT_EQ(
      status(answerTo(request("POST " + withToken("/action/add"), "Transfer-Encoding: chunked\r\n", chunks))),
      413);
  EXPECT_EQ(
      status(answerTo(request("POST " + withToken("/upload"), "Transfer-Encoding: chunked\r\n", chunks))),
      413);
  EXPECT_EQ(handler_.posts, 0);
  const std::string fits =
      answerTo(request("POST " + withToken("/upload"), "Content-Length: 2000\r\nConnection: close\r\n",
                       std::string(2000, 'x')));
  EXPECT_NE(fits.find("took 2000"), std::string::npos) << fits;
  expectAlive();
}

TEST_F(ServerTest, WhoDawdlesLosesTheConnection) {
  options_.headerTime = 1s;
  options_.bodyTime = 1s;
  start();
  RawClient header(server_->port()), body(server_->port()), silent(server_->port());
  EXPECT_TRUE(header.send("GET / HTTP/1.1\r\nHost: "));
  EXPECT_TRUE(body.send(request("POST " + withToken("/action/add"), "Content-Length: 10\r\n", "ab")));
  EXPECT_EQ(header.readToEnd(), "");
  EXPECT_EQ(body.readToEnd(), "");
  EXPECT_EQ(silent.readToEnd(), "");
  EXPECT_EQ(handler_.posts, 0);
  expectAlive();
}

TEST_F(ServerTest, WhoShowsNoTokenGivesWay) {
  options_.mostWaiting = 4;
  start();
  std::vector<std::unique_ptr<RawClient>> loris;
  for (int i = 0; i < 40; ++i) {
    loris.push_back(std::make_unique<RawClient>(server_->port()));
    loris.back()->send("GET / HTTP/1.1\r\nX-");
  }
  for (int i = 0; i < 36; ++i) EXPECT_EQ(loris[static_cast<std::size_t>(i)]->readToEnd(), "") << i;
  expectAlive();
}

TEST_F(ServerTest, ConnectionsAreBounded) {
  options_.mostConnections = 5;
  start();
  std::vector<std::unique_ptr<RawClient>> clients;
  for (int i = 0; i < 5; ++i) {
    clients.push_back(std::make_unique<RawClient>(server_->port()));
    clients.back()->send(request("GET " + withToken("/keep")));
    EXPECT_NE(clients.back()->readUntil("page of /keep").find("page of /keep"), std::string::npos);
  }
  EXPECT_EQ(status(answerTo("")), 503);
  clients.pop_back();
  // the place is free as soon as the server has seen that the client is gone
  int last = 0;
  for (int tries = 0; tries < 1000 && last != 200; ++tries)
    last = status(answerTo(request("GET " + withToken("/x"), "Connection: close\r\n")));
  EXPECT_EQ(last, 200);
}

TEST_F(ServerTest, RequestsASecondAreBounded) {
  options_.requestsASecond = 5;
  start();
  RawClient client(server_->port());
  int refused = 0, answered = 0;
  for (int i = 0; i < 400; ++i) {
    client.forget();
    ASSERT_TRUE(client.send(request("GET " + withToken("/x"))));
    const std::string answer = client.readUntil("\r\n\r\n");
    if (status(answer) == 429) ++refused;
    if (status(answer) == 200) {
      client.readUntil("page of /x");
      ++answered;
    } else {
      client.readUntil("second\"}");
    }
  }
  EXPECT_EQ(refused + answered, 400);
  EXPECT_GE(answered, 5);
  EXPECT_GT(refused, 100);
}

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

std::uint64_t sequenceOf(const std::string& state) {
  const std::size_t at = state.find("\"sequence\":");
  return at == std::string::npos ? 0 : std::stoull(state.substr(at + 11));
}

TEST_F(ServerTest, LiveConnectionsAreForThisPageAlone) {
  start();
  EXPECT_EQ(status(upgrade("http://evil.example", server_->token())), 403);
  EXPECT_EQ(status(upgrade("null", server_->token())), 403);
  EXPECT_EQ(status(upgrade("http://" + host(), "no")), 403);
  EXPECT_FALSE(LiveClient(*server_, "http://evil.example", server_->token()).open());
  LiveClient client(*server_, "http://" + host(), server_->token());
  ASSERT_TRUE(client.open());
  EXPECT_NE(client.read().find("\"client\":1"), std::string::npos);
  const std::uint64_t first = sequenceOf(client.read()), second = sequenceOf(client.read());
  EXPECT_GT(first, 0u);
  EXPECT_GT(second, first);
  client.write("heartbeat");
  EXPECT_TRUE(handler_.wait([this] { return handler_.lastHeard == 1; }));
  client.drop();
  EXPECT_TRUE(handler_.wait([this] { return handler_.lastGone == 1; }));
}

TEST_F(ServerTest, WhoSaysNonsenseOrTooMuchIsDropped) {
  start();
  LiveClient nonsense(*server_, "", server_->token()), much(*server_, "", server_->token());
  ASSERT_TRUE(nonsense.open() && much.open());
  nonsense.write("move x");
  EXPECT_TRUE(handler_.wait([this] { return handler_.lastGone == 1; }));
  much.write(std::string(100000, 'x'));
  EXPECT_TRUE(handler_.wait([this] { return handler_.lastGone == 2; }));
  expectAlive();
}

TEST_F(ServerTest, LiveConnectionsAreBounded) {
  options_.mostSockets = 2;
  start();
  LiveClient a(*server_, "", server_->token()), b(*server_, "", server_->token());
  ASSERT_TRUE(a.open() && b.open());
  EXPECT_EQ(status(upgrade("http://" + host(), server_->token())), 503);
}

long residentKb() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmRSS:", 0) == 0) return std::stol(line.substr(6));
  return 0;
}

TEST_F(ServerTest, WhoStallsMissesStatesAndHoldsNobodyUp) {
  handler_.load = 20000;
  start();
  LiveClient stalled(*server_, "", server_->token());
  std::vector<std::unique_ptr<LiveClient>> others;
  for (int i = 0; i < 9; ++i) others.push_back(std::make_unique<LiveClient>(*server_, "", server_->token()));
  const auto readAll = [&](int rounds) {
    for (int k = 0; k < rounds; ++k)
      for (auto& other : others) ASSERT_FALSE(other->read().empty());
  };
  readAll(50);
  const long before = residentKb();
  readAll(600);  // 12 MB a client, which the stalled one does not take
  EXPECT_LT(residentKb() - before, 20000);
  ASSERT_TRUE(stalled.open());
  // what it takes now: what was under way when it stalled, then the latest
  std::uint64_t last = 0;
  std::size_t taken = 0;
  const std::uint64_t latest = sequenceOf(others.front()->read());
  while (last < latest) {
    const std::string state = stalled.read();
    ASSERT_FALSE(state.empty());
    const std::uint64_t sequence = sequenceOf(state);
    EXPECT_TRUE(sequence == 0 || sequence > last) << sequence << " after " << last;
    last = std::max(last, sequence);
    ++taken;
  }
  EXPECT_LT(taken, latest / 2) << "states wait in a queue";
}

TEST_F(ServerTest, APortThatIsTakenIsSaid) {
  start();
  ServerOptions again;
  again.port = server_->port();
  const std::string message = test::messageOf<InputError>([&] { Server second(again, handler_); });
  EXPECT_NE(message.find("port " + std::to_string(again.port)), std::string::npos) << message;
  ServerOptions elsewhere;
  elsewhere.address = "nowhere";
  EXPECT_THROW(Server(elsewhere, handler_), InputError);
}

}  // namespace
}  // namespace mm
