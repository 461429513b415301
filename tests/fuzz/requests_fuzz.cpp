// Requests: a few calls of two users and an administrator, as bytes, to the daemon's answers on a real store.
// Each answer is well formed or a refusal with its reason, and nobody sees or changes the jobs of others.
//
// An input is a list of calls: one byte that tells which call and who, two of length, a request. A request
// may name the jobs of its input: "$0" is a finished one with samples and a checkpoint, "$1" the first made,
// ...
#include <array>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include <google/protobuf/message.h>
#include <google/protobuf/stubs/logging.h>

#include "core/arithmetic/check.h"
#include "core/experiment/experiment_toml.h"
#include "core/folder/durable_file.h"
#include "core/folder/job_directory.h"
#include "core/folder/sample_log.h"
#include "core/run/run.h"
#include "creep/v1/creep.pb.h"
#include "creep/v1/details.pb.h"
#include "server/api/error_trailer.h"
#include "server/api/request_handler.h"
#include "server/rules/refusal.h"
#include "tests/fuzz/target.h"
#include "tests/server/temporary_directory.h"

namespace creep::fuzz {
namespace {

namespace v1 = creep::v1;
using creepd::Caller;
using creepd::Job;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

constexpr const char* kSpec =
    "[specimen]\nparticles = 20\n[[program]]\nstage = \"oedometric\"\nuntil = { axial_stress = \"1 MPa\" }\n";
constexpr std::size_t kMostCalls = 16;
constexpr std::size_t kMostRequest = 4096;
constexpr std::size_t kMostRecords = 32;
constexpr std::size_t kSamples = 3;
constexpr std::array kValues = {0.5,
                                0.0,
                                -1.0,
                                3e9,
                                -1e300,
                                9.3e18,
                                std::numeric_limits<double>::infinity(),
                                std::numeric_limits<double>::quiet_NaN()};
const std::array<Caller, 3> kCallers = {Caller{"uid:1001", false}, Caller{"uid:1002", false},
                                        Caller{"uid:0", true}};

enum class Verb : std::uint8_t {
  kSubmit,
  kFork,
  kPlan,
  kGet,
  kList,
  kPause,
  kResume,
  kCancel,
  kDelete,
  kListSamples,
  kListArtifacts,
  kFetch,
  // No calls, but what happens between them:
  kStart,     // the supervisor starts the next job
  kProgress,  // the worker of "$0" tells its progress: the bytes as they are
  kLog,       // and writes its log anew: a record for each byte, of the kind and with the values that it says
};
constexpr std::size_t kVerbs = 15;

struct Call {
  std::uint8_t head = 0;
  std::string request;

