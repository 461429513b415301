#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "client/local/run_folder.h"
#include "client/remote/artifacts.h"
#include "client/remote/follow.h"
#include "client/remote/message_json.h"
#include "client/remote/remote_job.h"
#include "client/terminal/exit_codes.h"
#include "tests/client/scripted_connection.h"

namespace creepctl {
namespace {

using absl::StatusCode;

api::Event sample(std::uint64_t seq) {
  api::Event event;
  event.set_seq(seq);
  event.mutable_sample()->set_index(seq);
  return event;
}

api::Event change(std::uint64_t seq, api::JobState state) {
  api::Event event;
  event.set_seq(seq);
  event.mutable_state_change()->set_state(state);
  return event;
}

api::Job job(const std::string& id, api::JobState state = api::RUNNING) {
  api::Job job;
  job.set_id(id);
  job.set_state(state);
  return job;
}

// ------------------------------------------------------------------------------------------------- addresses

TEST(ServerTarget, IsTheSocketOfTheUserWhereNothingIsGiven) {
  ::setenv("XDG_RUNTIME_DIR", "/run/user/1000", 1);
  EXPECT_EQ(*server_target(""), "unix:/run/user/1000/creepd.sock");
  ::unsetenv("XDG_RUNTIME_DIR");
  EXPECT_EQ(server_target("").status().code(), StatusCode::kInvalidArgument);
}

TEST(ServerTarget, TakesPathsAndHostsWithAPort) {
  EXPECT_EQ(*server_target("/tmp/a.sock"), "unix:/tmp/a.sock");
  EXPECT_EQ(*server_target("unix:/tmp/a.sock"), "unix:/tmp/a.sock");
  EXPECT_EQ(*server_target("unix:///tmp/a.sock"), "unix:/tmp/a.sock");
  EXPECT_EQ(*server_target("./a.sock"), "unix:" + (std::filesystem::current_path() / "./a.sock").string());
  EXPECT_EQ(*server_target("cluster:7000"), "cluster:7000");
  for (const char* wrong : {"cluster", ":7000", "cluster:", "cluster:http", "cluster:99999", "cluster:0",
                            "http://cluster:7000"}) {
    EXPECT_FALSE(server_target(wrong).ok()) << wrong;
  }
  EXPECT_FALSE(server_target("/" + std::string(107, 'x')).ok()) << "more than sockaddr_un holds";
  EXPECT_TRUE(server_target("/" + std::string(106, 'x')).ok());
}

TEST(Connection, LeavesThisMachineOnlyOverTls) {
  ServerOptions options;
  options.address = "127.0.0.1:7000";  // the end of a forwarded socket
  EXPECT_TRUE(Connection::open(options).ok());
  options.address = "example.org:7000";
  EXPECT_FALSE(Connection::open(options).ok());
  options.tls_ca = "/dev/null";  // and no certificate
  EXPECT_FALSE(Connection::open(options).ok());
}

// ------------------------------------------------------------------------------------------- names and words

TEST(FindJob, TakesAnIdOrTheBeginningOfOneOnly) {
  ScriptedConnection daemon;
  daemon.jobs = {job("abcd1"), job("abce2"), job("ffff3"), job("abcd")};
  api::Job found;
  ASSERT_TRUE(find_job(daemon, "f", found).ok());  // on the second page
  EXPECT_EQ(found.id(), "ffff3");
  ASSERT_TRUE(find_job(daemon, "abcd", found).ok());  // whole, though it begins another
  EXPECT_EQ(found.id(), "abcd");
  const CallResult several = find_job(daemon, "abc", found);
  EXPECT_EQ(several.status.code(), StatusCode::kInvalidArgument);
  EXPECT_NE(several.status.message().find("abcd1, abce2, abcd"), std::string::npos) << several.status;
  EXPECT_EQ(find_job(daemon, "x", found).status.code(), StatusCode::kNotFound);
  EXPECT_EQ(find_job(daemon, "", found).status.code(), StatusCode::kNotFound);
}

TEST(ListJobs, StopsAtTheLimit) {
  ScriptedConnection daemon;
  daemon.jobs = {job("a"), job("b"), job("c"), job("d"), job("e")};
  std::vector<api::Job> jobs;
  ASSERT_TRUE(list_jobs(daemon, {}, 0, jobs).ok());
  EXPECT_EQ(jobs.size(), 5u);
}

TEST(StateText, ExplainsOnlyWhatTheStateDoesNotSay) {
  EXPECT_EQ(state_text(api::RUNNING, api::STATE_REASON_UNSPECIFIED), "RUNNING");
  EXPECT_EQ(state_text(api::RUNNING, api::PAUSE_REQUESTED), "RUNNING, pause requested");
  EXPECT_EQ(state_text(api::SUCCEEDED, api::COMPLETED), "SUCCEEDED");
  EXPECT_EQ(state_text(api::SUCCEEDED, api::CREEP_FAILURE), "SUCCEEDED, creep failure");
  EXPECT_EQ(news_in("completed", api::COMPLETED), "");
  EXPECT_EQ(news_in("checkpoint 3 was damaged", api::COMPLETED), "checkpoint 3 was damaged");
}

TEST(Label, IsAKeyAndAValue) {
  std::string key, value;
  ASSERT_TRUE(split_label("a=b=c", key, value));
  EXPECT_EQ(key, "a");
  EXPECT_EQ(value, "b=c");
  EXPECT_TRUE(split_label("a=", key, value));
  EXPECT_FALSE(split_label("a", key, value));
  EXPECT_FALSE(split_label("=b", key, value));
}

TEST(MessageJson, HasNumbersNamesInstantsAndNothingThatIsNotSet) {
  api::Job shown = job("abcd", api::SUCCEEDED);
  shown.mutable_submit_time()->set_seconds(1772366400);
  shown.set_last_seq(std::uint64_t{1} << 60);
  (*shown.mutable_labels())["sand"] = "NE34";
  shown.add_warnings("loose");
  shown.mutable_progress()->set_seconds_left(0.5);
  const auto json = to_json(shown);
  EXPECT_EQ(json["id"], "abcd");
  EXPECT_EQ(json["state"], "SUCCEEDED");
  EXPECT_EQ(json["submit_time"], "2026-03-01T12:00:00Z");
  EXPECT_EQ(json["last_seq"], std::uint64_t{1} << 60);
  EXPECT_EQ(json["labels"]["sand"], "NE34");
  EXPECT_EQ(json["warnings"][0], "loose");
  EXPECT_EQ(json["progress"]["seconds_left"], 0.5);
  EXPECT_FALSE(json.contains("end_time"));
  EXPECT_FALSE(json.contains("latest_sample"));
}

TEST(MessageJson, RepeatedValuesOfEveryKindAreThere) {
  api::Curves curves;
  curves.add_index(7);
  curves.add_index(std::uint64_t{1} << 60);
  api::Curve& curve = *curves.add_columns();
  curve.set_name("axial_strain");
  curve.add_values(0.25);
  curve.add_values(-1e300);
  const auto json = to_json(curves);
  EXPECT_EQ(json["index"], (std::vector<std::uint64_t>{7, std::uint64_t{1} << 60}));
  EXPECT_EQ(json["columns"][0]["values"], (std::vector<double>{0.25, -1e300}));
  api::ListJobsRequest request;
  request.add_states(api::RUNNING);
  EXPECT_EQ(to_json(request)["states"][0], "RUNNING");
  api::Job shown;
  (*shown.mutable_figures())["singh_mitchell_m"] = 0.9;
  EXPECT_EQ(to_json(shown)["figures"]["singh_mitchell_m"], 0.9);
}

TEST(ExitCode, FollowsFromTheFailure) {
  EXPECT_EQ(exit_code_of(failure(StatusCode::kUnavailable)), kUnreachable);
  EXPECT_EQ(exit_code_of(failure(StatusCode::kPermissionDenied)), kUnreachable);
  EXPECT_EQ(exit_code_of(failure(StatusCode::kNotFound)), kInvalidInput);
  EXPECT_EQ(exit_code_of(failure(StatusCode::kInvalidArgument)), kInvalidInput);
  EXPECT_EQ(exit_code_of(failure(StatusCode::kFailedPrecondition)), kFailed);
  EXPECT_EQ(exit_code_of(api::SUCCEEDED), kOk);
  EXPECT_EQ(exit_code_of(api::FAILED), kFailed);
  EXPECT_EQ(exit_code_of(api::CANCELLED), kCancelled);
}

// ------------------------------------------------------------------------------------------------- following

struct Followed {
  std::vector<std::uint64_t> seen;
  int lost = 0;
  int again = 0;
  FollowEnd end;
};

Followed follow_all(ScriptedConnection& daemon, std::uint64_t after_seq,
                    Connection::Deadline deadline = std::nullopt) {
  Followed followed;
  const FollowListener listener = {
      .event = [&](const api::Event& event) { followed.seen.push_back(event.seq()); },
      .heartbeat = nullptr,
      .lost = [&](const std::string&) { ++followed.lost; },
      .again = [&](double) { ++followed.again; }};
  followed.end = follow(daemon, "abcd", after_seq, deadline, listener);
  return followed;
}

TEST(Follow, GoesOnAfterTheLastNumberSeenWhenTheConnectionBreaks) {
  ScriptedConnection daemon;
  daemon.watches.push_back({{sample(4), sample(5)}, failure(StatusCode::kUnavailable)});
  daemon.watches.push_back({{}, failure(StatusCode::kUnavailable)});
  daemon.watches.push_back({{}, failure(StatusCode::kInternal)});   // a stream reset
  daemon.watches.push_back({{}, failure(StatusCode::kCancelled)});  // the daemon was going down
  daemon.watches.push_back({{sample(5), sample(6), change(7, api::FAILED)}, {}});
  const Followed followed = follow_all(daemon, 3);
  EXPECT_EQ(followed.seen, (std::vector<std::uint64_t>{4, 5, 6, 7}));  // 5 came twice
  EXPECT_EQ(followed.lost, 1);                                         // said once, not at each attempt
  EXPECT_EQ(followed.again, 1);
  EXPECT_EQ(followed.end.kind, FollowEnd::kFinal);
  EXPECT_EQ(followed.end.state, api::FAILED);
  ASSERT_EQ(daemon.watch_requests.size(), 5u);
  EXPECT_EQ(daemon.watch_requests[0].after_seq(), 3u);
  EXPECT_EQ(daemon.watch_requests[4].after_seq(), 5u);
}

TEST(Follow, KnowsTheEndOfAJobThatWasFinalAlready) {
  ScriptedConnection daemon;
  daemon.jobs = {job("abcd", api::CANCELLED)};
  daemon.watches.push_back({{}, {}});
  EXPECT_EQ(follow_all(daemon, 9).end.state, api::CANCELLED);
}

TEST(Follow, EndsWithTheDaemonsRefusal) {
  ScriptedConnection daemon;
  daemon.watches.push_back({{sample(1)}, failure(StatusCode::kNotFound, "JOB_NOT_FOUND")});
  const Followed followed = follow_all(daemon, 0);
  EXPECT_EQ(followed.end.kind, FollowEnd::kRefused);
  EXPECT_EQ(followed.end.refusal.reason, "JOB_NOT_FOUND");
}

TEST(Follow, StopsAtItsDeadlineWhileTheDaemonIsAway) {
  ScriptedConnection daemon;
  for (int i = 0; i < 50; ++i) daemon.watches.push_back({{}, failure(StatusCode::kUnavailable)});
  const auto deadline = std::chrono::system_clock::now() + std::chrono::milliseconds(300);
  EXPECT_EQ(follow_all(daemon, 0, deadline).end.kind, FollowEnd::kTimedOut);
}

TEST(ReconnectDelay, GrowsToFiveSecondsAndIsScattered) {
  EXPECT_EQ(reconnect_delay(0, 0.0), 200);
  EXPECT_EQ(reconnect_delay(0, 1.0), 100);
  EXPECT_EQ(reconnect_delay(3, 0.0), 1600);
  EXPECT_EQ(reconnect_delay(100000, 0.0), 5000);
}

// -------------------------------------------------------------------------------------------------- fetching

TEST(ArtifactName, MustStayBelowTheFolder) {
  EXPECT_TRUE(is_safe_artifact_name("samples.csv"));
  EXPECT_TRUE(is_safe_artifact_name("checkpoints/ck.7"));
  for (const char* name : {"", "/etc/passwd", "../x", "a/../b", "a//b", "a/", "."}) {
    EXPECT_FALSE(is_safe_artifact_name(name)) << name;
  }
}

class Fetch : public ::testing::Test {
 protected:
  Fetch() : folder_(::testing::TempDir() + "fetch-" + std::to_string(::getpid())) {
    std::filesystem::remove_all(folder_);
  }
  ~Fetch() override { std::filesystem::remove_all(folder_); }

