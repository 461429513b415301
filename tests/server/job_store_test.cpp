// The database and what callers may do with jobs, on real files.
#include "server/store/job_store.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <thread>

#include "core/folder/durable_file.h"
#include "core/folder/sample_log.h"
#include "server/folders/job_files.h"
#include "server/jobs/jobs.h"
#include "server/jobs/spec_check.h"
#include "server/rules/refusal.h"
#include "tests/server/temporary_directory.h"

namespace creepd {
namespace {

constexpr const char* kSpec =
    "[specimen]\nparticles = 30\nvoid_ratio = 0.8\n[[program]]\nstage = \"oedometric\"\n"
    "until = { axial_stress = \"1 MPa\" }\n";
const Caller kAlice{"uid:1001", false};
const Caller kBob{"uid:1002", false};
const Caller kRoot{"uid:0", true};

class JobsTest : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(directory_.path() / "jobs");
    open();
  }

  /// As after a restart of the daemon.
  void open(JobLimits limits = {.most_unfinished = 100, .memory = std::uint64_t{1} << 40, .least_free = 0}) {
    jobs_.reset();
    store_.reset();
    auto store = JobStore::open(directory_.path() / "creepd.db");
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
    jobs_ =
        std::make_unique<Jobs>(directory_.path() / "jobs", limits, *store_, samples_, [this] { ++woken_; });
  }

  JobStore::Inserted submit(const Submission& submission, const Caller& caller = kAlice) {
    auto inserted = jobs_->submit(caller, submission);
    EXPECT_TRUE(inserted.ok()) << inserted.status();
    return inserted.ok() ? *inserted : JobStore::Inserted{};
  }

  Job start(const std::string& id) {
    return *store_->change(id, [](Job& job) {
      job.state = JobState::kRunning;
      job.reason = StateReason::kNone;
      ++job.attempts;
      return absl::OkStatus();
    });
  }

  static std::string reason(const absl::Status& status) { return refusal_of(status).reason; }

  TemporaryDirectory directory_;
  SampleLibrary samples_{directory_.path() / "jobs"};
  std::unique_ptr<JobStore> store_;
  std::unique_ptr<Jobs> jobs_;
  int woken_ = 0;
};

TEST_F(JobsTest, AnAcknowledgedJobIsThereAfterARestartWithAllItsFields) {
  const Job job = submit({kSpec, "r1", {{"study", "a"}, {"set", "b"}}, 7}).job;
  open();
  const auto again = jobs_->get(kAlice, job.id);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again->state, JobState::kQueued);
  EXPECT_EQ(again->spec, kSpec);
  EXPECT_EQ(again->labels, (std::map<std::string, std::string>{{"study", "a"}, {"set", "b"}}));
  EXPECT_EQ(again->priority, 7);
  EXPECT_EQ(again->owner, "uid:1001");
  EXPECT_EQ(again->experiment_hash.size(), 64u);
  EXPECT_EQ(again->last_seq(), 1u);
  EXPECT_EQ(*creep::read_file(jobs_->folder(job.id) / "job.toml"), kSpec);
}

TEST_F(JobsTest, ARepeatedSubmissionMakesOneJob) {
  const auto first = submit({kSpec, "r1", {}, 0});
  open();
  const auto second = submit({kSpec, "r1", {}, 0});
  EXPECT_FALSE(first.already_existed);
  EXPECT_TRUE(second.already_existed);
  EXPECT_EQ(first.job.id, second.job.id);
  EXPECT_NE(submit({kSpec, "r1", {}, 0}, kBob).job.id, first.job.id) << "of another caller: another request";
  EXPECT_NE(submit({kSpec, "", {}, 0}).job.id, submit({kSpec, "", {}, 0}).job.id);
}

TEST_F(JobsTest, SubmissionsRepeatedAtTheSameMomentMakeOneJob) {
  std::vector<std::string> ids(8);
  std::vector<std::thread> threads;
  for (std::string& id : ids) threads.emplace_back([&] { id = submit({kSpec, "same", {}, 0}).job.id; });
  for (std::thread& thread : threads) thread.join();
  for (const std::string& id : ids) EXPECT_EQ(id, ids[0]);
  std::size_t folders = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(directory_.path() / "jobs"))
    ++folders;
  EXPECT_EQ(folders, 1u);
}

TEST_F(JobsTest, ARequestIdServesOneContentOnly) {
  submit({kSpec, "r1", {}, 0});
  const auto other = jobs_->submit(kAlice, {kSpec, "r1", {}, 1});
  EXPECT_TRUE(absl::IsInvalidArgument(other.status()));
  EXPECT_EQ(reason(other.status()), "REQUEST_ID_REUSED");
}

