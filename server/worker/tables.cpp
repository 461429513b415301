#include "server/worker/tables.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "absl/strings/str_cat.h"
#include "core/folder/durable_file.h"

namespace creepd {

std::string table_name(creep::RecordKind kind) {
  switch (kind) {
    case creep::RecordKind::kSample:
      return "samples.csv";
    case creep::RecordKind::kStage:
      return "stages.csv";
    case creep::RecordKind::kBreakage:
      return "breakages.csv";
    case creep::RecordKind::kGrading:
      return "gsd.csv";
  }
  return "";
}

absl::StatusOr<Tables> Tables::render(const std::filesystem::path& directory, const creep::SampleLog& log,
                                      const StageTimings& timings) {
  Tables tables;
  tables.directory_ = directory;
  Texts texts;
  for (const creep::RecordKind kind : creep::kRecordKinds) {
    texts[kind] =
        creep::csv_header(kind) + (kind == creep::RecordKind::kStage ? ",rebuilds,wall_seconds\n" : "\n");
  }
  for (std::uint64_t sequence = 0; sequence < log.size(); ++sequence) {
    const auto record = log.read(sequence);
    if (!record.ok()) return record.status();
    tables.render_row(*record, timings, texts);
  }
  for (const auto& [kind, text] : texts) {
    const auto path = directory / table_name(kind);
    if (auto written = creep::replace_file(path, text); !written.ok()) return written;
    auto file = creep::open_file(path, O_WRONLY | O_APPEND);
    if (!file.ok()) return file.status();
    tables.files_[kind] = *std::move(file);
  }
  return tables;
}

absl::Status Tables::append(std::span<const creep::Record> records, const StageTimings& timings) {
  Texts texts;
  for (const creep::Record& record : records) render_row(record, timings, texts);
  for (const auto& [kind, text] : texts) {
    if (auto written = creep::write_all(files_.at(kind).get(), text, directory_ / table_name(kind));
        !written.ok()) {
      return written;
    }
  }
  return absl::OkStatus();
}

absl::Status Tables::sync() const {
  for (const auto& [kind, file] : files_) {
    if (::fsync(file.get()) != 0) {
      return creep::errno_status(absl::StrCat("fsync ", (directory_ / table_name(kind)).string()), errno);
    }
  }
  return absl::OkStatus();
}

void Tables::render_row(const creep::Record& record, const StageTimings& timings, Texts& texts) {
  std::string& text = texts[record.kind];
  text += creep::csv_row(record);
  if (record.kind == creep::RecordKind::kStage) {
    const Cost cost = timings.of(stage_rows_++);
    char columns[80];
    std::snprintf(columns, sizeof columns, ",%lld,%.3f", static_cast<long long>(cost.rebuilds),
                  cost.wall_seconds);
    text += columns;
  }
  text += '\n';
}

}  // namespace creepd
