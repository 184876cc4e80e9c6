#include "workbench/access.h"

#include <gtest/gtest.h>

#include <set>

namespace mm {
namespace {

TEST(Access, TokensAreLongAndNeverTheSame) {
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i) tokens.insert(newToken());
  EXPECT_EQ(tokens.size(), 100u);
  EXPECT_EQ(tokens.begin()->size(), 32u);
  EXPECT_TRUE(sameToken(*tokens.begin(), std::string(*tokens.begin())));
  EXPECT_FALSE(sameToken(*tokens.begin(), *tokens.rbegin()));
  EXPECT_FALSE(sameToken("", ""));
  EXPECT_FALSE(sameToken("abc", "abcd"));
}

TEST(Access, TheHostIsThisServersWithItsPort) {
  const auto hosts = hostsOf("127.0.0.1", 8123, {"bench.lab"});
  for (const char* good : {"127.0.0.1:8123", "localhost:8123", "LOCALHOST:8123", "bench.lab:8123"})
    EXPECT_TRUE(hostAllowed(good, hosts)) << good;
  for (const char* bad : {"", "127.0.0.1", "localhost", "evil.example:8123", "127.0.0.1:8124",
                          "localhost:8123.evil", "127.0.0.1:8123 ", "0.0.0.0:8123", "[::1]:8123"})
    EXPECT_FALSE(hostAllowed(bad, hosts)) << bad;
  EXPECT_TRUE(hostAllowed("[::1]:80", hostsOf("::1", 80, {})));
  EXPECT_TRUE(hostAllowed("localhost", hostsOf("::1", 80, {})));
  EXPECT_FALSE(hostAllowed("localhost:8123", hostsOf("10.0.0.7", 8123, {})));
  // the near end of a tunnel: ssh -L 9000:localhost:8123
  const auto tunnel =
      hostsOf("127.0.0.1", 8123, {"localhost:9000", "near:80", "2001:db8::7", "[2001:db8::8]:9000"});
  for (const char* good :
       {"localhost:9000", "localhost:8123", "near:80", "near", "[2001:db8::7]:8123", "[2001:db8::8]:9000"})
    EXPECT_TRUE(hostAllowed(good, tunnel)) << good;
  EXPECT_FALSE(hostAllowed("localhost:9000:8123", tunnel));
  EXPECT_FALSE(hostAllowed("near:8123", tunnel));
}

TEST(Access, TheOriginIsThisServersWhereABrowserTellsIt) {
  const auto hosts = hostsOf("127.0.0.1", 8123, {});
  EXPECT_TRUE(originAllowed("", hosts));
  EXPECT_TRUE(originAllowed("http://localhost:8123", hosts));
  for (const char* bad :
       {"null", "https://localhost:8123", "http://localhost", "http://evil.example",
        "http://localhost:8123.evil.example", "http://evil.example/http://localhost:8123", "file://"})
    EXPECT_FALSE(originAllowed(bad, hosts)) << bad;
}

TEST(Access, TargetsAreTakenApart) {
  const Target plain = targetOf("/data/session?token=abc&x=1");
  EXPECT_TRUE(plain.wellFormed);
  EXPECT_EQ(plain.path, "/data/session");
  EXPECT_EQ(plain.token, "abc");
  const Target inPath = targetOf("/t/abc/app/main.js");
  EXPECT_TRUE(inPath.wellFormed);
  EXPECT_EQ(inPath.path, "/app/main.js");
  EXPECT_EQ(inPath.token, "abc");
  EXPECT_EQ(queryValue("name=a%20b.bag&token=x", "name"), "a b.bag");
  EXPECT_EQ(queryValue("name=a%2", "name"), "");
  EXPECT_EQ(queryValue("xname=1", "name"), "");
}

TEST(Access, TargetsThatLeadElsewhereAreNotWellFormed) {
  for (const char* bad :
       {"", "data", "http://127.0.0.1/", "/../etc/passwd", "/app/..%2f..%2fetc/passwd", "/%2e%2e/x", "/a\\b",
        "/a%5cb", "/a%00b", "/a%", "/a%2", "/a%zz", "/t/abc", "/a%0d%0aHost:%20evil"})
    EXPECT_FALSE(targetOf(bad).wellFormed) << bad;
  EXPECT_FALSE(targetOf("/" + std::string(1100, 'a')).wellFormed);
}

}  // namespace
}  // namespace mm