  Verb verb() const { return static_cast<Verb>(head % kVerbs); }
  const Caller& caller() const { return kCallers[head / kVerbs % kCallers.size()]; }
};

std::vector<Call> split(std::string_view bytes) {
  std::vector<Call> calls;
  while (bytes.size() >= 3 && calls.size() < kMostCalls) {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(bytes[i]); };
    const std::size_t length = std::min(
        bytes.size() - 3, static_cast<std::size_t>(byte(1)) | static_cast<std::size_t>(byte(2)) << 8);
    calls.push_back({byte(0), std::string(bytes.substr(3, length))});
    bytes.remove_prefix(3 + length);
  }
  return calls;
}

std::string joined(const std::vector<Call>& calls) {
  std::string bytes;
  for (const Call& call : calls) {
    const std::string request = call.request.substr(0, kMostRequest);
    bytes += static_cast<char>(call.head);
    bytes += static_cast<char>(request.size() & 0xFFu);
    bytes += static_cast<char>(request.size() >> 8);
    bytes += request;
  }
  return bytes;
}

std::unique_ptr<Message> request_of(Verb verb) {
  switch (verb) {
    case Verb::kSubmit:
      return std::make_unique<v1::SubmitJobRequest>();
    case Verb::kFork:
      return std::make_unique<v1::ForkJobRequest>();
    case Verb::kPlan:
      return std::make_unique<v1::PlanJobRequest>();
    case Verb::kGet:
      return std::make_unique<v1::GetJobRequest>();
    case Verb::kList:
      return std::make_unique<v1::ListJobsRequest>();
    case Verb::kPause:
      return std::make_unique<v1::PauseJobRequest>();
    case Verb::kResume:
      return std::make_unique<v1::ResumeJobRequest>();
    case Verb::kCancel:
      return std::make_unique<v1::CancelJobRequest>();
    case Verb::kDelete:
      return std::make_unique<v1::DeleteJobRequest>();
    case Verb::kListSamples:
      return std::make_unique<v1::ListSamplesRequest>();
    case Verb::kListArtifacts:
      return std::make_unique<v1::ListArtifactsRequest>();
    default:
      return std::make_unique<v1::FetchArtifactRequest>();
  }
}

/// What a client would be sent, read as a client reads it: among others, all texts are UTF-8.
void check_readable(const Message& message) {
  const std::unique_ptr<Message> copy(message.New());
  CREEP_CHECK(copy->ParseFromString(message.SerializeAsString()), "an answer that no client can read");
}

void check_refusal(const absl::Status& status) {
  const creepd::Refusal refusal = creepd::refusal_of(status);
  CREEP_CHECK(!refusal.reason.empty(), "a refusal without a reason");
  CREEP_CHECK(refusal.reason != "STORAGE_FAILED", "a request made the storage fail");
  CREEP_CHECK(status.code() != absl::StatusCode::kInternal && status.code() != absl::StatusCode::kUnknown,
              "a refusal that blames the daemon");
  const std::string trailer = creepd::error_details(status);
  CREEP_CHECK(trailer.size() <= 5600, "details that no trailer carries");
  v1::details::Status details;
  CREEP_CHECK(details.ParseFromString(trailer), "details that no client can read");
  CREEP_CHECK(details.details_size() >= 1, "a refusal without details");
  for (const auto& any : details.details()) {
    v1::details::ErrorInfo info;
    v1::details::BadRequest violations;
    if (any.type_url().ends_with("ErrorInfo"))
      CREEP_CHECK(info.ParseFromString(any.value()), "an unreadable ErrorInfo");
    if (any.type_url().ends_with("BadRequest")) {
      CREEP_CHECK(violations.ParseFromString(any.value()) && violations.field_violations_size() > 0,
                  "a BadRequest without a violation");
    }
  }
}

/// The daemon without sockets and workers. A new store for each input would be slow: the calls of an input
/// begin with the finished job alone.
class Daemon {
 public:
  Daemon() {
    google::protobuf::SetLogHandler(nullptr);  // requests that are no messages are the rule here
    std::filesystem::create_directories(directory_.path() / "jobs");
    store_ = *creepd::JobStore::open(directory_.path() / "creepd.db");
    jobs_.emplace(directory_.path() / "jobs",
                  creepd::JobLimits{.most_unfinished = 6, .memory = 1 << 28, .least_free = 0}, *store_,
                  samples_, [] {});
    handler_.emplace(*jobs_, *store_, samples_);
  }

  void carry_out(const std::vector<Call>& calls) {
    if (known_.empty()) make_finished_job();
    for (const Call& call : calls) carry_out(call);
    check_pages();
    for (; known_.size() > 1; known_.pop_back()) drop(known_.back());
    if (std::exchange(told_, false)) drop(known_.front());
    if (!store_->get(known_.front()).ok()) known_.clear();
  }

 private:
  void make_finished_job() {
    v1::SubmitJobRequest request;
    v1::SubmitJobResponse response;
    request.set_spec(kSpec);
    CREEP_CHECK(handler_->submit(kCallers[0], request, response).ok(), "the finished job is refused");
    known_.push_back(response.job().id());
    const creep::JobDirectory directory(jobs_->folder(known_[0]));
    write_log(std::string(kSamples, '\0'));
    static const std::string kCheckpoint =
        (*Run::start(*parse_experiment(kSpec).experiment, {}))->checkpoint();
    std::filesystem::create_directories(directory.checkpoints());
    CREEP_CHECK(creep::replace_file(directory.checkpoints() / "ck.1", kCheckpoint).ok() &&
                    creep::replace_file(directory.checkpoints() / "ck.2", "damaged").ok(),
                "no room for checkpoints");
    set_state(known_[0], creepd::JobState::kRunning);
    set_state(known_[0], creepd::JobState::kSucceeded);
  }

  void set_state(const std::string& id, creepd::JobState state) {
    const auto changed = store_->change(id, [&](Job& job) {
      job.state = state;
      job.reason = creepd::StateReason::kNone;
      return absl::OkStatus();
    });
    CREEP_CHECK(changed.ok(), "a legal change of state is refused");
  }

