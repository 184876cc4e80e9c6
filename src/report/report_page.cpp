#include "report/report_page.h"

#include <boost/algorithm/string/replace.hpp>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "calibration_file/atomic_file.h"
#include "report/text_parts.h"
#include "report/web_files.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

std::string plotlyText(const fs::path& given) {
  const std::string fetch =
      std::string("npm pack ") + MM_PLOTLY_PACKAGE + "; tar xzf plotly.js-dist-min-*.tgz";
  const fs::path path = given.empty() ? fs::path("plotly.min.js") : given;
  if (!given.empty() && !fs::is_regular_file(given))
    throw InputError("--plotly: no such file as " + given.string() + "; fetch it (" + fetch +
                     ") and give package/plotly.min.js");
  const std::string text = given.empty() ? fetchedFile(path.string()) : readFile(given);
  if (given.empty() && text.empty())
    throw InputError(
        std::string("plotly.min.js is not in ") + MM_BUILD_WEB +
        ": npm was not available when the package was built; install npm and build again, or fetch it (" +
        fetch + ") and give --plotly package/plotly.min.js");
  if (text.size() < 100000 || text.find("plotly") == std::string::npos)
    throw InputError(path.string() + ": not a complete plotly.min.js (" + std::to_string(text.size()) +
                     " bytes); fetch it again (" + fetch + ")");
  return text;
}

}  // namespace

std::string escapedHtml(const std::string& text) {
  std::string out = text;
  for (const auto& [plain, escaped] :
       {std::pair{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}, {"'", "&#39;"}})
    boost::replace_all(out, plain, escaped);
  return out;
}

ReportFiles loadReportFiles(const fs::path& plotly) {
  ReportFiles files{webFile("report.html"), webFile("page.css") + webFile("report.css"),
                    webFile("text_parts.js") + webFile("report_parts.js") + webFile("report_plots.js") +
                        webFile("report_space.js") + webFile("report.js"),
                    plotlyText(plotly)};
  // inside the library's strings and comments only: nothing may end its element
  boost::replace_all(files.plotly, "</script", "<\\/script");
  return files;
}

std::string filledPage(const ReportFiles& files, const PageContents& contents) {
  std::string data = contents.json;
  boost::replace_all(data, "<", "\\u003c");
  const std::pair<const char*, std::string> marks[] = {{"{{title}}", escapedHtml(contents.title)},
                                                       {"{{style}}", files.css},
                                                       {"{{sentence}}", escapedHtml(contents.sentence)},
                                                       {"{{command}}", escapedHtml(contents.command)},
                                                       {"{{data}}", data},
                                                       {"{{plotly}}", files.plotly},
                                                       {"{{script}}", files.js}};
  std::string page;
  std::size_t from = 0;
  for (const auto& [mark, text] : marks) {
    const std::size_t at = files.html.find(mark, from);
    if (at == std::string::npos)
      throw InputError(std::string("report.html: the mark ") + mark +
                       " is missing or out of order; install the package again");
    page.append(files.html, from, at - from).append(text);
    from = at + std::string_view(mark).size();
  }
  return page.append(files.html, from, std::string::npos);
}

std::string reportPage(const ReportContents& report, const ReportFiles& files) {
  const std::string command = report.calibrated()
                                  ? addCommand(report.diagnosis, report.sessionPath, report.calibrationPath)
                                  : std::string();
  return filledPage(files, {reportTitle(report), reportSentence(report), command, reportJson(report)});
}

}  // namespace mm
