#include "server/worker/snapshot_folder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "core/experiment/wording.h"
#include "core/folder/durable_file.h"
#include "core/output/snapshot.h"

namespace creepd {
namespace {

constexpr std::string_view kKinds[] = {"particles", "contacts"};

absl::Status failed(std::string_view what, const std::filesystem::path& path, const std::error_code& error) {
  return creep::errno_status(absl::StrCat(std::string(what), " ", path.string()), error.value());
}

absl::Status remove_file(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::remove(path, error);
  return error ? failed("remove", path, error) : absl::OkStatus();
}

/// Makes the folder and its name durable.
absl::Status make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directory(folder, error);
  if (error) return failed("make", folder, error);
  return creep::sync_directory(folder.parent_path());
}

}  // namespace

absl::StatusOr<SnapshotFolder> SnapshotFolder::open(const std::filesystem::path& folder) {
  SnapshotFolder opened(folder);
  std::error_code error;
  if (!std::filesystem::exists(folder, error) && !error) return opened;
  std::filesystem::directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    const std::filesystem::path& path = entry->path();
    if (path.extension() == ".tmp") {
      if (auto removed = remove_file(path); !removed.ok()) return removed;
    }
    if (path.extension() != ".vtp") continue;
    const auto bytes = creep::read_file(path);
    if (!bytes.ok()) return bytes.status();
    const auto head = creep::read_snapshot_head(*bytes);
    if (head.ok()) opened.heads_[path.filename().string()] = *head;  // others are not ours
  }
  if (error) return failed("list", folder, error);
  return opened;
}

absl::Status SnapshotFolder::write(std::span<const creep::Snapshot> snapshots) {
  if (snapshots.empty()) return absl::OkStatus();
  if (auto made = make_folder(folder_); !made.ok()) return made;
  for (const creep::Snapshot& snapshot : snapshots) {
    if (auto written = creep::write_durably(folder_ / snapshot.name, snapshot.bytes); !written.ok())
      return written;
    heads_[snapshot.name] = snapshot.head;
  }
  return write_collections();
}

absl::Status SnapshotFolder::drop_after(std::uint64_t sequence) {
  bool dropped = false;
  for (auto head = heads_.begin(); head != heads_.end();) {
    if (head->second.next_sequence <= sequence) {
      ++head;
      continue;
    }
    if (auto removed = remove_file(folder_ / head->first); !removed.ok()) return removed;
    head = heads_.erase(head);
    dropped = true;
  }
  return dropped ? write_collections() : absl::OkStatus();
}

absl::Status SnapshotFolder::write_collections() const {
  for (const std::string_view kind : kKinds) {
    std::string text =
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n";
    double last = -std::numeric_limits<double>::infinity();
    for (const auto& [name, head] : heads_) {
      if (!name.starts_with(kind)) continue;
      // Viewers lay files of one time over each other; with scaled inertia the dynamic stages take none.
      last = std::max(head.age + head.dynamic_time,
                      std::nextafter(last, std::numeric_limits<double>::infinity()));
      absl::StrAppend(&text, "<DataSet timestep=\"", creep::shortest(last), "\" part=\"0\" file=\"", name,
                      "\"/>\n");
    }
    text += "</Collection>\n</VTKFile>\n";
    const auto path = folder_ / absl::StrCat(std::string(kind), ".pvd");
    if (auto written = creep::write_durably(path, text); !written.ok()) return written;
  }
  return absl::OkStatus();
}

}  // namespace creepd