  void write_log(std::string_view recipe) {
    const std::filesystem::path path = creep::JobDirectory(jobs_->folder(known_[0])).sample_log();
    // In the same file, so that what the daemon knows of the old one is wrong.
    if (std::filesystem::exists(path)) std::filesystem::resize_file(path, 0);
    std::vector<Record> records;
    std::string latest;
    std::uint64_t samples = 0;
    for (std::uint64_t i = 0; i < recipe.size(); ++i) {
      const auto byte = static_cast<unsigned char>(recipe[i]);
      const RecordKind kind = kRecordKinds[byte % std::size(kRecordKinds)];
      records.push_back(
          {kind, i, std::vector<double>(columns(kind).size(), kValues[byte / 4 % kValues.size()])});
      if (kind == RecordKind::kSample) ++samples;
      if (byte < 64) latest = encode(records.back());
    }
    auto log = creep::SampleLog::open(path);
    CREEP_CHECK(log.ok() && log->append(records).ok(), "no room for samples");
    CREEP_CHECK(store_->tell({{known_[0], samples, latest, ""}}).ok(), "samples cannot be told");
  }

  /// As the supervisor does.
  void start_next() {
    const auto next = store_->next_queued(std::numeric_limits<creepd::Moment>::max());
    CREEP_CHECK(next.ok(), "the queue cannot be read");
    if (*next) set_state((*next)->id, creepd::JobState::kRunning);
  }

  /// "$3" in the field `job` becomes the id of that job, if there is one.
  void name_job(Message& request) const {
    const FieldDescriptor* field = request.GetDescriptor()->FindFieldByName("job");
    if (field == nullptr) return;
    const std::string text = request.GetReflection()->GetString(request, field);
    if (text.size() != 2 || text[0] != '$' || text[1] < '0') return;
    const auto place = static_cast<std::size_t>(text[1] - '0');
    if (place < known_.size()) request.GetReflection()->SetString(&request, field, known_[place]);
  }

  template <class Request>
  void with(const Call& call, const std::function<absl::Status(const Request&)>& answer) {
    Request request;
    if (!request.ParseFromString(call.request)) return;  // what is no message never reaches the daemon
    name_job(request);
    const absl::Status status = answer(request);
    if (!status.ok()) check_refusal(status);
  }

  template <class Request, class Response>
  void with(const Call& call,
            absl::Status (creepd::RequestHandler::*verb)(const Caller&, const Request&, Response&)) {
    with<Request>(call, [&](const Request& request) {
      Response response;
      absl::Status status = ((*handler_).*verb)(call.caller(), request, response);
      if (!status.ok()) return status;
      check_readable(response);
      check_answer(call.caller(), request, response);
      return status;
    });
  }

  void carry_out(const Call& call) {
    using creepd::RequestHandler;
    switch (call.verb()) {
      case Verb::kSubmit:
        return with(call, &RequestHandler::submit);
      case Verb::kFork:
        return with(call, &RequestHandler::fork);
      case Verb::kPlan:
        return with(call, &RequestHandler::plan);
      case Verb::kGet:
        return with(call, &RequestHandler::get);
      case Verb::kList:
        return with(call, &RequestHandler::list);
      case Verb::kPause:
        return with(call, &RequestHandler::pause);
      case Verb::kResume:
        return with(call, &RequestHandler::resume);
      case Verb::kCancel:
        return with(call, &RequestHandler::cancel);
      case Verb::kDelete:
        return with<v1::DeleteJobRequest>(
            call, [&](const auto& request) { return handler_->remove(call.caller(), request); });
      case Verb::kListSamples:
        return with(call, &RequestHandler::list_samples);
      case Verb::kListArtifacts:
        return with(call, &RequestHandler::list_artifacts);
      case Verb::kFetch:
        return with<v1::FetchArtifactRequest>(call, [&](const auto& request) {
          const auto open = handler_->open(call.caller(), request);
          if (open.ok()) CREEP_CHECK(open->artifact.name == request.name(), "another file than asked for");
          return open.status();
        });
      case Verb::kStart:
        return start_next();
      case Verb::kProgress:
        told_ = true;
        CREEP_CHECK(store_->tell({{known_[0], 0, "", call.request}}).ok(), "progress cannot be told");
        return;
      case Verb::kLog:
        if (!store_->get(known_[0]).ok()) return;
        told_ = true;
        return write_log(std::string_view(call.request).substr(0, kMostRecords));
    }
  }

  static void check_owner(const Caller& caller, const v1::Job& job) {
    CREEP_CHECK(caller.admin || job.owner() == caller.owner, "somebody sees the job of another");
  }

