// The live connections of the server.
#include "server_fixture.h"

namespace mm {
namespace {

using namespace std::chrono_literals;
using test::LiveClient, test::residentKb, test::sequenceOf;
using LiveConnectionTest = test::ServerTest;

TEST_F(LiveConnectionTest, LiveConnectionsAreForThisPageAlone) {
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

TEST_F(LiveConnectionTest, AHeartbeatIsHeardHoweverManyPagesAreAsked) {
  options_.requestsASecond = 1.0;
  start();
  LiveClient client(*server_, "", server_->token());
  ASSERT_TRUE(client.open());
  EXPECT_NE(client.read().find("\"client\":1"), std::string::npos);
  EXPECT_EQ(handler_.lastCame, 1u);
  std::string refused;
  while (status(refused) != 429)
    refused = answerTo(request("GET " + withToken("/x"), "Connection: close\r\n"));
  client.write("heartbeat");
  EXPECT_TRUE(handler_.wait([this] { return handler_.lastHeard == 1; }));
}

TEST_F(LiveConnectionTest, AStateThatCannotBeHadIsNotTheLast) {
  start();
  LiveClient client(*server_, "", server_->token());
  ASSERT_TRUE(client.open());
  ASSERT_TRUE(handler_.wait([this] { return handler_.states > 2; }));
  handler_.throws = true;
  ASSERT_TRUE(handler_.wait([this] { return !handler_.throws; }));
  std::uint64_t before = 0;
  EXPECT_TRUE(handler_.wait([&] {
    if (before == 0) before = handler_.states;
    return handler_.states > before + 2;
  }));
}

TEST_F(LiveConnectionTest, WhoSaysNonsenseOrTooMuchIsDropped) {
  start();
  LiveClient nonsense(*server_, "", server_->token()), much(*server_, "", server_->token());
  ASSERT_TRUE(nonsense.open() && much.open());
  nonsense.write("move x");
  EXPECT_TRUE(handler_.wait([this] { return handler_.lastGone == 1; }));
  much.write(std::string(100000, 'x'));
  EXPECT_TRUE(handler_.wait([this] { return handler_.lastGone == 2; }));
  expectAlive();
}

TEST_F(LiveConnectionTest, LiveConnectionsAreBounded) {
  options_.mostSockets = 2;
  start();
  LiveClient a(*server_, "", server_->token()), b(*server_, "", server_->token());
  ASSERT_TRUE(a.open() && b.open());
  EXPECT_EQ(status(upgrade("http://" + host(), server_->token())), 503);
}

#if defined(__SANITIZE_ADDRESS__)
constexpr long kFreedIsKept = 256 * 1024;  // kB, for a while
#else
constexpr long kFreedIsKept = 0;
#endif

TEST_F(LiveConnectionTest, WhoStallsMissesStatesAndHoldsNobodyUp) {
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
  EXPECT_LT(residentKb() - before, 20000 + kFreedIsKept);
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

}  // namespace
}  // namespace mm
