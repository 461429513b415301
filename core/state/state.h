// The state of a run: the specimen and the cursor over the program. All of it is in a checkpoint.
#pragma once

#include <cstdint>
#include <string>

#include "core/dem/packing.h"
#include "core/dem/specimen.h"
#include "core/experiment/experiment.h"

namespace creep {

/// Where in the program a run stands, and what its records and summary need of the past.
struct Cursor {
  /// The first decade that a snapshot waits for [s].
  static constexpr double kFirstSnapshotAge = 1.0;
  enum class Act : std::uint8_t { kPacking, kLoading, kDynamicStage, kAgeing, kDone, kStart, kBetweenStages };
  static constexpr Act kLastAct = Act::kBetweenStages;
  enum class Sides : std::uint8_t { kFixed, kHeld };
  Act act = Act::kPacking;
  std::int64_t stage = -1;           ///< place in the program
  std::int64_t dynamic_stage = 0;    ///< number in the present hold, from 0
  bool closing = false;              ///< the present dynamic stage is the last of its hold
  double target = 0.0;               ///< axial stress of the present stage, or reached by the last [Pa]
  double sample_at = 0.0;            ///< axial stress or strain at which loading gives its next sample
  std::int64_t stage_cycle = 0;      ///< cycles of the present loading or dynamic stage
  std::int64_t quiet_since = 0;      ///< stage_cycle from which stress is on target without a failure
  double ripple = 0.0;               ///< of the present dynamic stage
  double creep_time_start = 0.0;     ///< of the present dynamic stage [s]
  double suspended_start = 0.0;      ///< suspended_time when it began [s]
  std::int64_t broken_at_start = 0;  ///< by the jump that opened it
  std::int64_t broken_before = 0;    ///< broken_total when it began, the jump's included
  std::int64_t curves = 0;           ///< grading curves recorded
  std::int64_t initial_count = 0;    ///< particles at the end of packing
  std::int64_t ageing_jumps = 0;     ///< in the present hold
  std::int64_t dynamic_stages = 0;   ///< finished in the present hold
  double void_ratio_reached = 0.0;   ///< at the end of packing
  double void_ratio_loaded = 0.0;    ///< at the end of the last loading stage
  double strain_loaded = 0.0;        ///< axial strain when the present hold began
  double initial_grading_index = 0.0;
  double largest_ripple = 0.0;     ///< of the present hold, its initial dynamic stage left out
  std::int64_t broken_loaded = 0;  ///< broken_total when the present hold began
  double age_loaded = 0.0;         ///< age when the present hold began [s]
  /// Age since then that the next snapshot waits for [s].
  double next_snapshot_age = kFirstSnapshotAge;
  Sides sides = Sides::kFixed;          ///< side walls: fixed, or holding radial_target
  double radial_target = 0.0;           ///< [Pa]
  bool holding = false;                 ///< the present stage, or the last one if all are done, is a hold
  double stress_loaded = 0.0;           ///< axial stress when the present hold began [Pa]
  double strain_half_way = 0.0;         ///< axial strain at half the cycles a stage may take to settle
  std::int64_t reached_cycle = -1;      ///< stage_cycle in which all walls first were on target; -1: not yet
  double loading_start = 0.0;           ///< of the measure that ends the present loading stage
  double peak_deviatoric_stress = 0.0;  ///< largest of a sample of triaxial loading [Pa]
  double strain_at_peak = 0.0;          ///< axial
  std::int64_t kept = 0;                ///< multiples of the step of `keep` passed in the present stage
  std::int64_t drift_cycle = 0;         ///< stage_cycle in which drift was last looked at; 0: not yet
  double drift_reference = 0.0;         ///< ln of the end of the next ageing then
  double drift = 0.0;                   ///< change of it over the last window; negative: no window yet
  std::int64_t breakages = 0;           ///< n_age of the next jump, if it adapts
  double promised = 0.0;                ///< by the last jump for as many failures again [s]
  double aged_from = 0.0;               ///< creep_time before the last jump [s]; 0: none to learn from
};

struct RunState {
  Specimen specimen;
  PackingState packing;
  Cursor cursor;
  std::uint64_t next_sequence = 0;
  bool inexact = false;
  std::string start_digest;  ///< state digest of the checkpoint that the run was started from; "" if packed
};

/// SHA-256 of the id-ordered physical state.
std::string digest_of(const RunState& state);

}  // namespace creep
