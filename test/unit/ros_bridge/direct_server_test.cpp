#include "ros_bridge/direct_server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <ros/time.h>
#include <std_srvs/SetBool.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <list>
#include <thread>
#include <utility>

#include "direct_call.h"

namespace mm {
namespace {

using std_srvs::SetBool;
const char* const kMd5 = ros::service_traits::MD5Sum<SetBool>::value();

class DirectServerTest : public ::testing::Test {
 protected:
  DirectServerTest() {
    ros::Time::init();  // its messages are throttled
    server_.add<SetBool>("/stop", [this](const std::string& caller, const SetBool::Request& request,
                                         SetBool::Response& response) {
      ++calls_;
      response.success = request.data;
      response.message = caller;
    });
    port_ = server_.listen();
  }

  /// A connection of a client; what never comes is an end after ten seconds.
  class Client {
   public:
    explicit Client(std::uint16_t port) {
      sockaddr_in address{};
      address.sin_family = AF_INET;
      address.sin_port = htons(port);
      address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      const timeval patience{10, 0};
      setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
      ::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address);  // else nothing can be sent
    }
    ~Client() { ::close(socket_); }
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;
    bool send(const std::string& bytes) {
      return ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
    }
    void sendNoMore() { ::shutdown(socket_, SHUT_WR); }
    /// @return fewer where the connection has ended.
    std::string read(std::size_t bytes) {
      std::string got(bytes, '\0');
      const ssize_t count = recv(socket_, got.data(), bytes, MSG_WAITALL);
      got.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
      return got;
    }
    std::string readBlock() {
      const std::string length = read(4);
      if (length.size() < 4) return {};
      std::uint32_t bytes = 0;
      for (int i = 3; i >= 0; --i) bytes = bytes << 8 | static_cast<std::uint8_t>(length[i]);
      return read(bytes);
    }

   private:
    int socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
  };

  Client client() const { return Client(port_); }
  static std::string fields(const std::string& service = "/stop", const std::string& md5 = kMd5,
                            const std::string& persistent = "1") {
    return greeting({"callerid=/panel", "service=" + service, "md5sum=" + md5, "persistent=" + persistent});
  }
  static std::string request(bool data) { return block(std::string(1, static_cast<char>(data))); }
  /// Greets, and calls once.
  void expectAnswer() {
    Client good = client();
    ASSERT_TRUE(good.send(fields() + request(true)));
    EXPECT_NE(good.readBlock().find("type=std_srvs/SetBool"), std::string::npos);
    EXPECT_EQ(good.read(1), "\1");
    EXPECT_EQ(good.readBlock(), "\1" + block("/panel"));
  }

  DirectServer server_;
  std::atomic<int> calls_{0};
  std::uint16_t port_ = 0;
};

TEST_F(DirectServerTest, AnswersCallAfterCallOnAConnectionThatStays) {
  Client panel = client();
  ASSERT_TRUE(panel.send(fields()));
  panel.readBlock();
  for (int call = 1; call <= 3; ++call) {
    ASSERT_TRUE(panel.send(request(call == 2)));
    EXPECT_EQ(panel.read(1), "\1");
    EXPECT_EQ(panel.readBlock()[0], call == 2 ? '\1' : '\0');
    EXPECT_EQ(calls_, call);
  }
}

TEST_F(DirectServerTest, OneThatDoesNotStayEndsAfterItsCall) {
  Client once = client();
  ASSERT_TRUE(once.send(fields("/stop", "*", "0") + request(true)));
  once.readBlock();
  once.read(1);
  EXPECT_EQ(once.readBlock(), "\1" + block("/panel"));
  EXPECT_EQ(once.read(1), "") << "the end";
}

TEST_F(DirectServerTest, AWrongServiceOrTypeIsNamed) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {fields("/halt"), "error=service [/halt] is not here"},
      {fields("/stop", "abc"), "error=service [/stop] is a std_srvs/SetBool of md5sum " + std::string(kMd5)},
      {greeting({}), "error=service [] is not here"},
      {greeting({"no field", "=", "service"}), "error=service [] is not here"}};
  for (const auto& [bytes, error] : cases) {
    Client wrong = client();
    ASSERT_TRUE(wrong.send(bytes));
    EXPECT_EQ(wrong.readBlock(), block(error));
    EXPECT_EQ(wrong.read(1), "") << "the end";
  }
  EXPECT_EQ(calls_, 0);
}

TEST_F(DirectServerTest, WhatIsNoGreetingEndsTheConnection) {
  const std::string good = fields();
  for (const std::string& bytes :
       {std::string("GET / HTTP/1.1\r\n\r\n"), lengthBytes(0xffffffff), lengthBytes(0x7fffffff),
        lengthBytes(16385), block(lengthBytes(0xffffffff) + "service=/stop"),
        block(lengthBytes(99) + "a=b")}) {
    Client wrong = client();
    ASSERT_TRUE(wrong.send(bytes));
    EXPECT_EQ(wrong.read(1), "") << "the end, at once";
  }
  for (std::size_t cut = 0; cut < good.size(); ++cut) {
    Client wrong = client();
    ASSERT_TRUE(wrong.send(good.substr(0, cut)));
    wrong.sendNoMore();
    EXPECT_EQ(wrong.read(1), "") << cut;
  }
  EXPECT_EQ(calls_, 0);
  expectAnswer();
}

TEST_F(DirectServerTest, ARequestOfAnotherLengthCallsNothing) {
  for (const std::string& bytes : {lengthBytes(0xffffffff), lengthBytes(4097), block("")}) {
    Client wrong = client();
    ASSERT_TRUE(wrong.send(fields() + bytes));
    wrong.readBlock();
    EXPECT_EQ(wrong.read(1), "") << "the end, at once";
  }
  EXPECT_EQ(calls_, 0);
  expectAnswer();
}

// Two seconds for the whole greeting, however it comes: else two hundred such would keep everybody out.
TEST_F(DirectServerTest, WhoSaysNothingOrLittleIsNotWaitedFor) {
  using Clock = std::chrono::steady_clock;
  const auto began = Clock::now();
  Client silent = client(), slow = client();
  std::thread drips([&] {
    for (int i = 0; i < 100 && slow.send(std::string(1, '\1')); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
  });
  expectAnswer();
  EXPECT_LT(Clock::now() - began, std::chrono::seconds(1)) << "behind neither of them";
  EXPECT_EQ(silent.read(1), "");
  EXPECT_EQ(slow.read(1), "");
  EXPECT_LT(Clock::now() - began, std::chrono::seconds(8));
  drips.join();
}

TEST_F(DirectServerTest, BeyondTwoHundredConnectionsNewOnesAreRefusedUntilOneEnds) {
  std::list<Client> many;
  for (int i = 0; i < 200; ++i) {
    many.emplace_back(port_);
    ASSERT_TRUE(many.back().send(fields()));
    ASSERT_NE(many.back().readBlock(), "") << i;
  }
  Client beyond = client();
  beyond.send(fields());
  EXPECT_EQ(beyond.readBlock(), "");
  ASSERT_TRUE(many.front().send(request(true)));
  EXPECT_EQ(many.front().read(1), "\1") << "those that are there are answered";
  many.pop_front();
  // Its thread sees the end, and the next one finds room.
  for (std::string answer; answer.empty();) {
    Client next = client();
    next.send(fields());
    answer = next.readBlock();
  }
}

}  // namespace
}  // namespace mm