  void check_answer(const Caller& caller, const Message& /*request*/, const v1::Job& job) {
    check_owner(caller, job);
  }
  void check_answer(const Caller& caller, const Message& /*request*/, const v1::ListJobsResponse& response) {
    for (const v1::Job& job : response.jobs()) check_owner(caller, job);
  }
  void check_answer(const Caller& caller, const v1::PlanJobRequest& /*request*/,
                    const v1::PlanJobResponse& response) {
    check_owner(caller, response.pilot());
  }
  void check_answer(const Caller& caller, const v1::ForkJobRequest& request,
                    const v1::SubmitJobResponse& response) {
    note(caller, response);
    CREEP_CHECK(response.job().parent_job() == request.job(), "a fork of another job");
  }
  void check_answer(const Caller& caller, const v1::SubmitJobRequest& request,
                    const v1::SubmitJobResponse& response) {
    const bool starts_from_another = !response.job().parent_job().empty();  // its spec is completed then
    CREEP_CHECK(starts_from_another || response.job().spec() == request.spec(), "a job of another file");
    CREEP_CHECK(request.validate_only() == response.job().id().empty(), "made, or not, against the wish");
    if (request.validate_only()) return;
    note(caller, response);
    if (request.request_id().empty()) return;
    v1::SubmitJobResponse again;
    CREEP_CHECK(handler_->submit(caller, request, again).ok() && again.already_existed() &&
                    again.job().id() == response.job().id(),
                "a repeated submission is another job");
  }
  void check_answer(const Caller& /*caller*/, const Message& /*request*/, const Message& /*response*/) {}

  void note(const Caller& caller, const v1::SubmitJobResponse& response) {
    check_owner(caller, response.job());
    if (!response.already_existed()) known_.push_back(response.job().id());
  }

  /// Pages of one job together are the whole list.
  void check_pages() {
    v1::ListJobsRequest request;
    v1::ListJobsResponse whole;
    CREEP_CHECK(handler_->list(kCallers[2], request, whole).ok(), "the list is refused");
    request.set_page_size(1);
    int jobs = 0;
    do {
      v1::ListJobsResponse page;
      CREEP_CHECK(handler_->list(kCallers[2], request, page).ok(), "a page is refused");
      for (const v1::Job& job : page.jobs()) {
        CREEP_CHECK(jobs < whole.jobs_size() && job.id() == whole.jobs(jobs++).id(), "pages out of order");
      }
      request.set_page_token(page.next_page_token());
    } while (!request.page_token().empty());
    CREEP_CHECK(jobs == whole.jobs_size(), "pages leave jobs out");
  }

  void drop(const std::string& id) {
    const auto job = store_->get(id);
    if (!job.ok()) return;
    if (!creepd::is_final(job->state)) set_state(id, creepd::JobState::kCancelled);
    CREEP_CHECK(jobs_->remove(kCallers[2], id).ok(), "a finished job cannot be deleted");
  }

  creepd::TemporaryDirectory directory_;
  std::unique_ptr<creepd::JobStore> store_;
  creepd::SampleLibrary samples_{directory_.path() / "jobs"};
  std::optional<creepd::Jobs> jobs_;
  std::optional<creepd::RequestHandler> handler_;
  std::vector<std::string> known_;  ///< "$0", "$1", ...
  bool told_ = false;               ///< "$0" is not as it was made
};

std::string call_of(Verb verb, std::size_t caller, const Message& request) {
  return joined({{static_cast<std::uint8_t>(static_cast<std::size_t>(verb) + kVerbs * caller),
                  request.SerializeAsString()}});
}

std::string text_for(const std::string& before, Random& random) {
  constexpr std::array<std::string_view, 10> kWords = {
      "$0", "$1", "$2", "samples.log", "checkpoints/ck.1", "../../creepd.db", "", "label", kSpec, "\xC3\xA9"};
  return random() % 3 == 0 ? std::string(kWords[random() % kWords.size()])
                           : mutated(before, kMostRequest / 2);
}

/// Sets one field of the message, of whatever type.
void alter_field(Message& message, Random& random) {
  const auto* descriptor = message.GetDescriptor();
  if (descriptor->field_count() == 0) return;
  const FieldDescriptor* field = descriptor->field(static_cast<int>(random()) % descriptor->field_count());
  const auto* values = message.GetReflection();
  if (field->is_map()) {
    Message& entry = *values->AddMessage(&message, field);
    alter_field(entry, random);
    alter_field(entry, random);
    return;
  }
  if (field->is_repeated()) {
    if (random() % 4 == 0) return values->ClearField(&message, field);
    return values->AddEnumValue(&message, field, static_cast<int>(awkward_number(random)));
  }
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_STRING:
      return values->SetString(&message, field, text_for(values->GetString(message, field), random));
    case FieldDescriptor::CPPTYPE_BOOL:
      return values->SetBool(&message, field, random() % 2 == 0);
    case FieldDescriptor::CPPTYPE_INT32:
      return values->SetInt32(&message, field, static_cast<std::int32_t>(awkward_number(random)));
    case FieldDescriptor::CPPTYPE_UINT64:
      return values->SetUInt64(&message, field, awkward_number(random));
    case FieldDescriptor::CPPTYPE_ENUM:
      return values->SetEnumValue(&message, field, static_cast<int>(random() % 8));
    default:
      CREEP_CHECK(false, "a request with a field of a type that alter_field() does not know");
  }
}

}  // namespace

