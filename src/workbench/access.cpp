#include "workbench/access.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <optional>

#include "base/checksum.h"
#include "base/error.h"
#include "base/text.h"

namespace mm {
namespace {

constexpr std::size_t kLongestTarget = 1024;

/// Percent signs resolved; empty: one is unfinished, or a control character came out.
std::optional<std::string> resolved(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    char c = text[i];
    if (c == '%') {
      if (i + 2 >= text.size()) return std::nullopt;
      unsigned code = 0;
      const char *const digits = text.data() + i + 1, *const end = digits + 2;
      if (std::from_chars(digits, end, code, 16).ptr != end) return std::nullopt;
      c = static_cast<char>(code);
      i += 2;
    }
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return std::nullopt;
    out += c;
  }
  return out;
}

bool isLoopback(const std::string& address) {
  return address == "127.0.0.1" || address == "::1" || address == "localhost";
}

}  // namespace

std::string newToken() {
  unsigned char bytes[16];
  std::ifstream random("/dev/urandom", std::ios::binary);
  if (!random.read(reinterpret_cast<char*>(bytes), sizeof bytes))
    throw InputError("/dev/urandom cannot be read, so no access token can be made for the workbench");
  return hexDigits(bytes, sizeof bytes);
}

bool sameToken(const std::string& a, const std::string& b) {
  if (a.size() != b.size() || a.empty()) return false;
  unsigned char different = 0;
  for (std::size_t i = 0; i < a.size(); ++i) different |= static_cast<unsigned char>(a[i] ^ b[i]);
  return different == 0;
}

std::string withPort(const std::string& host, unsigned port) {
  const auto colons = std::count(host.begin(), host.end(), ':');
  const std::string end = ":" + std::to_string(port);
  if (colons == 0 || (!host.empty() && host.back() == ']')) return host + end;
  if (colons > 1 && host.front() != '[') return "[" + host + "]" + end;
  return host;
}

std::vector<std::string> hostsOf(const std::string& address, unsigned port,
                                 const std::vector<std::string>& further) {
  std::vector<std::string> names = further;
  names.push_back(address);
  if (isLoopback(address)) {
    names.push_back("localhost");
    names.push_back("127.0.0.1");
  }
  std::vector<std::string> hosts;
  for (const std::string& name : names) {
    hosts.push_back(lower(withPort(name, port)));
    const std::string& host = hosts.back();
    // a browser leaves out the port that everybody knows
    if (endsWith(host, ":80")) hosts.push_back(host.substr(0, host.size() - 3));
  }
  return hosts;
}

bool hostAllowed(const std::string& host, const std::vector<std::string>& hosts) {
  return std::find(hosts.begin(), hosts.end(), lower(host)) != hosts.end();
}

bool originAllowed(const std::string& origin, const std::vector<std::string>& hosts) {
  if (origin.empty()) return true;
  const std::string scheme = "http://";
  const std::string small = lower(origin);
  return startsWith(small, scheme) && hostAllowed(small.substr(scheme.size()), hosts);
}

std::string queryValue(const std::string& query, const std::string& name) {
  std::size_t from = 0;
  while (from < query.size()) {
    const std::size_t end = std::min(query.find('&', from), query.size());
    const std::string one = query.substr(from, end - from);
    from = end + 1;
    if (!startsWith(one, name + "=")) continue;
    return resolved(one.substr(name.size() + 1)).value_or("");
  }
  return {};
}

Target targetOf(const std::string& target) {
  Target out;
  if (target.empty() || target.front() != '/' || target.size() > kLongestTarget) return out;
  const std::size_t mark = target.find('?');
  const std::optional<std::string> path = resolved(target.substr(0, mark));
  if (!path || path->find("..") != std::string::npos || path->find('\\') != std::string::npos) return out;
  out.path = *path;
  if (mark != std::string::npos) out.query = target.substr(mark + 1);
  out.token = queryValue(out.query, "token");
  if (startsWith(out.path, "/t/")) {  // modules name each other by relative paths, which lose the query
    const std::size_t slash = out.path.find('/', 3);
    if (slash == std::string::npos) return out;
    out.token = out.path.substr(3, slash - 3);
    out.path = out.path.substr(slash);
  }
  out.wellFormed = true;
  return out;
}

}  // namespace mm
