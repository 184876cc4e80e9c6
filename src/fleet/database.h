#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

namespace mm {

/// A SQLite database in WAL mode: one writes, any number read meanwhile, and whoever is killed leaves it
/// whole. All members throw InputError naming the file and what SQLite says.
class Database {
 public:
  enum class Use { kRead, kWrite };
  /// @param use kRead: the file must exist, and nothing is written. One of a folder in which SQLite may not
  /// keep the files of its log beside it is read as it is where it has no log.
  Database(const std::filesystem::path& file, Use use);

  /// One statement with its values; prepared once a run.
  class Statement {
   public:
    Statement& bind(int place, const std::string& text);  ///< places count from 1
    Statement& bind(int place, double number);            ///< NaN is stored as NULL
    Statement& bind(int place, long long number);
    bool step();                         ///< @return whether there is a row
    void reset();                        ///< ready to be bound and stepped anew
    std::string text(int column) const;  ///< columns count from 0; empty for NULL
    double number(int column) const;     ///< NaN for NULL
    long long whole(int column) const;   ///< 0 for NULL

   private:
    friend class Database;
    Statement(const Database& database, const std::string& sql);
    [[noreturn]] void fail() const;
    const Database* database_;
    std::shared_ptr<sqlite3_stmt> statement_;
  };
  Statement prepare(const std::string& sql) const { return {*this, sql}; }  ///< one statement
  void run(const std::string& sql) const;                                   ///< any number of statements
  /// All of it or nothing.
  void together(const std::function<void()>& work) const;

 private:
  int open(const std::string& name, int flags);
  [[noreturn]] void fail(const std::string& what) const;
  std::filesystem::path file_;
  std::shared_ptr<sqlite3> handle_;
};

}  // namespace mm
