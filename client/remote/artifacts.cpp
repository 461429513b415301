#include "client/remote/artifacts.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/local/run_folder.h"
#include "core/run/run.h"

namespace creepctl {
namespace {

using Clock = std::chrono::steady_clock;
using nlohmann::ordered_json;

constexpr const char* kManifest = ".creepctl-fetch.json";
constexpr const char* kPartial = ".partial";
constexpr int kReplacements =
    10;  // of one file while it is fetched; after that it changes faster than it comes

CallResult failed(absl::Status status) {
  CallResult result;
  result.status = std::move(status);
  return result;
}

CallResult cannot_write(const std::filesystem::path& path, const std::string& why) {
  return failed(absl::ResourceExhaustedError(absl::StrCat("cannot write ", path.string(), ": ", why)));
}

/// A folder that artifacts are brought into, with what it knows of them: the etag of each file in it.
class Folder {
 public:
  explicit Folder(std::filesystem::path path) : path_(std::move(path)) {}

  CallResult open(const std::string& job) {
    std::error_code error;
    std::filesystem::create_directories(path_, error);
    if (error) return cannot_write(path_, error.message());
    manifest_ = ordered_json::parse(read_text(path_ / kManifest), nullptr, false);
    const bool known = manifest_.is_object() && manifest_.contains("job") && manifest_.contains("etags") &&
                       manifest_["etags"].is_object();
    if (known && manifest_["job"] == job) return {};
    if (known || !std::filesystem::is_empty(path_, error)) {
      return failed(absl::InvalidArgumentError(
          absl::StrCat(path_.string(), known ? " holds the files of another job" : " holds other files",
                       "; give another --out")));
    }
    manifest_ = {{"job", job}, {"etags", ordered_json::object()}};
    return save();
  }

  std::filesystem::path file(const std::string& name) const { return path_ / name; }

  std::string etag(const std::string& name) const {
    const auto found = manifest_["etags"].find(name);
    return found != manifest_["etags"].end() && found->is_string() ? found->get<std::string>() : "";
  }

  CallResult set_etag(const std::string& name, const std::string& etag) {
    manifest_["etags"][name] = etag;
    return save();
  }

  /// The file and what is known of it go from one name to the other.
  CallResult rename(const std::string& from, const std::string& to) {
    // Forgotten first: a kill in between must not give the new bytes the old etag.
    const std::string kept = etag(from);
    manifest_["etags"].erase(to);
    if (CallResult saved = save(); !saved.ok()) return saved;
    std::error_code error;
    std::filesystem::rename(file(from), file(to), error);
    if (error) return cannot_write(file(to), error.message());
    manifest_["etags"].erase(from);
    return set_etag(to, kept);
  }

 private:
  CallResult save() {
    const auto temporary = path_ / (std::string(kManifest) + ".tmp");
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    out << manifest_.dump(1) << "\n";
    out.close();
    if (!out) return cannot_write(temporary, std::strerror(errno));
    std::error_code error;
    std::filesystem::rename(temporary, path_ / kManifest, error);
    return error ? cannot_write(path_ / kManifest, error.message()) : CallResult();
  }

  std::filesystem::path path_;
  ordered_json manifest_;
};

std::uint64_t size_of(const std::filesystem::path& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  return error ? 0 : size;
}

/// Brings one artifact; `file` says how much of it came now.
class ArtifactFetch {
 public:
  ArtifactFetch(Connection& connection, const std::string& job, Folder& folder, FetchedFile& file)
      : connection_(connection),
        job_(job),
        folder_(folder),
        file_(file),
        name_(file.name),
        partial_(file.name + kPartial) {}

  CallResult run(const api::Artifact& listed) {
    std::error_code error;
    std::filesystem::create_directories(folder_.file(name_).parent_path(), error);
    if (error) return cannot_write(folder_.file(name_), error.message());
    const bool same_file =
        std::filesystem::exists(folder_.file(name_)) && folder_.etag(name_) == listed.etag();
    const std::uint64_t have = size_of(folder_.file(name_));
    if (same_file && have == listed.size_bytes()) {
      file_.size_bytes = have;
      return {};
    }
    if (same_file && have < listed.size_bytes()) {  // it grew since
      if (CallResult renamed = folder_.rename(name_, partial_); !renamed.ok()) return renamed;
    }
    for (int i = 0; i < kReplacements; ++i) {
      CallResult result = bring();
      const bool other_file = result.reason == "ARTIFACT_REPLACED" || result.reason == "OFFSET_BEYOND_END";
      if (!other_file) return result;
      std::filesystem::remove(folder_.file(partial_), error);
    }
    return failed(
        absl::AbortedError(absl::StrCat(name_, " is replaced again and again while it is fetched")));
  }