TEST_F(JobsTest, ARefusalNamesEverythingThatIsWrong) {
  const auto bad = jobs_->submit(kAlice, {"[specimen]\nparticles = 5\nfoo = 1\n", "", {}, 0});
  EXPECT_EQ(reason(bad.status()), "INVALID_SPEC");
  EXPECT_GE(refusal_of(bad.status()).violations.size(), 3u);
  EXPECT_TRUE(refusal_of(bad.status()).violations[0].field.starts_with("spec:"));
  const auto fields = jobs_->submit(kAlice, {kSpec, "has space", {{"UPPER", "x"}}, 1000});
  EXPECT_EQ(refusal_of(fields.status()).violations.size(), 3u);
}

TEST_F(JobsTest, FilesOfTheDaemonCannotBeNamedByAJobFile) {
  const auto bad = jobs_->submit(
      kAlice,
      {"[specimen]\nparticles = 50\ngrading = { file = \"/etc/passwd\" }\n[[program]]\nstage = \"creep\"\n",
       "",
       {},
       0});
  EXPECT_EQ(reason(bad.status()), "INVALID_SPEC");
  EXPECT_EQ(refusal_of(bad.status()).violations.size(), 1u);
  EXPECT_TRUE(refusal_of(bad.status()).violations[0].field.starts_with("spec:3:"));
}

TEST_F(JobsTest, LimitsAreKept) {
  open({.most_unfinished = 2, .memory = std::uint64_t{1} << 40, .least_free = 0});
  submit({kSpec, "", {}, 0});
  submit({kSpec, "", {}, 0});
  EXPECT_EQ(reason(jobs_->submit(kAlice, {kSpec, "", {}, 0}).status()), "QUEUE_FULL");
  open({.most_unfinished = 100, .memory = 1000, .least_free = 0});
  EXPECT_EQ(reason(jobs_->submit(kAlice, {kSpec, "", {}, 0}).status()), "TOO_LARGE");
  open({.most_unfinished = 100, .memory = std::uint64_t{1} << 40, .least_free = std::uint64_t{1} << 60});
  EXPECT_EQ(reason(jobs_->submit(kAlice, {kSpec, "", {}, 0}).status()), "DISK_FULL");
  EXPECT_EQ(reason(check_spec(std::string(kMostSpecBytes + 1, '#')).status()), "INVALID_SPEC");
}

TEST_F(JobsTest, TheJobOfSomebodyElseDoesNotExist) {
  const std::string id = submit({kSpec, "", {}, 0}).job.id;
  for (const absl::Status& status : {jobs_->get(kBob, id).status(), jobs_->pause(kBob, id).status(),
                                     jobs_->cancel(kBob, id, true).status(), jobs_->remove(kBob, id),
                                     jobs_->fork(kBob, id, {}, {}).status()}) {
    EXPECT_TRUE(absl::IsNotFound(status));
    EXPECT_EQ(status.message(), jobs_->get(kBob, id).status().message())
        << "told apart from a job that is not there";
  }
  EXPECT_TRUE(jobs_->get(kRoot, id).ok());
}

TEST_F(JobsTest, PauseResumeAndCancelAreIdempotent) {
  const std::string id = submit({kSpec, "", {}, 0}).job.id;
  for (int i = 0; i < 2; ++i) EXPECT_EQ(jobs_->pause(kAlice, id)->state, JobState::kPaused);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(jobs_->resume(kAlice, id)->state, JobState::kQueued);
  start(id);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(jobs_->pause(kAlice, id)->reason, StateReason::kPauseRequested);
  EXPECT_EQ(jobs_->resume(kAlice, id)->reason, StateReason::kResumed);
  for (int i = 0; i < 2; ++i)
    EXPECT_EQ(jobs_->cancel(kAlice, id, false)->reason, StateReason::kCancelRequested);
  EXPECT_EQ(reason(jobs_->resume(kAlice, id).status()), "WRONG_STATE");
  EXPECT_TRUE(jobs_->cancel(kAlice, id, true)->stop_now);
  EXPECT_GE(woken_, 8);
}

