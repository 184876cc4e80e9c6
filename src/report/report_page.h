#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "report/report_contents.h"

namespace mm {

/// The files that a page is made of, read before the work so that a missing one is said at once.
struct ReportFiles {
  std::string html, css, js, plotly;
};

/// @param plotly path of plotly.min.js; empty: the one fetched when the package was built. @throw InputError:
/// a file is missing; the message says how to get it.
ReportFiles loadReportFiles(const std::filesystem::path& plotly = {});

/// The whole page: one file without links to others. Names from users' files are data, never markup.
std::string reportPage(const ReportContents& report, const ReportFiles& files);
/// A page with something in the place of each mark. @param marks in the order of the page: what a user's name
/// contains is never a mark. @throw InputError: a mark is missing or out of order.
std::string filledPage(const std::string& html,
                       const std::vector<std::pair<std::string, std::string>>& marks);

/// Text for an HTML element or attribute.
std::string escapedHtml(const std::string& text);
/// JSON or a script for an element `script`: nothing in it can end the element.
std::string escapedForScript(const std::string& json);

}  // namespace mm
