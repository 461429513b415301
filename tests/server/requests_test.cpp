// From request to response on real files: curves, figures, overrides, and how errors leave.
#include "server/api/request_handler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <filesystem>
#include <memory>

#include "core/folder/durable_file.h"
#include "core/folder/job_directory.h"
#include "core/folder/sample_log.h"
#include "creep/v1/details.pb.h"
#include "server/api/error_trailer.h"
#include "server/rules/refusal.h"
#include "tests/server/temporary_directory.h"

namespace creepd {
namespace {

namespace v1 = creep::v1;
using creep::Record;
using creep::RecordKind;

constexpr const char* kSpec =
    "[specimen]\nparticles = 30\nvoid_ratio = 0.8\n[[program]]\nstage = \"oedometric\"\n"
    "until = { axial_stress = \"1 MPa\" }\n";
const Caller kAlice{"uid:1001", false};
const Caller kBob{"uid:1002", false};

double& value(Record& record, std::string_view column) {
  return record.values[creep::column_index(record.kind, column)];
}

/// A creep curve of 8 decades with ripple; every 1 000th a breakage behind.
std::vector<Record> records(std::size_t samples) {
  std::vector<Record> all;
  for (std::size_t i = 0; i < samples; ++i) {
    Record sample{RecordKind::kSample, all.size(),
                  std::vector<double>(creep::columns(RecordKind::kSample).size())};
    const double part = static_cast<double>(i) / static_cast<double>(samples);
    value(sample, "phase") = i < samples / 100 ? 0.0 : i % 50 == 0 ? 3.0 : 2.0;
    value(sample, "creep_time_s") = i < samples / 100 ? 0.0 : std::pow(10.0, -3.0 + 8.0 * part);
    value(sample, "axial_strain") = 0.01 * part + 1e-5 * std::sin(static_cast<double>(i));
    value(sample, "axial_stress_Pa") = 15e6 + 1e5 * std::cos(3.0 * static_cast<double>(i));
    all.push_back(std::move(sample));
    if (i % 1000 != 999) continue;
    Record breakage{
        RecordKind::kBreakage, all.size(),
        std::vector<double>(creep::columns(RecordKind::kBreakage).size(), static_cast<double>(i))};
    all.push_back(std::move(breakage));
  }
  return all;
}

class RequestsTest : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(directory_.path() / "jobs");
    store_ = *JobStore::open(directory_.path() / "creepd.db");
    jobs_ = std::make_unique<Jobs>(directory_.path() / "jobs",
                                   JobLimits{.memory = std::uint64_t{1} << 40, .least_free = 0}, *store_,
                                   samples_, [] {});
    handler_ = std::make_unique<RequestHandler>(*jobs_, *store_, samples_);
  }

  std::string submit(const v1::SubmitJobRequest& request) {
    v1::SubmitJobResponse response;
    const absl::Status status = handler_->submit(kAlice, request, response);
    EXPECT_TRUE(status.ok()) << status;
    return response.job().id();
  }
  std::string submit() {
    v1::SubmitJobRequest request;
    request.set_spec(kSpec);
    return submit(request);
  }

  void append(const std::string& job, const std::vector<Record>& rows, std::size_t from, std::size_t to) {
    auto log = *creep::SampleLog::open(creep::JobDirectory(jobs_->folder(job)).sample_log());
    log.rewind(from);
    ASSERT_TRUE(log.append(std::span(rows).subspan(from, to - from)).ok());
    std::uint64_t samples = 0;
    for (std::size_t i = 0; i < to; ++i) samples += rows[i].kind == RecordKind::kSample ? 1 : 0;
    ASSERT_TRUE(store_->tell({{job, samples, creep::encode(rows[0]), ""}}).ok());
  }

  v1::Curves read(const v1::ReadCurvesRequest& request) {
    v1::Curves curves;
    const absl::Status status = handler_->read_curves(kAlice, request, curves);
    EXPECT_TRUE(status.ok()) << status;
    return curves;
  }
  Refusal refused(const v1::ReadCurvesRequest& request, const Caller& caller = kAlice) {
    v1::Curves curves;
    return refusal_of(handler_->read_curves(caller, request, curves));
  }

  static v1::ReadCurvesRequest three_columns(const std::string& job, bool thinned) {
    v1::ReadCurvesRequest request;
    request.set_job(job);
    for (const char* column : {"creep_time_s", "axial_strain", "axial_stress_Pa"})
      request.add_columns(column);
    if (thinned) request.mutable_thinning();
    return request;
  }