TEST_F(JobsTest, EveryChangeOfStateIsAnEventAndOnlyThat) {
  const std::string id = submit({kSpec, "", {}, 0}).job.id;
  start(id);
  ASSERT_TRUE(store_->tell({{id, 4, "", "{}"}}).ok());
  ASSERT_TRUE(store_->tell({{id, 2, "", "{}"}}).ok());
  EXPECT_EQ(store_->get(id)->samples, 4u) << "what was told stays told";
  ASSERT_TRUE(jobs_->pause(kAlice, id).ok());
  ASSERT_TRUE(jobs_->pause(kAlice, id).ok());
  const auto events = store_->events(id, 0);
  ASSERT_EQ(events->changes.size(), 3u);
  EXPECT_EQ(events->changes[0].state, JobState::kQueued);
  EXPECT_EQ(events->changes[1].samples_before, 0u);
  EXPECT_EQ(events->changes[2].samples_before, 4u);
  EXPECT_EQ(events->changes[2].reason, StateReason::kPauseRequested);
  EXPECT_EQ(events->job.last_seq(), 7u);
  EXPECT_EQ(store_->events(id, 2)->changes.size(), 1u);
}

TEST_F(JobsTest, AChangeThatIsRefusedLeavesNothing) {
  const std::string id = submit({kSpec, "", {}, 0}).job.id;
  const auto refused = store_->change(id, [](Job& job) {
    job.state = JobState::kRunning;
    return absl::AbortedError("no");
  });
  EXPECT_TRUE(absl::IsAborted(refused.status()));
  EXPECT_EQ(store_->get(id)->state, JobState::kQueued);
  EXPECT_EQ(store_->events(id, 0)->changes.size(), 1u);
}

TEST_F(JobsTest, TheQueueGoesByPriorityThenByAge) {
  const std::string old = submit({kSpec, "", {}, 0}).job.id;
  const std::string young = submit({kSpec, "", {}, 0}).job.id;
  const std::string urgent = submit({kSpec, "", {}, 5}).job.id;
  EXPECT_EQ((*store_->next_queued(0))->id, urgent);
  const auto positions = *store_->queue_positions();
  std::int64_t position = 0;
  for (const std::string& id : {urgent, old, young}) {
    const Job job = *store_->get(id);
    EXPECT_EQ(*store_->queue_position(job), ++position);
    EXPECT_EQ(positions.at(job.number), position);
  }
  ASSERT_TRUE(store_->change(urgent, [](Job& job) { return job.not_before = 100, absl::OkStatus(); }).ok());
  EXPECT_EQ((*store_->next_queued(99))->id, old) << "a job that backs off does not hold up the others";
  EXPECT_EQ((*store_->next_queued(100))->id, urgent);
}

TEST_F(JobsTest, ListsArePagedFilteredAndTheCallersOwn) {
  std::vector<std::string> ids;
  for (int i = 0; i < 5; ++i)
    ids.push_back(submit({kSpec, "", {{"odd", i % 2 != 0 ? "yes" : "no"}}, 0}).job.id);
  submit({kSpec, "", {}, 0}, kBob);
  ListQuery query{.owner = kAlice.owner, .states = {}, .labels = {}, .before_number = 0, .limit = 3};
  const auto first = *store_->list(query);
  ASSERT_EQ(first.size(), 3u);
  EXPECT_EQ(first[0].id, ids[4]);
  query.before_number = first.back().number;
  const auto second = *store_->list(query);
  ASSERT_EQ(second.size(), 2u);
  EXPECT_EQ(second[1].id, ids[0]);
  query = {.owner = kAlice.owner, .states = {}, .labels = {{"odd", "yes"}}, .before_number = 0, .limit = 10};
  EXPECT_EQ(store_->list(query)->size(), 2u);
  ASSERT_TRUE(jobs_->pause(kAlice, ids[1]).ok());
  query.states = {JobState::kPaused};
  ASSERT_EQ(store_->list(query)->size(), 1u);
  EXPECT_EQ(store_->list(query)->front().id, ids[1]);
}

TEST_F(JobsTest, DeletionTakesTheFilesAndIsRefusedWhileTheJobMayRun) {
  const std::string id = submit({kSpec, "r1", {}, 0}).job.id;
  EXPECT_EQ(reason(jobs_->remove(kAlice, id)), "WRONG_STATE");
  ASSERT_TRUE(jobs_->cancel(kAlice, id, false).ok());
  EXPECT_TRUE(jobs_->remove(kAlice, id).ok());
  EXPECT_FALSE(std::filesystem::exists(jobs_->folder(id)));
  EXPECT_TRUE(absl::IsNotFound(jobs_->get(kAlice, id).status()));
  EXPECT_EQ(reason(jobs_->submit(kAlice, {kSpec, "r1", {}, 0}).status()), "REQUEST_ID_REUSED");
}

