// The SQLite database of the daemon: opening it, statements and transactions. Nothing else includes SQLite.
//
// Not safe from several threads at once: whoever owns a Database has a mutex. Errors of the storage are
// Unavailable with the reason STORAGE_FAILED (refusal.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/rules/job.h"

struct sqlite3;
struct sqlite3_stmt;

namespace creepd {

class Database {
 public:
  /// Opens or makes the file, checks it and brings its schema up to date. Errors: Unavailable (storage),
  /// DataLoss (damaged), FailedPrecondition (made by a newer version).
  static absl::StatusOr<std::unique_ptr<Database>> open(const std::filesystem::path& path);
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;
  ~Database();

  absl::Status execute(const std::string& sql);
  /// The first number of the first row; 0 if there is none.
  absl::StatusOr<std::int64_t> number(const std::string& sql);
  std::int64_t rows_changed() const;
  std::int64_t last_row() const;
  absl::Status failed(const char* what) const;

  /// Shortens the file by at most `most` of its free pages, but keeps `spare` of them for what comes next.
  /// Returns how many could still be given back.
  absl::StatusOr<std::int64_t> give_back(std::int64_t spare, std::int64_t most);

 private:
  friend class Statement;
  explicit Database(sqlite3* connection) : connection_(connection) {}
  absl::Status set_up();
  absl::Status migrate(std::int64_t version);
  absl::Status let_it_shrink();

  sqlite3* connection_;
  /// Prepared and not in use, by their text: preparing one costs as much as running it.
  std::unordered_map<std::string, sqlite3_stmt*> prepared_;
};

/// One statement of a database that outlives it; values are bound in order. The first error is kept and told
/// by the end of use.
class Statement {
 public:
  Statement(Database& database, std::string sql);
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;
  ~Statement();

  Statement& bind(std::int64_t value);
  Statement& bind(std::uint64_t value) { return bind(static_cast<std::int64_t>(value)); }
  Statement& bind(std::int32_t value) { return bind(std::int64_t{value}); }
  Statement& bind(JobState value) { return bind(static_cast<std::int64_t>(value)); }
  Statement& bind(StateReason value) { return bind(static_cast<std::int64_t>(value)); }
  Statement& bind(const std::string& value);
  Statement& bind(const std::optional<Moment>& value);
  Statement& bind_blob(const std::string& value);

  /// Once more, with other values.
  Statement& again();
  /// True while there is a row.
  bool step();
  absl::Status run();
  absl::Status status() const;

  // The columns of the row, in order.
  std::int64_t integer();
  std::int32_t small() { return static_cast<std::int32_t>(integer()); }
  std::uint64_t natural() { return static_cast<std::uint64_t>(integer()); }
  std::string text();
  std::optional<Moment> moment();

 private:
  Database& database_;
  std::string sql_;
  sqlite3_stmt* statement_ = nullptr;
  int code_ = 0;
  int bound_ = 0;
  int column_ = 0;
};

/// Rolled back unless committed.
class Transaction {
 public:
  explicit Transaction(Database& database)
      : database_(database), begun_(database.execute("BEGIN IMMEDIATE")), open_(begun_.ok()) {}
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  ~Transaction() {
    if (open_) database_.execute("ROLLBACK").IgnoreError();
  }
  const absl::Status& status() const { return begun_; }
  absl::Status commit() {
    absl::Status committed = database_.execute("COMMIT");
    if (committed.ok()) open_ = false;
    return committed;
  }

 private:
  Database& database_;
  absl::Status begun_;
  bool open_;
};

}  // namespace creepd
