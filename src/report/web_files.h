#pragma once
#include <string>

namespace mm {

// The files that pages are made of: those of this package, beside the sources or in the package's share, and
// the libraries that were fetched from the npm registry when the package was built.

/// A file of the package, e.g. "report.html". @throw InputError: it is missing; install again.
std::string webFile(const std::string& name);
/// A library that was fetched; empty: it is not there.
std::string fetchedFile(const std::string& name);
/// Why the library `key` ("plotly", "preact", "uplot", "three") was not fetched, as the build said; empty: it
/// did not say.
std::string whyNotFetched(const std::string& key);

}  // namespace mm