TEST_F(JobsTest, ADatabaseOfANewerVersionIsRefused) {
  jobs_.reset();
  store_.reset();
  const std::string path = (directory_.path() / "creepd.db").string();
  // Bytes 60 to 63 of the file are PRAGMA user_version.
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(63);
  file.put(99);
  file.close();
  EXPECT_TRUE(absl::IsFailedPrecondition(JobStore::open(path).status()));
}

TEST_F(JobsTest, AStoreOfTheFirstSchemaIsTakenOverWithAllThatIsInIt) {
  // Made by creepd 0.1: five jobs that succeeded, one cancelled, and one running when the daemon was killed.
  jobs_.reset();
  store_.reset();
  const std::filesystem::path path = directory_.path() / "creepd.db";
  std::filesystem::copy_file(std::filesystem::path(CREEP_TEST_DATA) / "store_schema_1.db", path,
                             std::filesystem::copy_options::overwrite_existing);
  for (int start = 0; start < 2; ++start) {
    open();
    const ListQuery all{.owner = "", .states = {}, .labels = {}, .before_number = 0, .limit = 10};
    EXPECT_EQ(store_->list(all)->size(), 7u);
    ListQuery labelled = all;
    labelled.labels = {{"study", "a"}, {"seed", "2"}};
    ASSERT_EQ(store_->list(labelled)->size(), 1u);
    EXPECT_EQ(store_->list(labelled)->front().id, "hqw2x2pwxt");
    EXPECT_EQ(store_->list(labelled)->front().state, JobState::kSucceeded);
    EXPECT_EQ(store_->events("hqw2x2pwxt", 0)->changes.size(), 3u);
    EXPECT_TRUE(store_->attempts("hqw2x2pwxt", 0, 10)->empty()) << "nothing is known of earlier attempts";
    const auto under_way = store_->attempts("kqrgyg9ep4", 0, 10);
    ASSERT_EQ(under_way->size(), 1u);
    EXPECT_EQ(under_way->front().number, 1);
    EXPECT_EQ(under_way->front().state, AttemptState::kRunning);
    EXPECT_EQ(under_way->front().asked, store_->events("kqrgyg9ep4", 0)->changes.back().moment);
  }
}

TEST_F(JobsTest, AttemptsAreKeptInOrderAndGoWithTheirJob) {
  const std::string id = submit({kSpec, "", {}, 0}).job.id;
  Attempt attempt;
  attempt.engine = "local";
  attempt.asked = 7;
  for (attempt.number = 1; attempt.number <= 5; ++attempt.number) ASSERT_TRUE(store_->note(id, attempt).ok());
  attempt.number = 3;
  attempt.state = AttemptState::kEnded;
  attempt.ended = 9;
  attempt.process.signal = 9;
  attempt.cause = Cause::kOutOfMemory;
  attempt.words = "killed";
  ASSERT_TRUE(store_->note(id, attempt).ok());
  open();
  const auto page = jobs_->attempts(kAlice, id, 2, 2);
  ASSERT_EQ(page->size(), 2u);
  EXPECT_EQ(page->at(0).number, 2);
  EXPECT_EQ(page->at(0).state, AttemptState::kAsked);
  EXPECT_EQ(page->at(1).process.signal, 9);
  EXPECT_FALSE(page->at(1).process.exit_code);
  EXPECT_EQ(page->at(1).cause, Cause::kOutOfMemory);
  EXPECT_EQ(page->at(1).words, "killed");
  EXPECT_TRUE(absl::IsNotFound(jobs_->attempts(kBob, id, 0, 10).status()));
  ASSERT_TRUE(jobs_->cancel(kAlice, id, false).ok());
  ASSERT_TRUE(jobs_->remove(kAlice, id).ok());
  EXPECT_TRUE(absl::IsNotFound(store_->note(id, attempt)));
}