  TemporaryDirectory directory_;
  std::unique_ptr<JobStore> store_;
  SampleLibrary samples_{directory_.path() / "jobs"};
  std::unique_ptr<Jobs> jobs_;
  std::unique_ptr<RequestHandler> handler_;
};

TEST_F(RequestsTest, AHundredThousandSamplesFitAMessageAndAChart) {
  const std::string job = submit();
  const auto rows = records(100'000);
  append(job, rows, 0, rows.size());
  const auto timed = [&](const char* what, const v1::ReadCurvesRequest& request) {
    const std::clock_t begin = std::clock();
    v1::Curves curves = read(request);
    const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    std::printf("%s: %.3f s of processor, %zu bytes, %d rows\n", what, seconds, curves.ByteSizeLong(),
                curves.index_size());
    // Five times what is wanted on a quiet machine, for sanitizers and old processors; reading all columns as
    // messages took 2.4 s.
    EXPECT_LT(seconds, 1.5) << what;
    return curves;
  };
  v1::Curves cold = timed("thinned, log read first", three_columns(job, true));
  const v1::Curves thinned = timed("thinned", three_columns(job, true));
  EXPECT_EQ(cold.SerializeAsString(), thinned.SerializeAsString());
  EXPECT_LT(thinned.ByteSizeLong(), 100'000u);
  EXPECT_GT(thinned.index_size(), 500);
  EXPECT_TRUE(thinned.at_end());
  const v1::Curves whole = timed("whole", three_columns(job, false));
  EXPECT_LT(whole.ByteSizeLong(), 3'000'000u);
  ASSERT_EQ(whole.index_size(), 100'000);
  EXPECT_EQ(whole.next_index(), 100'000u);
  EXPECT_EQ(whole.rows(), 100'000u);
  EXPECT_EQ(whole.columns(2).unit(), "Pa");
  for (int i = 0; i < thinned.index_size(); ++i) {
    const auto row = static_cast<int>(thinned.index(i));
    for (int column = 0; column < 3; ++column)
      ASSERT_EQ(thinned.columns(column).values(i), whole.columns(column).values(row));
  }
}

TEST_F(RequestsTest, ACurveThatGrowsIsTheOneReadAtOnce) {
  const std::string job = submit();
  const auto rows = records(4'000);
  for (const bool thinned : {false, true}) {
    const std::string live = submit();
    std::vector<std::uint64_t> index;
    std::uint64_t next = 0;
    for (std::size_t from = 0, to = 0; to < rows.size(); from = to) {
      to = std::min(from + 333, rows.size());
      append(live, rows, from, to);
      auto request = three_columns(live, thinned);
      request.set_first_index(next);
      const v1::Curves curves = read(request);
      EXPECT_TRUE(curves.at_end());
      std::erase_if(index, [&](std::uint64_t row) { return row >= next; });
      index.insert(index.end(), curves.index().begin(), curves.index().end());
      next = curves.next_index();
    }
    const v1::Curves whole = read(three_columns(live, thinned));
    EXPECT_EQ(index, (std::vector<std::uint64_t>{whole.index().begin(), whole.index().end()}));
    auto nothing_new = three_columns(live, thinned);
    nothing_new.set_first_index(1'000'000);
    EXPECT_EQ(read(nothing_new).next_index(), 1'000'000u);
  }
}

TEST_F(RequestsTest, MoreThanAMessageHoldsComesInSeveral) {
  const std::string job = submit();
  const auto rows = records(30'000);
  append(job, rows, 0, rows.size());
  v1::ReadCurvesRequest request;  // all 36 columns
  request.set_job(job);
  std::uint64_t next = 0;
  int calls = 0;
  for (bool at_end = false; !at_end; ++calls) {
    const v1::Curves curves = read(request);
    EXPECT_LT(curves.ByteSizeLong(), 3'100'000u);
    for (const std::uint64_t row : curves.index()) ASSERT_EQ(row, next++);
    at_end = curves.at_end();
    request.set_first_index(curves.next_index());
  }
  EXPECT_EQ(next, 30'000u);
  EXPECT_GT(calls, 1);
}

TEST_F(RequestsTest, PhasesAndOtherTablesAreReadLikeSamples) {
  const std::string job = submit();
  const auto rows = records(4'000);
  append(job, rows, 0, rows.size());
  auto request = three_columns(job, false);
  request.add_phases(v1::AGEING);
  EXPECT_EQ(read(request).index_size(), 4'000 / 50 - 1);  // the first is packing
  v1::ReadCurvesRequest breakages;
  breakages.set_job(job);
  breakages.set_table(v1::BREAKAGES);
  breakages.add_columns("sequence");
  breakages.add_columns("diameter_m");
  const v1::Curves curves = read(breakages);
  ASSERT_EQ(curves.index_size(), 4);
  EXPECT_EQ(curves.columns(0).values(0), 1000.0);
  EXPECT_EQ(curves.columns(1).values(3), 3999.0);
  // What was not told yet is not there yet.
  append(job, rows, 0, 1'500);
  const std::string other = submit();
  auto log = *creep::SampleLog::open(creep::JobDirectory(jobs_->folder(other)).sample_log());
  ASSERT_TRUE(log.append(rows).ok());
  ASSERT_TRUE(store_->tell({{other, 1'500, "", ""}}).ok());
  breakages.set_job(other);
  EXPECT_EQ(read(breakages).index_size(), 1);
  EXPECT_EQ(read(three_columns(other, false)).index_size(), 1'500);
}

TEST_F(RequestsTest, CurvesRefuseWhatTheyDoNotHave) {
  const std::string job = submit();
  v1::ReadCurvesRequest request;
  request.set_job(job);
  request.add_columns("axial_strain");
  request.add_columns("axial_stress_pa");  // the csv says Pa
  request.mutable_thinning()->set_by("time");
  request.mutable_thinning()->set_width(std::nan(""));
  request.mutable_thinning()->set_per_decade(-1);
  const Refusal refusal = refused(request);
  EXPECT_EQ(refusal.reason, "BAD_REQUEST");
  ASSERT_EQ(refusal.violations.size(), 4u);
  EXPECT_EQ(refusal.violations[0].field, "columns[1]");
  EXPECT_EQ(refused(request, kBob).reason, "JOB_NOT_FOUND");
  v1::ReadCurvesRequest many;
  many.set_job(job);
  for (int i = 0; i < 65; ++i) many.add_columns("axial_strain");
  EXPECT_EQ(refused(many).violations[0].field, "columns");
}

TEST_F(RequestsTest, AFinishedJobHasTheFiguresOfItsSummary) {
  const std::string job = submit();
  ASSERT_TRUE(
      creep::replace_file(jobs_->folder(job) / "summary.json",
                          R"({"figures": {"singh_mitchell_m": 0.93, "none": null, "axial_strain": 0.04}})")
          .ok());
  v1::GetJobRequest request;
  request.set_job(job);
  v1::Job before, after;
  ASSERT_TRUE(handler_->get(kAlice, request, before).ok());
  EXPECT_TRUE(before.figures().empty());
  for (const JobState state : {JobState::kRunning, JobState::kSucceeded}) {
    ASSERT_TRUE(
        store_->change(job, [&](Job& changed) { return changed.state = state, absl::OkStatus(); }).ok());
  }
  ASSERT_TRUE(handler_->get(kAlice, request, after).ok());
  EXPECT_EQ(after.figures().size(), 2u);
  EXPECT_EQ(after.figures().at("singh_mitchell_m"), 0.93);
  v1::ListJobsResponse list;
  ASSERT_TRUE(handler_->list(kAlice, {}, list).ok());
  EXPECT_EQ(list.jobs(0).figures().at("axial_strain"), 0.04);
}

TEST_F(RequestsTest, OverridesMakeTheJobOfTheTextWithThem) {
  v1::SubmitJobRequest request;
  request.set_spec(kSpec);
  (*request.mutable_overrides())["specimen.seed"] = "7";
  (*request.mutable_overrides())["program.0.until.axial_stress"] = "2 MPa";
  request.set_request_id("once");
  const std::string job = submit(request);
  EXPECT_EQ(submit(request), job);
  const Job stored = *jobs_->get(kAlice, job);
  v1::SubmitJobRequest by_hand;
  by_hand.set_spec(stored.spec);
  EXPECT_EQ(jobs_->get(kAlice, submit(by_hand))->experiment_hash, stored.experiment_hash);
  EXPECT_NE(jobs_->get(kAlice, submit())->experiment_hash, stored.experiment_hash);
  EXPECT_NE(stored.spec.find("seed = 7"), std::string::npos);

  (*request.mutable_overrides())["specimen.seed"] = "8";
  v1::SubmitJobResponse response;
  EXPECT_EQ(refusal_of(handler_->submit(kAlice, request, response)).reason, "REQUEST_ID_REUSED");

  v1::SubmitJobRequest wrong;
  wrong.set_spec(kSpec);
  for (const char* key : {"program.4.duration", "program.x", "specimen.seed"})
    (*wrong.mutable_overrides())[key] = "1";
  const Refusal refusal = refusal_of(handler_->submit(kAlice, wrong, response));
  ASSERT_EQ(refusal.violations.size(), 2u);
  EXPECT_EQ(refusal.violations[0].field, "overrides[program.4.duration]");
  EXPECT_EQ(refusal.violations[1].field, "overrides[program.x]");

  // However long the text: read once, not once for each of them.
  v1::SubmitJobRequest long_one;
  std::string spec = std::string(kSpec) + "[material]\n";
  for (int i = 0; i < 40'000; ++i) spec += "key_" + std::to_string(i) + " = 1\n";
  long_one.set_spec(spec);
  for (int i = 0; i < 64; ++i) (*long_one.mutable_overrides())["material.other_" + std::to_string(i)] = "1";
  EXPECT_EQ(refusal_of(handler_->submit(kAlice, long_one, response)).reason, "INVALID_SPEC");
  (*long_one.mutable_overrides())["one_more"] = "1";
  EXPECT_EQ(refusal_of(handler_->submit(kAlice, long_one, response)).violations[0].field, "overrides");
}

TEST_F(RequestsTest, AFileThatIsNoTomlIsToldWithItsPlaceAlsoWithOverrides) {
  v1::SubmitJobRequest request;
  request.set_spec("name = \"a\"\n[specimen\n");
  (*request.mutable_overrides())["specimen.seed"] = "7";
  v1::SubmitJobResponse response;
  const Refusal refusal = refusal_of(handler_->submit(kAlice, request, response));
  EXPECT_EQ(refusal.reason, "INVALID_SPEC");
  EXPECT_EQ(refusal.violations[0].line, 2);
}

TEST_F(RequestsTest, ACheckWithoutAJobLooksAtTheSourceToo) {
  const std::string source = submit();
  v1::SubmitJobRequest request;
  request.set_spec(std::string("[start]\njob = \"") + source + "\"\ncheckpoint = \"1\"\n" + kSpec);
  request.set_validate_only(true);
  v1::SubmitJobResponse response;
  EXPECT_EQ(refusal_of(handler_->submit(kBob, request, response)).reason, "JOB_NOT_FOUND");
  EXPECT_EQ(refusal_of(handler_->submit(kAlice, request, response)).reason, "CHECKPOINT_NOT_FOUND");
}

TEST_F(RequestsTest, ThePriorityIsBoundedBothWays) {
  for (const std::int32_t priority : {std::numeric_limits<std::int32_t>::min(), -101, 101}) {
    v1::SubmitJobRequest request;
    request.set_spec(kSpec);
    request.set_priority(priority);
    v1::SubmitJobResponse response;
    EXPECT_EQ(refusal_of(handler_->submit(kAlice, request, response)).violations.at(0).field, "priority");
  }
}

v1::details::BadRequest bad_request_in(const std::string& trailer) {
  v1::details::Status status;
  v1::details::BadRequest bad;
  EXPECT_TRUE(status.ParseFromString(trailer));
  for (const auto& detail : status.details()) {
    if (detail.type_url() == "type.googleapis.com/google.rpc.BadRequest") bad.ParseFromString(detail.value());
  }
  return bad;
}

TEST(ErrorTrailer, HoldsWhatFitsAndCountsTheRest) {
  for (const std::size_t count : {1u, 20u, 21u, 500u, 20'000u}) {
    std::vector<Violation> violations;
    for (std::size_t i = 0; i < count; ++i)
      violations.push_back({"spec:1:1", "unknown key " + std::string(300, 'x'), static_cast<int>(i + 1), 1});
    const std::string trailer = error_details(bad_request(violations));
    EXPECT_LT(trailer.size(), 5'600u);  // 8 KiB less what base64 adds
    const auto bad = bad_request_in(trailer);
    const auto told = static_cast<std::size_t>(bad.field_violations_size()) - (bad.left_out() > 0 ? 1 : 0);
    EXPECT_EQ(told + static_cast<std::size_t>(bad.left_out()), count);
    EXPECT_EQ(bad.field_violations(0).line(), 1);
    EXPECT_GE(told, std::min<std::size_t>(count, 20));
  }
}

TEST(ErrorTrailer, CutsLongTextsBetweenLettersAndMendsWhatIsNoUtf8) {
  EXPECT_EQ(shortened("abc", 3), "abc");
  EXPECT_EQ(shortened("abcdefgh", 6), "abc...");
  EXPECT_EQ(shortened("aééé", 6), "aé...");
  EXPECT_EQ(shortened("a\xFF\xC3(", 100),
            "a?"
            "?(");
  EXPECT_EQ(shortened("\xED\xA0\x80", 100), "???");  // half of a pair is no letter
  const std::string trailer = error_details(job_not_found(std::string(1 << 20, 'x')));
  EXPECT_LT(trailer.size(), 2'000u);
}

}  // namespace
}  // namespace creepd
