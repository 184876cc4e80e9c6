#pragma once
#include <filesystem>
#include <string>

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
/// What a page says: plain text, and its data as JSON.
struct PageContents {
  std::string title, sentence, command, json;
};
/// A page of these files: what a user's name contains is never a mark, and nothing in the data ends a script.
/// @throw InputError: a mark is missing or out of order.
std::string filledPage(const ReportFiles& files, const PageContents& contents);

/// Text for an HTML element or attribute.
std::string escapedHtml(const std::string& text);

}  // namespace mm
