#include "fleet/database.h"

#include <sqlite3.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/format.h"

namespace mm {
namespace {

constexpr int kPatience = 60'000;  // ms that a writer waits for another

/// The file as a URI of SQLite that tells that nobody writes it.
std::string asItIs(const std::filesystem::path& file) {
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(file).string()) {
    if (c == '%' || c == '?' || c == '#')
      uri += format("%%%02X", static_cast<unsigned>(static_cast<unsigned char>(c)));
    else
      uri += c;
  }
  return uri + "?immutable=1";
}

/// Whether SQLite could not read for want of the files that it keeps beside a database with a log.
bool wantsFilesBeside(int status) {
  return (status & 0xff) == SQLITE_READONLY || (status & 0xff) == SQLITE_CANTOPEN;
}

}  // namespace

int Database::open(const std::string& name, int flags) {
  sqlite3* handle = nullptr;
  const int status = sqlite3_open_v2(name.c_str(), &handle, flags, nullptr);
  handle_ = {handle, [](sqlite3* h) { sqlite3_close_v2(h); }};
  if (status != SQLITE_OK) return status;
  sqlite3_busy_timeout(handle, kPatience);
  return sqlite3_exec(handle, "PRAGMA schema_version", nullptr, nullptr, nullptr);
}

Database::Database(const std::filesystem::path& file, Use use) : file_(file) {
  std::error_code ignored;
  if (use == Use::kWrite && !std::filesystem::exists(file, ignored))  // the log of a file that was removed
    for (const char* part : {"-wal", "-shm"}) std::filesystem::remove(file.string() + part, ignored);
  const int flags = use == Use::kWrite ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE : SQLITE_OPEN_READONLY;
  int status = open(file.string(), flags);
  if (use == Use::kRead && wantsFilesBeside(status) && std::filesystem::is_regular_file(file, ignored) &&
      !std::filesystem::exists(file.string() + "-wal", ignored))
    status = open(asItIs(file), flags | SQLITE_OPEN_URI);
  if (status != SQLITE_OK) fail("cannot be opened");
  if (use == Use::kWrite) run("PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL;");
}

void Database::fail(const std::string& what) const {
  const std::string cause = handle_ ? sqlite3_errmsg(handle_.get()) : "no memory";
  const int status = handle_ ? sqlite3_errcode(handle_.get()) & 0xff : SQLITE_NOMEM;
  const bool damaged = status == SQLITE_CORRUPT || status == SQLITE_NOTADB;
  throw InputError(file_.string() + ": " + what + ": " + cause +
                   (damaged ? "; remove it and run mm batch with the manifests again: it is rebuilt from the "
                              "finished jobs in the folder 'jobs' beside it, and no job is run twice"
                            : "; check the path, its permissions and the disk"));
}

void Database::run(const std::string& sql) const {
  if (sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
    fail("cannot be used");
}

void Database::together(const std::function<void()>& work) const {
  run("BEGIN IMMEDIATE");
  try {
    work();
  } catch (...) {
    sqlite3_exec(handle_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
  run("COMMIT");
}

Database::Statement::Statement(const Database& database, const std::string& sql) : database_(&database) {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(database.handle_.get(), sql.c_str(), -1, &statement, nullptr) != SQLITE_OK)
    database.fail("cannot be read");
  statement_ = {statement, [](sqlite3_stmt* s) { sqlite3_finalize(s); }};
}

void Database::Statement::fail() const { database_->fail("cannot be read or written"); }

Database::Statement& Database::Statement::bind(int place, const std::string& text) {
  if (sqlite3_bind_text(statement_.get(), place, text.data(), static_cast<int>(text.size()),
                        SQLITE_TRANSIENT) != SQLITE_OK)
    fail();
  return *this;
}

Database::Statement& Database::Statement::bind(int place, double number) {
  const int status = std::isfinite(number) ? sqlite3_bind_double(statement_.get(), place, number)
                                           : sqlite3_bind_null(statement_.get(), place);
  if (status != SQLITE_OK) fail();
  return *this;
}

Database::Statement& Database::Statement::bind(int place, long long number) {
  if (sqlite3_bind_int64(statement_.get(), place, number) != SQLITE_OK) fail();
  return *this;
}

bool Database::Statement::step() {
  const int status = sqlite3_step(statement_.get());
  if (status != SQLITE_ROW && status != SQLITE_DONE) fail();
  return status == SQLITE_ROW;
}

void Database::Statement::reset() {
  sqlite3_reset(statement_.get());
  sqlite3_clear_bindings(statement_.get());
}

std::string Database::Statement::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  return bytes == nullptr ? std::string() : std::string(bytes);
}

double Database::Statement::number(int column) const {
  if (sqlite3_column_type(statement_.get(), column) == SQLITE_NULL)
    return std::numeric_limits<double>::quiet_NaN();
  return sqlite3_column_double(statement_.get(), column);
}

long long Database::Statement::whole(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

}  // namespace mm
