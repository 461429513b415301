#include "server/api/read_curves.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/analysis/thinning.h"
#include "core/output/record.h"
#include "server/rules/refusal.h"

namespace creepd {
namespace {

namespace v1 = creep::v1;
using creep::RecordKind;

constexpr int kMostColumns = 64;
constexpr int kMostPerDecade = 1000;
constexpr std::size_t kMostBytes = 3'000'000;  // a client takes 4 MiB unless it is told otherwise
constexpr std::size_t kSequence = SIZE_MAX;    // the column that is no value of the record

RecordKind kind_of(v1::Table table) { return static_cast<RecordKind>(static_cast<int>(table) + 1); }

/// What of a row is wanted: places in Record::values, or kSequence.
struct Wanted {
  RecordKind kind = RecordKind::kSample;
  std::vector<std::size_t> columns;
  std::size_t by = kSequence;  ///< makes the buckets
  std::vector<bool> phases;    ///< by number; empty: all
  std::optional<creep::Buckets> buckets;
};

std::optional<std::size_t> place_of(RecordKind kind, const std::string& name) {
  if (name == "sequence") return kSequence;
  const auto all = creep::columns(kind);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].name == name) return i;
  }
  return std::nullopt;
}

void want_buckets(const v1::Thinning& thinning, Wanted& wanted, std::vector<Violation>& violations) {
  const std::string by = thinning.by().empty() ? "creep_time_s" : thinning.by();
  const auto place = place_of(wanted.kind, by);
  if (!place) violations.push_back({"thinning.by", absl::StrCat("the table has no column \"", by, "\"")});
  if (!(thinning.width() >= 0.0) || std::isinf(thinning.width()))
    violations.push_back({"thinning.width", "must be 0 or a positive number"});
  if (thinning.per_decade() < 0 || thinning.per_decade() > kMostPerDecade)
    violations.push_back({"thinning.per_decade", absl::StrCat("must be from 0 to ", kMostPerDecade)});
  wanted.by = place.value_or(kSequence);
  wanted.buckets.emplace();
  wanted.buckets->width = thinning.width();
  if (thinning.per_decade() > 0) wanted.buckets->per_decade = thinning.per_decade();
}

absl::StatusOr<Wanted> wanted_by(const v1::ReadCurvesRequest& request, v1::Curves& response) {
  std::vector<Violation> violations;
  Wanted wanted;
  if (!v1::Table_IsValid(request.table())) return bad_request({{"table", "is no table"}});
  wanted.kind = kind_of(request.table());
  std::vector<std::string> names(request.columns().begin(), request.columns().end());
  if (names.size() > kMostColumns)
    return bad_request({{"columns", absl::StrCat(names.size(), " given; at most ", kMostColumns)}});
  if (names.empty()) {
    for (const creep::Column& column : creep::columns(wanted.kind)) names.emplace_back(column.name);
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto place = place_of(wanted.kind, names[i]);
    if (!place) {
      violations.push_back(
          {absl::StrCat("columns[", i, "]"),
           absl::StrCat("the table has no column \"", names[i], "\"; GetServerInfo lists those it has")});
      continue;
    }
    wanted.columns.push_back(*place);
    v1::Curve& curve = *response.add_columns();
    curve.set_name(names[i]);
    curve.set_unit(*place == kSequence ? "1" : std::string(creep::columns(wanted.kind)[*place].unit));
  }
  if (!request.phases().empty() && wanted.kind != RecordKind::kSample)
    violations.push_back({"phases", "are of samples only"});
  for (const int phase : request.phases()) {
    if (!v1::Phase_IsValid(phase)) {
      violations.push_back({"phases", absl::StrCat(phase, " is no phase")});
      continue;
    }
    wanted.phases.resize(std::max<std::size_t>(wanted.phases.size(), static_cast<std::size_t>(phase) + 1));
    wanted.phases[static_cast<std::size_t>(phase)] = true;
  }
  if (request.has_thinning()) want_buckets(request.thinning(), wanted, violations);
  if (!violations.empty()) return bad_request(std::move(violations));
  return wanted;
}

