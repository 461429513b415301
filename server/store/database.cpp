#include "server/store/database.h"

#include <sqlite3.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/rules/refusal.h"
#include "server/store/schema.h"

namespace creepd {
namespace {

constexpr auto kSchemaVersion = static_cast<std::int64_t>(std::size(kSchema));
constexpr std::size_t kMostPrepared = 64;  // a filter of a list has many forms

}  // namespace

absl::StatusOr<std::unique_ptr<Database>> Database::open(const std::filesystem::path& path) {
  constexpr int kFlags =
      SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_FULLMUTEX | SQLITE_OPEN_EXRESCODE;
  sqlite3* connection = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &connection, kFlags, nullptr);
  std::unique_ptr<Database> database(new Database(connection));
  if (code != SQLITE_OK) return database->failed("open");
  if (auto status = database->set_up(); !status.ok()) return status;
  return database;
}

Database::~Database() {
  for (const auto& [sql, statement] : prepared_) sqlite3_finalize(statement);
  if (connection_ == nullptr) return;
  sqlite3_wal_checkpoint_v2(connection_, nullptr, SQLITE_CHECKPOINT_TRUNCATE, nullptr, nullptr);
  sqlite3_close(connection_);
}

absl::Status Database::failed(const char* what) const {
  const std::string message = absl::StrCat("database: ", what, ": ", sqlite3_errmsg(connection_));
  return refuse(absl::StatusCode::kUnavailable, message, {"STORAGE_FAILED", {}, {}, 5});
}

