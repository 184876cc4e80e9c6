#include "workbench/server.h"

#include "server_fixture.h"

namespace mm {
namespace {

using namespace std::chrono_literals;
using test::residentKb, test::ServerTest;

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
  const std::string misdirected = answerTo(line + "Host: evil.example\r\n\r\n");
  EXPECT_EQ(status(misdirected), 421);
  EXPECT_NE(misdirected.find("'evil.example'"), std::string::npos);
  EXPECT_NE(misdirected.find("--host"), std::string::npos) << misdirected;
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
  EXPECT_EQ(status(answerTo(request("GET " + std::string(1100, '/')))), 400);
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
  options_.largestImport = 1500;
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
      411);
  EXPECT_EQ(handler_.posts, 0);
  const std::string fits =
      answerTo(request("POST " + withToken("/upload"), "Content-Length: 2000\r\nConnection: close\r\n",
                       std::string(2000, 'x')));
  EXPECT_NE(fits.find("took 2000"), std::string::npos) << fits;
  for (const char* path : {"/action/preview", "/action/import"}) {  // with a URDF and an artifact
    EXPECT_EQ(status(answerTo(request("POST " + withToken(path), "Content-Length: 1501\r\n"))), 413);
    const std::string both = answerTo(request(
        "POST " + withToken(path), "Content-Length: 1500\r\nConnection: close\r\n", std::string(1500, 'x')));
    EXPECT_NE(both.find("took 1500"), std::string::npos) << both;
  }
  expectAlive();
}

TEST_F(ServerTest, OneFileIsSentAtATime) {
  start();
  const auto upload = [&](int size, const std::string& body) {
    return request("POST " + withToken("/upload"),
                   "Content-Length: " + std::to_string(size) + "\r\nConnection: close\r\n", body);
  };
  RawClient first(server_->port());
  ASSERT_TRUE(first.send(upload(10, "abcde")));
  std::string second;
  for (int tries = 0; tries < 10000 && status(second) != 409; ++tries)  // until the first has come so far
    second = answerTo(upload(2, "ab"));
  EXPECT_EQ(status(second), 409);
  EXPECT_NE(second.find("another file is being sent"), std::string::npos) << second;
  ASSERT_TRUE(first.send("fghij"));
  EXPECT_NE(first.readToEnd().find("took 10"), std::string::npos);
  EXPECT_EQ(status(answerTo(upload(2, "ab"))), 200);
  {
    RawClient gone(server_->port());
    ASSERT_TRUE(gone.send(upload(10, "abcde")));
  }
  int last = 0;
  for (int tries = 0; tries < 10000 && last != 200; ++tries) last = status(answerTo(upload(2, "ab")));
  EXPECT_EQ(last, 200) << "who has gone keeps the place";
}

TEST_F(ServerTest, WhoDawdlesLosesTheConnection) {
  options_.headerTime = 1s;
  options_.bodyTime = 1s;
  start();
  RawClient header(server_->port()), body(server_->port()), silent(server_->port());
  EXPECT_TRUE(header.send("GET / HTTP/1.1\r\nHost: "));
  EXPECT_TRUE(body.send(request("POST " + withToken("/action/add"), "Content-Length: 10\r\n", "ab")));
  for (RawClient* client : {&header, &body, &silent}) {
    EXPECT_EQ(client->readToEnd(), "");
    EXPECT_TRUE(client->closed());
  }
  EXPECT_EQ(handler_.posts, 0);
  expectAlive();
}

TEST_F(ServerTest, WhoShowsNoTokenGivesWay) {
  options_.mostWaiting = 4;
  options_.undisturbed = 1ms;
  options_.headerTime = 60s;  // it is not time that ends them
  start();
  std::vector<std::unique_ptr<RawClient>> loris;
  for (int i = 0; i < 40; ++i) {
    loris.push_back(std::make_unique<RawClient>(server_->port()));
    loris.back()->send("GET / HTTP/1.1\r\nX-");
  }
  for (std::size_t i = 0; i < 36; ++i) {
    EXPECT_EQ(loris[i]->readToEnd(), "") << i;
    EXPECT_TRUE(loris[i]->closed()) << i;
  }
  expectAlive();
}

TEST_F(ServerTest, WhoComesInTheMidstOfManyFinishesTheRequest) {
  options_.mostWaiting = 4;
  options_.undisturbed = 60s;
  start();
  RawClient honest(server_->port());
  EXPECT_TRUE(honest.send("GET "));
  std::vector<std::unique_ptr<RawClient>> loris;
  for (int i = 0; i < 40; ++i) {
    loris.push_back(std::make_unique<RawClient>(server_->port()));
    loris.back()->send("GET / HTTP/1.1\r\nX-");
  }
  EXPECT_TRUE(honest.send(request("GET " + withToken("/x"), "Connection: close\r\n").substr(4)));
  EXPECT_EQ(status(honest.readToEnd()), 200);
  // the next is accepted as soon as a place is free, not only when the others have had their time
  loris[3]->send("y: 1\r\nHost: nobody\r\n\r\n");
  EXPECT_EQ(status(loris[3]->readToEnd()), 421);
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

TEST_F(ServerTest, APageAndItsPartsAreNoFlood) {
  start();
  RawClient client(server_->port());
  for (int i = 0; i < 300; ++i) {
    client.forget();
    ASSERT_TRUE(client.send(request("GET " + withToken("/x"))));
    ASSERT_EQ(status(client.readUntil("page of /x")), 200) << i;
  }
}

TEST_F(ServerTest, WhoeverTakesTheSameAnswerSharesIt) {
  handler_.big = WebAnswer::text(std::string(16 << 20, 'x'), "text/plain");
  start();
  std::vector<std::unique_ptr<RawClient>> clients;
  const long before = residentKb();
  for (int i = 0; i < 20; ++i) {
    clients.push_back(std::make_unique<RawClient>(server_->port()));
    ASSERT_TRUE(clients.back()->send(request("GET " + withToken("/big"))));
    ASSERT_EQ(status(clients.back()->readUntil("\r\n\r\n")), 200);  // and then it stalls
  }
  EXPECT_LT(residentKb() - before, 100 << 10) << "KB for 20 clients of 16 MB";
}

TEST_F(ServerTest, AServerOnEveryAddressIsReachedByTheNameThatIsStated) {
  for (const char* address : {"0.0.0.0", "::"}) {
    options_.address = address;
    const std::string refused = test::messageOf<InputError>([&] { start(); });
    EXPECT_NE(refused.find("--host"), std::string::npos) << refused;
  }
  options_.address = "0.0.0.0";
  options_.hosts = {"bench.lab"};
  start();
  const std::string url = server_->url();
  EXPECT_EQ(url.find("http://bench.lab:"), 0u) << url;
  const std::size_t slash = url.find('/', 7);
  ASSERT_NE(slash, std::string::npos);
  const std::string answer =
      answerTo("GET " + url.substr(slash) + " HTTP/1.1\r\nHost: " + url.substr(7, slash - 7) +
               "\r\nConnection: close\r\n\r\n");
  EXPECT_EQ(status(answer), 200) << answer;
  expectAlive();  // the loopback too
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
