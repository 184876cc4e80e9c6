#include "report/report_page.h"

#include <vector>

#include "base/error.h"
#include "calibration_file/atomic_file.h"
#include "report/text_parts.h"
#include "report/web_files.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

void replaceAll(std::string& text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
}

std::string plotlyText(const fs::path& given) {
  const std::string fetch =
      std::string("npm pack ") + MM_PLOTLY_PACKAGE + "; tar xzf plotly.js-dist-min-*.tgz";
  std::string text = given.empty() ? fetchedFile("plotly.min.js") : std::string();
  const fs::path path = given.empty() ? fs::path("plotly.min.js") : given;
  if (given.empty() && text.empty())
    throw InputError(
        std::string("plotly.min.js is not in ") + MM_BUILD_WEB +
        ": npm was not available when the package was built; install npm and build again, or fetch it (" +
        fetch + ") and give --plotly package/plotly.min.js");
  if (!given.empty() && !fs::is_regular_file(path))
    throw InputError("--plotly: no such file as " + path.string() + "; fetch it (" + fetch +
                     ") and give package/plotly.min.js");
  if (!given.empty()) text = readFile(path);
  if (text.size() < 100000 || text.find("plotly") == std::string::npos)
    throw InputError(path.string() + ": not a complete plotly.min.js (" + std::to_string(text.size()) +
                     " bytes); fetch it again (" + fetch + ")");
  return text;
}

}  // namespace

std::string escapedHtml(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string escapedForScript(const std::string& json) {
  std::string out = json;
  replaceAll(out, "<", "\\u003c");
  return out;
}

ReportFiles loadReportFiles(const fs::path& plotly) {
  ReportFiles files{webFile("report.html"), webFile("report.css"),
                    webFile("text_parts.js") + webFile("report_parts.js") + webFile("report_plots.js") +
                        webFile("report_space.js") + webFile("report.js"),
                    plotlyText(plotly)};
  // inside the library's strings and comments only: nothing may end its element
  replaceAll(files.plotly, "</script", "<\\/script");
  return files;
}

std::string filledPage(const std::string& html,
                       const std::vector<std::pair<std::string, std::string>>& marks) {
  std::string page;
  std::size_t from = 0;
  for (const auto& [mark, text] : marks) {
    const std::size_t at = html.find(mark, from);
    if (at == std::string::npos)
      throw InputError("report.html: the mark " + mark +
                       " is missing or out of order; install the package again");
    page.append(html, from, at - from).append(text);
    from = at + mark.size();
  }
  return page.append(html, from, std::string::npos);
}

std::string reportPage(const ReportContents& report, const ReportFiles& files) {
  const std::vector<std::pair<std::string, std::string>> marks = {
      {"{{title}}", escapedHtml(reportTitle(report))},
      {"{{style}}", files.css},
      {"{{sentence}}", escapedHtml(reportSentence(report))},
      {"{{command}}", escapedHtml(report.calibrated() ? addCommand(report.diagnosis, report.sessionPath,
                                                                   report.calibrationPath)
                                                      : std::string())},
      {"{{data}}", escapedForScript(reportJson(report))},
      {"{{plotly}}", files.plotly},
      {"{{script}}", files.js}};
  return filledPage(files.html, marks);
}

}  // namespace mm