absl::Status Database::execute(const std::string& sql) {
  return sqlite3_exec(connection_, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK ? absl::OkStatus()
                                                                                        : failed(sql.c_str());
}

absl::StatusOr<std::int64_t> Database::number(const std::string& sql) {
  Statement statement(*this, sql);
  const bool found = statement.step();
  if (auto status = statement.status(); !status.ok()) return status;
  return found ? statement.integer() : 0;
}

std::int64_t Database::rows_changed() const { return sqlite3_changes(connection_); }
std::int64_t Database::last_row() const { return sqlite3_last_insert_rowid(connection_); }

absl::Status Database::set_up() {
  // The first one counts only before there is a first page.
  for (const char* pragma : {"PRAGMA auto_vacuum=INCREMENTAL", "PRAGMA journal_mode=WAL",
                             "PRAGMA synchronous=FULL", "PRAGMA foreign_keys=ON", "PRAGMA busy_timeout=5000",
                             "PRAGMA journal_size_limit=16777216", "PRAGMA trusted_schema=OFF"}) {
    if (auto status = execute(pragma); !status.ok()) return status;
  }
  std::string verdict = "no answer";
  {
    Statement check(*this, "PRAGMA quick_check(1)");
    if (check.step()) verdict = check.text();
  }
  if (verdict != "ok") return absl::DataLossError(absl::StrCat("the database is damaged: ", verdict));
  const auto version = number("PRAGMA user_version");
  if (!version.ok()) return version.status();
  if (*version > kSchemaVersion) {
    return absl::FailedPreconditionError(absl::StrCat("the database was made by a newer creepd (schema ",
                                                      *version, ", this one knows ", kSchemaVersion, ")"));
  }
  for (std::int64_t next = *version; next < kSchemaVersion; ++next) {
    if (auto status = migrate(next); !status.ok()) return status;
  }
  return let_it_shrink();
}

absl::Status Database::migrate(std::int64_t version) {
  Transaction transaction(*this);
  if (auto status = transaction.status(); !status.ok()) return status;
  if (auto status = execute(kSchema[version]); !status.ok()) return status;
  if (auto status = execute(absl::StrCat("PRAGMA user_version=", version + 1)); !status.ok()) return status;
  return transaction.commit();
}

absl::Status Database::let_it_shrink() {
  constexpr std::int64_t kIncremental = 2;
  const auto mode = number("PRAGMA auto_vacuum");
  if (!mode.ok()) return mode.status();
  if (*mode == kIncremental) return absl::OkStatus();
  // Made by an earlier program: written anew once, where there is room for a second copy; if not, the file
  // serves as it is until the next start.
  execute("VACUUM").IgnoreError();
  return absl::OkStatus();
}

absl::StatusOr<std::int64_t> Database::give_back(std::int64_t spare, std::int64_t most) {
  const auto free = number("PRAGMA freelist_count");
  if (!free.ok() || *free <= spare) return free.ok() ? absl::StatusOr<std::int64_t>(0) : free.status();
  if (auto status = execute(absl::StrCat("PRAGMA incremental_vacuum(", std::min(most, *free - spare), ")"));
      !status.ok()) {
    return status;
  }
  return *free - spare - std::min(most, *free - spare);
}

Statement::Statement(Database& database, std::string sql) : database_(database), sql_(std::move(sql)) {
  if (auto prepared = database_.prepared_.extract(sql_)) {
    statement_ = prepared.mapped();
    return;
  }
  code_ = sqlite3_prepare_v3(database_.connection_, sql_.c_str(), static_cast<int>(sql_.size() + 1),
                             SQLITE_PREPARE_PERSISTENT, &statement_, nullptr);
}

Statement::~Statement() {
  if (statement_ == nullptr) return;
  // The reset ends a read that was not carried to its last row.
  const bool kept = sqlite3_reset(statement_) == SQLITE_OK &&
                    sqlite3_clear_bindings(statement_) == SQLITE_OK &&
                    database_.prepared_.size() < kMostPrepared &&
                    database_.prepared_.emplace(std::move(sql_), statement_).second;
  if (!kept) sqlite3_finalize(statement_);
}

Statement& Statement::bind(std::int64_t value) {
  if (code_ == SQLITE_OK) code_ = sqlite3_bind_int64(statement_, ++bound_, value);
  return *this;
}

Statement& Statement::bind(const std::string& value) {
  if (code_ == SQLITE_OK) {
    code_ = sqlite3_bind_text(statement_, ++bound_, value.data(), static_cast<int>(value.size()),
                              SQLITE_TRANSIENT);
  }
  return *this;
}

Statement& Statement::bind_blob(const std::string& value) {
  if (code_ == SQLITE_OK) {
    code_ = sqlite3_bind_blob(statement_, ++bound_, value.data(), static_cast<int>(value.size()),
                              SQLITE_TRANSIENT);
  }
  return *this;
}

Statement& Statement::bind(const std::optional<Moment>& value) {
  if (value) return bind(*value);
  if (code_ == SQLITE_OK) code_ = sqlite3_bind_null(statement_, ++bound_);
  return *this;
}

Statement& Statement::again() {
  if (code_ == SQLITE_DONE || code_ == SQLITE_ROW) code_ = sqlite3_reset(statement_);
  bound_ = 0;
  return *this;
}

bool Statement::step() {
  if (code_ != SQLITE_OK && code_ != SQLITE_ROW) return false;
  column_ = 0;
  code_ = sqlite3_step(statement_);
  return code_ == SQLITE_ROW;
}

absl::Status Statement::run() {
  while (step()) {
  }
  return status();
}

absl::Status Statement::status() const {
  return code_ == SQLITE_DONE || code_ == SQLITE_ROW ? absl::OkStatus() : database_.failed("statement");
}

std::int64_t Statement::integer() { return sqlite3_column_int64(statement_, column_++); }

std::string Statement::text() {
  const int column = column_++;
  const void* bytes = sqlite3_column_blob(statement_, column);
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
  return bytes == nullptr ? std::string() : std::string(static_cast<const char*>(bytes), size);
}

std::optional<Moment> Statement::moment() {
  if (sqlite3_column_type(statement_, column_) == SQLITE_NULL) {
    ++column_;
    return std::nullopt;
  }
  return integer();
}

}  // namespace creepd
