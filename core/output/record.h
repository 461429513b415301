// Rows that leave a run: the one manifest of every table a job writes.
//
// A record is a row of doubles whose columns, units and meanings are given once, here. Everything that
// writes, stores, streams or plots a table asks columns(kind); nothing else knows the names. Counts are exact
// (< 2^53). Rows are part of the determinism contract: a resumed run repeats them byte for byte.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace creep {

enum class RecordKind : std::uint8_t {
  kSample = 1,    ///< samples.csv: the state at one cycle
  kStage = 2,     ///< stages.csv: one finished dynamic stage
  kBreakage = 3,  ///< breakages.csv: one failed particle
  kGrading = 4,   ///< gsd.csv: one point of a grading curve
};

inline constexpr RecordKind kRecordKinds[] = {RecordKind::kSample, RecordKind::kStage, RecordKind::kBreakage,
                                              RecordKind::kGrading};

struct Column {
  std::string_view name;     ///< as in the csv header, the SI unit as suffix: "axial_stress_Pa"
  std::string_view unit;     ///< "Pa", "s", "m", "J", "1"
  std::string_view meaning;  ///< one sentence
};

/// The columns of a kind, in order.
std::span<const Column> columns(RecordKind kind);

/// Place of a column by name; CHECK-fails on an unknown name (a bug of ours).
std::size_t column_index(RecordKind kind, std::string_view name);

struct Record {
  RecordKind kind = RecordKind::kSample;
  std::uint64_t sequence = 0;  ///< 0, 1, 2, ... over all kinds of one run, no gap
  std::vector<double> values;  ///< as many as columns(kind)
};

/// Values of the sample column `phase`.
enum class Phase : std::uint8_t { kPacking = 0, kLoading = 1, kDynamicStage = 2, kAgeing = 3 };
std::string_view phase_name(Phase phase);

/// Values of the breakage column `cause`.
enum class BreakageCause : std::uint8_t { kImmediate = 0, kCrackInDynamicStage = 1, kCrackInAgeing = 2 };

/// Little-endian: kind (1 byte), sequence (8), count (4), doubles. decode() checks every length before
/// allocating, and completes samples of earlier versions.
std::string encode(const Record& record);
absl::StatusOr<Record> decode(std::string_view bytes);

/// One csv line without the newline; numbers in the shortest form that reads back exactly.
std::string csv_header(RecordKind kind);
std::string csv_row(const Record& record);

}  // namespace creep