std::vector<std::string> seeds() {
  v1::SubmitJobRequest submit;
  submit.set_spec(kSpec);
  submit.set_request_id("one");
  (*submit.mutable_labels())["sand"] = "NE34";
  submit.set_priority(3);
  const std::string submitted = call_of(Verb::kSubmit, 0, submit);
  v1::PlanJobRequest plan;
  plan.set_spec(kSpec);
  plan.set_request_id("plan");
  v1::ForkJobRequest fork;
  fork.set_job("$0");
  fork.set_generation(1);
  v1::GetJobRequest job;
  job.set_job("$1");
  v1::ListJobsRequest list;
  list.set_page_size(2);
  list.add_states(v1::QUEUED);
  v1::ListSamplesRequest samples;
  samples.set_job("$0");
  samples.set_stride(2);
  v1::FetchArtifactRequest fetch;
  fetch.set_job("$0");
  fetch.set_name("samples.log");
  fetch.set_offset(16);
  v1::CancelJobRequest cancel;
  cancel.set_job("$1");
  cancel.set_mode(v1::CancelJobRequest::NOW);
  const auto about = [job](Verb verb, std::size_t caller) { return call_of(verb, caller, job); };
  job.set_job("$0");
  const std::string of_finished = call_of(Verb::kGet, 0, job);
  const std::string start = call_of(Verb::kStart, 0, v1::GetServerInfoRequest());
  return {
      submitted + about(Verb::kGet, 0) + about(Verb::kGet, 1) + call_of(Verb::kList, 2, list),
      submitted + about(Verb::kPause, 0) + about(Verb::kResume, 0) + start + about(Verb::kPause, 0) +
          call_of(Verb::kCancel, 0, cancel) + about(Verb::kDelete, 0),
      call_of(Verb::kPlan, 0, plan) + start + call_of(Verb::kPlan, 0, plan) + call_of(Verb::kPlan, 1, plan),
      call_of(Verb::kFork, 0, fork) + about(Verb::kListArtifacts, 0) + about(Verb::kListSamples, 0),
      call_of(Verb::kListSamples, 0, samples) + call_of(Verb::kFetch, 0, fetch) +
          call_of(Verb::kFetch, 1, fetch) + call_of(Verb::kListSamples, 2, samples),
      joined({{static_cast<std::uint8_t>(Verb::kProgress),
               "{\"stage\":\"creep\",\"stage_index\":1,\"stage_count\":2,\"stage_fraction\":0.5,"
               "\"dynamic_stage\":3,\"particle_steps_per_second\":{\"recent\":1e7},\"wall_seconds\":9.5,"
               "\"seconds_left\":null,\"warnings\":[\"loose\"]}"}}) +
          of_finished + call_of(Verb::kListSamples, 0, samples) +
          joined({{static_cast<std::uint8_t>(Verb::kLog), std::string("\0\1\2\3\4", 5)}}) +
          call_of(Verb::kListSamples, 0, samples) + of_finished,
  };
}

void try_input(std::string_view bytes) {
  static Daemon daemon;
  daemon.carry_out(split(bytes));
}

std::string altered(std::string_view bytes, Random& random) {
  std::vector<Call> calls = split(bytes);
  if (calls.empty() || random() % 16 == 0) return mutated(bytes, kMostCalls * kMostRequest);
  Call& call = calls[random() % calls.size()];
  switch (random() % 6) {
    case 0:
      call.head = static_cast<std::uint8_t>(random() % (kVerbs * kCallers.size()));
      break;
    case 1:
      calls.push_back(Call(call));
      break;
    case 2:
      std::swap(call, calls[random() % calls.size()]);
      break;
    case 3:
      call.request = mutated(call.request, kMostRequest);
      break;
    default: {
      if (call.verb() >= Verb::kStart) {
        call.request = mutated(call.request, kMostRequest);
        break;
      }
      const std::unique_ptr<Message> request = request_of(call.verb());
      static_cast<void>(request->ParseFromString(call.request));
      alter_field(*request, random);
      call.request = request->SerializeAsString();
    }
  }
  return joined(calls);
}

}  // namespace creep::fuzz
