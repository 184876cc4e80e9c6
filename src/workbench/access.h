#pragma once
#include <string>
#include <vector>

namespace mm {

// Who may talk to the workbench. A page of another site that the user has open can reach the loopback too, by
// a form, a script or a name that it lets lead to 127.0.0.1 (DNS rebinding): so every request shows the
// token, and names this server as its host and, where a browser tells it, as its origin.

/// 32 hexadecimal digits from the system's generator. @throw InputError when that cannot be read.
std::string newToken();

/// Whether two texts are the same; takes equally long wherever they differ.
bool sameToken(const std::string& a, const std::string& b);

/// A name or address of a host with the port, as a browser writes it: "bench:8123", "[::1]:8123". What has a
/// port already keeps it.
std::string withPort(const std::string& host, unsigned port);

/// Names under which a server on `address` and `port` is reached: the address itself, for the loopback also
/// localhost, and those of `further`; each with its port, in small letters. One of `further` may have a port
/// of its own: that of the near end of a tunnel.
std::vector<std::string> hostsOf(const std::string& address, unsigned port,
                                 const std::vector<std::string>& further);

/// @param host the header `Host`. @param hosts as hostsOf().
bool hostAllowed(const std::string& host, const std::vector<std::string>& hosts);
/// @param origin the header `Origin`; empty: none was sent, as by a program that is no browser.
bool originAllowed(const std::string& origin, const std::vector<std::string>& hosts);

/// What a client asked for: path and token, wherever it stands.
struct Target {
  std::string path;   // "/data/session": without the token, the query and percent signs resolved
  std::string token;  // of `?token=…`, or of "/t/<token>/…"; empty: none
  std::string query;  // what stands behind the question mark, as it came
  bool wellFormed = false;
};
/// A target with `..`, a backslash, a control character, an unfinished percent sign or more than 1024 letters
/// is not well formed.
Target targetOf(const std::string& target);

/// The value of `name` in "a=1&name=value", percent signs resolved; empty: not there, or not well formed.
std::string queryValue(const std::string& query, const std::string& name);

}  // namespace mm
