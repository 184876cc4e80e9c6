#include "workbench/page.h"

#include <boost/algorithm/string/replace.hpp>

#include "base/error.h"
#include "base/text.h"
#include "report/web_files.h"
#include "workbench/access.h"

namespace mm {
namespace {

const char* const kScript = "text/javascript; charset=utf-8";
const char* const kStyle = "text/css; charset=utf-8";

// The page's own modules; every other module is a library.
const char* const kModules[] = {"main.js",     "server.js",  "parts.js",   "units.js",   "chart.js",
                                "scatter.js",  "machine.js", "import.js",  "session.js", "compare.js",
                                "diagnose.js", "ledger.js",  "correct.js", "measure.js", "plan.js",
                                "heat.js",     "history.js", "picture.js", "meshes.js"};

struct Library {
  const char *file, *key;
};
const Library kLibraries[] = {{"preact.mjs", "preact"},      {"hooks.mjs", "preact"},
                              {"uPlot.mjs", "uplot"},        {"uPlot.min.css", "uplot"},
                              {"three.module.js", "three"},  {"three.core.js", "three"},
                              {"STLLoader.js", "three"},     {"OBJLoader.js", "three"},
                              {"ColladaParser.js", "three"}, {"ColladaComposer.js", "three"}};

}  // namespace

Page::Page() : html_(webFile("workbench/workbench.html")) {
  for (const char* name : kModules)
    parts_[std::string("/app/") + name] = WebAnswer::text(webFile(std::string("workbench/") + name), kScript);
  parts_["/app/workbench.css"] = WebAnswer::text(webFile("workbench/workbench.css"), kStyle);
  parts_["/app/text_parts.js"] = WebAnswer::text(webFile("text_parts.js"), kScript);
  for (const Library& library : kLibraries) {
    const std::string text = fetchedFile(library.file);
    if (text.empty()) {
      const std::string why = whyNotFetched(library.key);
      throw InputError(
          std::string(library.file) + " of the workbench was not fetched when the package was built" +
          (why.empty() ? "" : " (" + why + ")") + "; build again where the npm registry can be reached");
    }
    parts_[std::string("/lib/") + library.file] =
        WebAnswer::text(text, endsWith(library.file, ".css") ? kStyle : kScript);
  }
}

WebAnswer Page::index(const std::string& token) const {
  std::string html = html_;
  const std::string nonce = newToken();
  boost::replace_all(html, "{{base}}", "/t/" + token);
  boost::replace_all(html, "{{nonce}}", nonce);
  WebAnswer answer = WebAnswer::text(std::move(html), "text/html; charset=utf-8");
  answer.policy =
      "default-src 'none'; script-src 'self' 'nonce-" + nonce +
      "'; style-src 'self' 'unsafe-inline'; connect-src 'self'; img-src 'self' data: blob:; "
      "font-src data:; frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
  return answer;
}

std::optional<WebAnswer> Page::part(const std::string& path) const {
  const auto found = parts_.find(path);
  if (found == parts_.end()) return std::nullopt;
  return found->second;
}

}  // namespace mm