TEST_F(JobsTest, ManyDeletionsAreEachDoneOrRefusedAndTheFileShrinks) {
  std::vector<std::string> ids;
  for (int i = 0; i < 50; ++i) {
    ids.push_back(submit({std::string(kSpec) + "# " + std::string(60'000, 'x') + "\n", "", {}, 0}).job.id);
    ASSERT_TRUE(jobs_->cancel(kAlice, ids.back(), false).ok());
  }
  open();
  const auto before = std::filesystem::file_size(directory_.path() / "creepd.db");
  const std::string queued = submit({kSpec, "", {}, 0}).job.id;
  const std::string of_bob = submit({kSpec, "", {}, 0}, kBob).job.id;
  ids.insert(ids.begin() + 10, {queued, of_bob, "nosuchjob", ids.front()});
  const auto removed = jobs_->remove_all(kAlice, ids);
  ASSERT_EQ(removed.size(), 54u);
  for (std::size_t i = 0; i < removed.size(); ++i) {
    if (i < 10 || i > 13) {
      EXPECT_TRUE(removed[i].ok()) << i;
      EXPECT_FALSE(std::filesystem::exists(jobs_->folder(ids[i])));
    }
  }
  EXPECT_EQ(reason(removed[10]), "WRONG_STATE");
  EXPECT_EQ(reason(removed[11]), "JOB_NOT_FOUND");
  EXPECT_EQ(reason(removed[12]), "JOB_NOT_FOUND");
  EXPECT_EQ(reason(removed[13]), "JOB_NOT_FOUND") << "a second time";
  EXPECT_EQ(store_->marked_deleted()->size(), 0u);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(store_->shrink().ok());
  open();  // what is given back leaves the file with its log
  // 50 jobs of 60 kB; 1 MiB of free pages is kept.
  EXPECT_LT(std::filesystem::file_size(directory_.path() / "creepd.db"), before - (50 * 60'000 - (3 << 19)));
  EXPECT_TRUE(jobs_->get(kAlice, queued).ok());
}

TEST_F(JobsTest, ADamagedDatabaseIsRefusedNotReplaced) {
  jobs_.reset();
  store_.reset();
  const std::filesystem::path path = directory_.path() / "creepd.db";
  std::ofstream(path, std::ios::binary | std::ios::trunc) << std::string(8192, 'x');
  EXPECT_FALSE(JobStore::open(path).ok());
  EXPECT_EQ(std::filesystem::file_size(path), 8192u);
}

TEST_F(JobsTest, OnlyListedNamesAreArtifacts) {
  const std::string id = submit({kSpec, "", {}, 0}).job.id;
  const std::filesystem::path folder = jobs_->folder(id);
  std::ofstream(folder / "samples.csv") << "x";
  std::ofstream(folder / "secret") << "x";
  std::filesystem::create_symlink("/etc/passwd", folder / "worker.log");
  EXPECT_TRUE(open_artifact(folder, "samples.csv").ok());
  for (const char* name : {"", ".", "..", "secret", "worker.log", "../../creepd.db", "/etc/passwd",
                           "./samples.csv", "checkpoints/../samples.csv", "samples.csv/"}) {
    EXPECT_EQ(reason(open_artifact(folder, name).status()), "ARTIFACT_NOT_FOUND") << name;
  }
  const auto list = list_artifacts(folder);
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0].name, "job.toml");
  EXPECT_EQ(list[1].name, "samples.csv");
}

TEST_F(JobsTest, AnArtifactsTagStaysWhenItGrowsAndChangesWhenItIsReplaced) {
  const std::string id = submit({kSpec, "", {}, 0}).job.id;
  const std::filesystem::path folder = jobs_->folder(id);
  std::ofstream(folder / "samples.csv") << "x";
  const std::string before = open_artifact(folder, "samples.csv")->artifact.etag;
  std::ofstream(folder / "samples.csv", std::ios::app) << "more";
  EXPECT_EQ(open_artifact(folder, "samples.csv")->artifact.etag, before);
  ASSERT_TRUE(creep::replace_file(folder / "samples.csv", "y").ok());
  EXPECT_NE(open_artifact(folder, "samples.csv")->artifact.etag, before);
}

creep::Record record_of(creep::RecordKind kind, std::uint64_t sequence) {
  return {kind, sequence, std::vector<double>(creep::columns(kind).size(), static_cast<double>(sequence))};
}

TEST_F(JobsTest, SamplesAreFoundByIndexWhileTheLogGrows) {
  const std::filesystem::path path = directory_.path() / "samples.log";
  SampleIndex index(path);
  EXPECT_EQ(*index.poll(), 0u);
  auto log = *creep::SampleLog::open(path);
  EXPECT_EQ(*index.poll(), 0u);
  ASSERT_TRUE(log.append(std::vector{record_of(creep::RecordKind::kSample, 0),
                                     record_of(creep::RecordKind::kStage, 1),
                                     record_of(creep::RecordKind::kSample, 2)})
                  .ok());
  EXPECT_EQ(*index.poll(), 2u);
  EXPECT_EQ(index.read(0)->sequence, 0u);
  ASSERT_TRUE(log.append(std::vector{record_of(creep::RecordKind::kSample, 3)}).ok());
  EXPECT_EQ(index.read(1)->sequence, 2u);
  EXPECT_EQ(*index.poll(), 3u);
  EXPECT_EQ(index.read(2)->sequence, 3u);
  EXPECT_EQ(index.read(1)->values[0], 2.0);
}

}  // namespace
}  // namespace creepd
