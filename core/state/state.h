// What of a run survives: the specimen, and values for what the run does with it, each made anew where that
// begins. All of it is in a checkpoint.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "core/dem/packing.h"
#include "core/dem/specimen.h"

namespace creep {

/// What packing ended with. Made once; a run that starts from a checkpoint takes it over.
struct Packed {
  std::int64_t count = 0;  ///< of particles
  double void_ratio = 0.0;
  double grading_index = 0.0;
  double generation_friction = 0.0;
};

/// What the walls hold, from stage to stage.
struct Aim {
  enum class Sides : std::uint8_t { kFixed, kHeld };
  Sides sides = Sides::kFixed;  ///< side walls: fixed, or holding `radial`
  double axial = 0.0;           ///< axial stress asked for, or reached by the last stage [Pa]
  double radial = 0.0;          ///< [Pa]
};

/// The largest deviatoric stress of the samples of triaxial loading.
struct Peak {
  double deviatoric_stress = 0.0;  ///< [Pa]
  double axial_strain = 0.0;       ///< then
};

/// Where a row of stages.csv begins.
struct StageStart {
  double creep_time = 0.0;           ///< [s]; 0 for loading
  double suspended_time = 0.0;       ///< [s]
  std::int64_t broken_at_start = 0;  ///< by the ageing jump that opened it
  std::int64_t broken_before = 0;    ///< broken_total, the jump's included
};

/// How far a loading or dynamic stage has come to rest. Cycles count from its beginning.
struct Calm {
  std::int64_t cycle = 0;
  std::int64_t quiet_since = 0;           ///< cycle from which stress is on target without a failure
  std::optional<std::int64_t> on_target;  ///< cycle in which all walls first were
};

struct Loading {
  StageStart start;
  Calm calm;
  double begun_at = 0.0;              ///< value of the measure that ends it
  std::optional<double> next_sample;  ///< axial stress or strain at which it gives one
  std::int64_t kept = 0;              ///< multiples of the step of `keep` passed
};

/// What a dynamic stage knows of the failure times to come.
struct Drift {
  std::int64_t cycle = 0;        ///< of the stage, in which it last looked
  double end_of_ageing = 0.0;    ///< ln of the end of the next ageing then
  std::optional<double> change;  ///< of it over the last window
};

struct DynamicStage {
  StageStart start;
  Calm calm;
  bool closing = false;  ///< the last of its hold
  double ripple = 0.0;   ///< largest |stress / target - 1| so far
  std::optional<Drift> drift;
  std::optional<double> strain_half_way;  ///< axial, at half the cycles it may take to settle
};

/// The specimen where a hold began: every figure "before creep".
struct HoldStart {
  double age = 0.0;  ///< [s]
  double axial_strain = 0.0;
  double axial_stress = 0.0;  ///< [Pa]
  double void_ratio = 0.0;
  std::int64_t broken_total = 0;
};

/// What the last ageing jump promised, to learn from.
struct Promise {
  double aged_from = 0.0;  ///< creep_time before it [s]
  double promised = 0.0;   ///< until as many failures again [s]
};

/// A hold so far: dynamic stages and ageing jumps in turn.
struct Hold {
  /// The first decade that a snapshot waits for [s].
  static constexpr double kFirstSnapshotAge = 1.0;
  HoldStart start;
  std::int64_t ageing_jumps = 0;                 ///< the number, from 0, of its present dynamic stage
  std::int64_t dynamic_stages = 0;               ///< finished
  double largest_ripple = 0.0;                   ///< its initial dynamic stage left out
  double next_snapshot_age = kFirstSnapshotAge;  ///< age since its start that the next snapshot waits for [s]
  std::int64_t breakages = 0;                    ///< n_age of the next jump, if it adapts
  std::optional<Promise> promise;                ///< of the last jump, if it adapts
};

/// Before the program begins with the specimen of a checkpoint.
struct Starting {};
/// Between a dynamic stage and the next: laboratory time passes.
struct Ageing {};
/// A stage has ended and another follows.
struct Between {
  bool after_hold = false;
};
/// The program is carried out.
struct Done {
  bool after_hold = false;
};

/// What the run does now; with it begins and ends what that needs to remember.
using Act = std::variant<PackingState, Starting, Loading, DynamicStage, Ageing, Between, Done>;

struct RunState {
  Specimen specimen;
  Act act;
  std::optional<Packed> packed;  ///< none while packing
  Aim aim;
  Peak peak;
  std::optional<Hold> hold;  ///< the present one, or the last
  std::int64_t stage = -1;   ///< place in the program; -1 before it
  std::int64_t curves = 0;   ///< grading curves recorded
  std::uint64_t next_sequence = 0;
  bool inexact = false;
  std::string start_digest;  ///< state digest of the checkpoint that the run was started from; "" if packed
};

/// Whether the present stage, or the last one if it has ended, is a hold.
bool in_hold(const Act& act);

/// Number of the present dynamic stage in its hold, from 0; 0 outside a hold.
std::int64_t dynamic_stage_number(const RunState& state);

/// SHA-256 of the id-ordered physical state.
std::string digest_of(const RunState& state);

}  // namespace creep