 private:
  CallResult bring() {
    ArtifactPosition position;
    if (const auto etag = folder_.etag(partial_); !etag.empty()) {
      position = {size_of(folder_.file(partial_)), etag};
    }
    if (position.offset == 0) position.etag.clear();
    // What lies there without an etag is of no known file.
    out_.open(folder_.file(partial_),
              std::ios::binary | (position.offset > 0 ? std::ios::app : std::ios::trunc));
    CallResult local = out_ ? CallResult() : cannot_write(folder_.file(partial_), std::strerror(errno));
    if (!local.ok()) return local;
    CallResult result = read_artifact(
        connection_, job_, name_, position,
        [&](const api::Artifact& artifact) {
          if (folder_.etag(partial_) != artifact.etag()) local = folder_.set_etag(partial_, artifact.etag());
          return local.ok();
        },
        [&](std::string_view data) {
          out_.write(data.data(), static_cast<std::streamsize>(data.size()));
          if (!out_) local = cannot_write(folder_.file(partial_), std::strerror(errno));
          file_.fetched_bytes += data.size();
          return local.ok();
        });
    out_.close();
    if (!local.ok()) return local;
    if (!out_) return cannot_write(folder_.file(partial_), std::strerror(errno));
    if (!result.ok()) return result;
    file_.size_bytes = position.offset;
    return folder_.rename(partial_, name_);
  }

  Connection& connection_;
  const std::string& job_;
  Folder& folder_;
  FetchedFile& file_;
  std::string name_;
  std::string partial_;
  std::ofstream out_;
};

}  // namespace

CallResult read_artifact(Connection& connection, const std::string& job, const std::string& name,
                         ArtifactPosition& position, const std::function<bool(const api::Artifact&)>& begin,
                         const std::function<bool(std::string_view)>& data) {
  constexpr std::chrono::seconds kPatience{10};
  auto progress = Clock::now();
  for (;;) {
    api::FetchArtifactRequest request;
    request.set_job(job);
    request.set_name(name);
    request.set_offset(position.offset);
    request.set_etag(position.etag);
    const auto stream = connection.fetch(request);
    api::ArtifactChunk chunk;
    std::uint64_t end = position.offset;
    while (stream->read(chunk)) {
      progress = Clock::now();
      if (chunk.has_artifact()) {
        end = chunk.artifact().size_bytes();
        position.etag = chunk.artifact().etag();
        if (!begin(chunk.artifact())) return failed(absl::AbortedError("stopped"));
      }
      if (chunk.data().empty()) continue;
      if (chunk.offset() != position.offset) {
        return failed(absl::DataLossError(absl::StrCat(name, ": the daemon sends bytes out of order")));
      }
      if (!data(chunk.data())) return failed(absl::AbortedError("stopped"));
      position.offset += chunk.data().size();
    }
    CallResult result = stream->finish();
    if (result.ok() && position.offset < end) {
      return failed(absl::DataLossError(absl::StrCat(name, ": ", position.offset, " bytes came of ", end)));
    }
    if (!result.lost() || Clock::now() - progress > kPatience) return result;
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
}

bool is_safe_artifact_name(std::string_view name) {
  if (name.empty() || name.find('\0') != std::string_view::npos) return false;
  const std::vector<std::string> parts = absl::StrSplit(absl::string_view(name.data(), name.size()), '/');
  return std::none_of(parts.begin(), parts.end(),
                      [](const std::string& part) { return part.empty() || part == "." || part == ".."; });
}

CallResult fetch_all(Connection& connection, const std::string& job, const std::filesystem::path& folder,
                     const std::function<void(const FetchedFile&)>& said, std::vector<FetchedFile>& files) {
  Folder target(folder);
  if (CallResult opened = target.open(job); !opened.ok()) return opened;
  api::ListArtifactsRequest request;
  request.set_job(job);
  api::ListArtifactsResponse listed;
  if (CallResult result = connection.call(request, listed); !result.ok()) return result;
  for (const api::Artifact& artifact : listed.artifacts()) {
    if (!is_safe_artifact_name(artifact.name())) {
      return failed(absl::DataLossError(absl::StrCat("the daemon names a file \"", artifact.name(), "\"")));
    }
    FetchedFile file{.name = artifact.name()};
    CallResult result = ArtifactFetch(connection, job, target, file).run(artifact);
    if (result.reason == "ARTIFACT_NOT_FOUND") continue;  // an old checkpoint, dropped since it was listed
    if (!result.ok()) return result;
    said(file);
    files.push_back(std::move(file));
  }
  return {};
}

std::vector<std::string> verify_fetched(const api::Job& job, const std::filesystem::path& folder) {
  std::vector<std::string> faults;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder / "checkpoints", error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!absl::StartsWith(name, "ck.") || absl::EndsWith(name, kPartial)) continue;
    const auto info = creep::read_checkpoint_info(read_text(entry->path()));
    if (!info.ok()) faults.push_back(absl::StrCat(name, ": ", info.status().message()));
  }
  const auto job_file = folder / "job.toml";
  if (std::filesystem::exists(job_file, error) && read_text(job_file) != job.spec()) {
    faults.push_back("job.toml is not the job file that was submitted");
  }
  if (job.state() != api::SUCCEEDED) return faults;
  const ordered_json summary = ordered_json::parse(read_text(folder / "summary.json"), nullptr, false);
  if (!summary.is_object() || summary.value("state_digest", "") != job.state_digest()) {
    faults.push_back("summary.json does not have the state_digest that the daemon knows");
  }
  return faults;
}

}  // namespace creepctl