  static api::Artifact artifact(const std::string& name, std::uint64_t size, const std::string& etag) {
    api::Artifact artifact;
    artifact.set_name(name);
    artifact.set_size_bytes(size);
    artifact.set_etag(etag);
    return artifact;
  }
  static api::ArtifactChunk chunk(std::uint64_t offset, const std::string& data) {
    api::ArtifactChunk chunk;
    chunk.set_offset(offset);
    chunk.set_data(data);
    return chunk;
  }
  static api::ArtifactChunk first(const api::Artifact& artifact, std::uint64_t offset,
                                  const std::string& data) {
    api::ArtifactChunk first = chunk(offset, data);
    *first.mutable_artifact() = artifact;
    return first;
  }

  CallResult fetch() {
    files_.clear();
    return fetch_all(
        daemon_, "abcd", folder_, [](const FetchedFile&) {}, files_);
  }
  std::string text(const char* name) { return read_text(folder_ / name); }
  const api::FetchArtifactRequest& last_request() { return daemon_.fetch_requests.back(); }

  std::filesystem::path folder_;
  ScriptedConnection daemon_;
  std::vector<FetchedFile> files_;
};

TEST_F(Fetch, GoesOnInTheMiddleOfAFileWithTheSameEtag) {
  const auto file = artifact("a/b.csv", 6, "e1");
  daemon_.artifacts = {file};
  daemon_.fetches.push_back({{first(file, 0, "ab"), chunk(2, "c")}, failure(StatusCode::kUnavailable)});
  daemon_.fetches.push_back({{first(file, 3, "def")}, {}});
  ASSERT_TRUE(fetch().ok());
  EXPECT_EQ(text("a/b.csv"), "abcdef");
  EXPECT_EQ(last_request().offset(), 3u);
  EXPECT_EQ(last_request().etag(), "e1");
}

TEST_F(Fetch, GoesOnInALaterCallAndBringsNothingTwice) {
  const auto file = artifact("b.csv", 6, "e1");
  daemon_.artifacts = {file};
  daemon_.fetches.push_back({{first(file, 0, "abc")}, failure(StatusCode::kPermissionDenied)});
  EXPECT_FALSE(fetch().ok());
  EXPECT_FALSE(std::filesystem::exists(folder_ / "b.csv")) << "a file that is not whole has its name";
  daemon_.fetches.push_back({{first(file, 3, "def")}, {}});
  ASSERT_TRUE(fetch().ok());
  EXPECT_EQ(text("b.csv"), "abcdef");
  const std::size_t requests = daemon_.fetch_requests.size();
  ASSERT_TRUE(fetch().ok());
  EXPECT_EQ(daemon_.fetch_requests.size(), requests);
  EXPECT_EQ(files_[0].fetched_bytes, 0u);
}

TEST_F(Fetch, BringsOnlyWhatAFileGrewBy) {
  daemon_.artifacts = {artifact("b.csv", 3, "e1")};
  daemon_.fetches.push_back({{first(daemon_.artifacts[0], 0, "abc")}, {}});
  ASSERT_TRUE(fetch().ok());
  daemon_.artifacts = {artifact("b.csv", 6, "e1")};
  daemon_.fetches.push_back({{first(daemon_.artifacts[0], 3, "def")}, {}});
  ASSERT_TRUE(fetch().ok());
  EXPECT_EQ(last_request().offset(), 3u);
  EXPECT_EQ(text("b.csv"), "abcdef");
}

TEST_F(Fetch, BeginsAgainWhenAnotherFileTookThePlace) {
  const auto old_file = artifact("b.csv", 6, "e1"), new_file = artifact("b.csv", 2, "e2");
  daemon_.artifacts = {old_file};
  daemon_.fetches.push_back({{first(old_file, 0, "abc")}, failure(StatusCode::kUnavailable)});
  daemon_.fetches.push_back({{}, failure(StatusCode::kAborted, "ARTIFACT_REPLACED")});
  daemon_.fetches.push_back({{first(new_file, 0, "xy")}, {}});
  ASSERT_TRUE(fetch().ok());
  EXPECT_EQ(last_request().offset(), 0u);
  EXPECT_EQ(last_request().etag(), "");
  EXPECT_EQ(text("b.csv"), "xy");
}

TEST_F(Fetch, RefusesBytesThatAreMissingOrOutOfOrder) {
  const auto file = artifact("b.csv", 6, "e1");
  daemon_.artifacts = {file};
  daemon_.fetches.push_back({{first(file, 0, "abc")}, {}});
  EXPECT_EQ(fetch().status.code(), StatusCode::kDataLoss);
  daemon_.fetches.push_back({{first(file, 3, "d"), chunk(5, "f")}, {}});
  EXPECT_EQ(fetch().status.code(), StatusCode::kDataLoss);
}

TEST_F(Fetch, WritesNeitherOutsideItsFolderNorIntoForeignOnes) {
  daemon_.artifacts = {artifact("../stolen", 1, "e")};
  EXPECT_EQ(fetch().status.code(), StatusCode::kDataLoss);
  std::filesystem::remove_all(folder_);
  std::filesystem::create_directories(folder_);
  std::ofstream(folder_ / "thesis.tex") << "mine";
  daemon_.artifacts.clear();
  EXPECT_EQ(fetch().status.code(), StatusCode::kInvalidArgument);
}

TEST_F(Fetch, PassesOverACheckpointThatWasDroppedMeanwhile) {
  daemon_.artifacts = {artifact("checkpoints/ck.1", 3, "e1")};
  daemon_.fetches.push_back({{}, failure(StatusCode::kNotFound, "ARTIFACT_NOT_FOUND")});
  EXPECT_TRUE(fetch().ok());
  EXPECT_TRUE(files_.empty());
}

}  // namespace
}  // namespace creepctl
