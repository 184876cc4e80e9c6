// What a client of the workbench asks for: target, query, host and origin.
#include <algorithm>

#include "fuzz_support.h"
#include "workbench/access.h"

namespace {

bool printable(const std::string& text) {
  return std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<std::string> hosts =
      mm::hostsOf("127.0.0.1", 8123, {"bench.lab", "near:9000", "2001:db8::7"});
  const std::string text = mm::fuzz::textOf(data, size);
  const mm::Target target = mm::targetOf(text);
  if (target.wellFormed) {
    if (target.path.empty() || target.path.front() != '/') mm::fuzz::broken("a path begins with a slash");
    if (target.path.find("..") != std::string::npos || target.path.find('\\') != std::string::npos)
      mm::fuzz::broken("a path leads nowhere else");
    if (!printable(target.path) || !printable(target.token))
      mm::fuzz::broken("no control character in path or token");
    if (text.size() > 1024) mm::fuzz::broken("a target is short");
    if (target.token.find('/') != std::string::npos && target.query.empty())
      mm::fuzz::broken("a token in the path ends at a slash");
  }
  for (const char* name : {"token", "name", "who"})
    if (!printable(mm::queryValue(text, name))) mm::fuzz::broken("no control character in a value");
  // a text of the fuzzer's is ours only if it is one of ours, whatever the size of its letters
  const bool ours = mm::hostAllowed(text, hosts);
  if (ours && (text.size() > 40 || text.find('/') != std::string::npos))
    mm::fuzz::broken("a host is one of those that were named");
  if (mm::originAllowed("http://" + text, hosts) != ours)
    mm::fuzz::broken("an origin is a host behind http://");
  if (mm::originAllowed("https://" + text, hosts)) mm::fuzz::broken("an origin is not encrypted");
  mm::withPort(text, 80);
  if (mm::sameToken(text, "0123456789abcdef") != (text == "0123456789abcdef"))
    mm::fuzz::broken("a token is the same or another");
  return 0;
}