/// Columns from rows, up to what a message holds.
class CurveWriter {
 public:
  CurveWriter(const Wanted& wanted, v1::Curves& curves)
      : wanted_(wanted),
        curves_(curves),
        most_(kMostBytes / (sizeof(double) * wanted.columns.size() + 4)),
        values_(wanted.columns.size()) {
    if (wanted.buckets) thinner_.emplace(*wanted.buckets, wanted.columns.size());
  }

  /// False once the message is full; then this row is not in it.
  bool take(std::uint64_t index, const creep::Record& record) {
    static const std::size_t kPhase = creep::column_index(RecordKind::kSample, "phase");
    if (!wanted_.phases.empty()) {
      const double phase = record.values[kPhase];
      const bool known = phase >= 0.0 && phase < static_cast<double>(wanted_.phases.size());
      if (!known || !wanted_.phases[static_cast<std::size_t>(phase)]) return true;
    }
    if (written_ >= most_) {
      full_ = true;
      next_ = thinner_ ? open_from_ : index;
      return false;
    }
    for (std::size_t i = 0; i < values_.size(); ++i) values_[i] = value_of(record, wanted_.columns[i]);
    if (!thinner_) {
      write(index, values_);
      return true;
    }
    thinner_->add(index, value_of(record, wanted_.by), values_);
    written_ = thinner_->rows().size();
    open_from_ = thinner_->open_bucket();
    return true;
  }

  /// `end`: of the rows that were looked at. What the next call begins with.
  std::uint64_t finish(std::uint64_t first, std::uint64_t end) {
    if (!thinner_) return full_ ? next_ : std::max(first, end);
    // A bucket that may still grow is told as it is, and begins the next call.
    if (!full_) thinner_->end_bucket();
    for (const creep::ThinnedRow& row : thinner_->rows()) write(row.index, row.values);
    if (full_) return next_;
    return curves_.index().empty() ? std::max(first, end) : open_from_;
  }
  bool full() const { return full_; }

 private:
  static double value_of(const creep::Record& record, std::size_t column) {
    return column == kSequence ? static_cast<double>(record.sequence) : record.values[column];
  }

  void write(std::uint64_t index, const std::vector<double>& values) {
    curves_.add_index(index);
    for (std::size_t i = 0; i < values.size(); ++i)
      curves_.mutable_columns(static_cast<int>(i))->add_values(values[i]);
    if (!thinner_) ++written_;
  }

  const Wanted& wanted_;
  v1::Curves& curves_;
  const std::size_t most_;  ///< rows
  std::size_t written_ = 0;
  std::optional<creep::Thinner> thinner_;
  std::vector<double> values_;
  std::uint64_t open_from_ = 0;
  std::uint64_t next_ = 0;
  bool full_ = false;
};

}  // namespace

absl::Status read_curves(SampleIndex& index, std::uint64_t samples, const v1::ReadCurvesRequest& request,
                         v1::Curves& response) {
  const auto damaged = [](const absl::Status& status) {
    return refuse(absl::StatusCode::kDataLoss, std::string(status.message()), {"LOG_DAMAGED", {}, {}, {}});
  };
  const auto wanted = wanted_by(request, response);
  if (!wanted.ok()) return wanted.status();
  const auto there = index.poll();
  const std::uint64_t end = index.rows_at(wanted->kind, samples);
  if (!there.ok() && end <= request.first_index()) return damaged(there.status());
  CurveWriter writer(*wanted, response);
  const absl::Status visited =
      index.visit(wanted->kind, request.first_index(), end,
                  [&](std::uint64_t row, const creep::Record& record) { return writer.take(row, record); });
  if (!visited.ok()) return damaged(visited);
  response.set_next_index(writer.finish(request.first_index(), end));
  response.set_at_end(!writer.full());
  response.set_rows(end);
  return absl::OkStatus();
}

void list_columns(v1::ServerInfo& info) {
  for (int table = v1::Table_MIN; table <= v1::Table_MAX; ++table) {
    for (const creep::Column& column : creep::columns(kind_of(static_cast<v1::Table>(table)))) {
      v1::ColumnInfo& told = *info.add_columns();
      told.set_table(static_cast<v1::Table>(table));
      told.set_name(std::string(column.name));
      told.set_unit(std::string(column.unit));
      told.set_meaning(std::string(column.meaning));
    }
  }
}

}  // namespace creepd
