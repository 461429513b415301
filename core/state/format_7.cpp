#include "core/state/format_7.h"

#include <optional>

#include "core/state/layout.h"

namespace creep {
namespace {

struct OldCursor {
  enum class Act : std::uint8_t { kPacking, kLoading, kDynamicStage, kAgeing, kDone, kStart, kBetweenStages };
  Act act = Act::kPacking;
  std::int64_t stage = -1;
  std::int64_t dynamic_stage = 0;
  bool closing = false;
  double target = 0.0, sample_at = 0.0;
  std::int64_t stage_cycle = 0, quiet_since = 0;
  double ripple = 0.0, creep_time_start = 0.0, suspended_start = 0.0;
  std::int64_t broken_at_start = 0, broken_before = 0, curves = 0, initial_count = 0, ageing_jumps = 0,
               dynamic_stages = 0;
  double void_ratio_reached = 0.0, void_ratio_loaded = 0.0, strain_loaded = 0.0, initial_grading_index = 0.0,
         largest_ripple = 0.0;
  std::int64_t broken_loaded = 0;
  double age_loaded = 0.0, next_snapshot_age = Hold::kFirstSnapshotAge;
  Aim::Sides sides = Aim::Sides::kFixed;
  double radial_target = 0.0;
  bool holding = false;
  double stress_loaded = 0.0, strain_half_way = 0.0;
  std::int64_t reached_cycle = -1;
  double loading_start = 0.0, peak_deviatoric_stress = 0.0, strain_at_peak = 0.0;
  std::int64_t kept = 0, drift_cycle = 0;
  double drift_reference = 0.0, drift = 0.0;
  std::int64_t breakages = 0;
  double promised = 0.0, aged_from = 0.0;
};

void read_cursor(Reader& archive, OldCursor& cursor, std::uint64_t version) {
  archive(cursor.act);
  archive(cursor.stage);
  archive(cursor.dynamic_stage);
  archive(cursor.closing);
  archive(cursor.target);
  archive(cursor.sample_at);
  archive(cursor.stage_cycle);
  archive(cursor.quiet_since);
  archive(cursor.ripple);
  archive(cursor.creep_time_start);
  archive(cursor.suspended_start);
  archive(cursor.broken_at_start);
  archive(cursor.broken_before);
  archive(cursor.curves);
  archive(cursor.initial_count);
  archive(cursor.ageing_jumps);
  archive(cursor.dynamic_stages);
  archive(cursor.void_ratio_reached);
  archive(cursor.void_ratio_loaded);
  archive(cursor.strain_loaded);
  archive(cursor.initial_grading_index);
  archive(cursor.largest_ripple);
  archive(cursor.broken_loaded);
  if (version < 2) return;
  archive(cursor.age_loaded);
  archive(cursor.next_snapshot_age);
  if (version < 3) return;
  archive(cursor.sides);
  archive(cursor.radial_target);
  archive(cursor.holding);
  archive(cursor.stress_loaded);
  archive(cursor.strain_half_way);
  archive(cursor.reached_cycle);
  archive(cursor.loading_start);
  archive(cursor.peak_deviatoric_stress);
  archive(cursor.strain_at_peak);
  archive(cursor.kept);
  if (version < 6) return;
  archive(cursor.drift_cycle);
  archive(cursor.drift_reference);
  archive(cursor.drift);
  archive(cursor.breakages);
  archive(cursor.promised);
  archive(cursor.aged_from);
}

Calm calm_of(const OldCursor& cursor) {
  Calm calm{cursor.stage_cycle, cursor.quiet_since, {}};
  if (cursor.reached_cycle >= 0) calm.on_target = cursor.reached_cycle;
  return calm;
}

StageStart start_of(const OldCursor& cursor) {
  return {cursor.creep_time_start, cursor.suspended_start, cursor.broken_at_start, cursor.broken_before};
}

Loading loading_of(const OldCursor& cursor) {
  Loading loading{start_of(cursor), calm_of(cursor), cursor.loading_start, {}, cursor.kept};
  if (cursor.sample_at != 0.0) loading.next_sample = cursor.sample_at;
  return loading;
}

DynamicStage dynamic_stage_of(const OldCursor& cursor) {
  DynamicStage stage{start_of(cursor),      calm_of(cursor), cursor.closing, cursor.ripple, {},
                     cursor.strain_half_way};
  if (cursor.drift_cycle > 0) {
    stage.drift = Drift{cursor.drift_cycle, cursor.drift_reference, {}};
    if (cursor.drift >= 0.0) stage.drift->change = cursor.drift;
  }
  return stage;
}

/// The void ratio is that of the end of the last loading stage: these formats knew no other.
Hold hold_of(const OldCursor& cursor) {
  Hold hold;
  hold.start = {cursor.age_loaded, cursor.strain_loaded, cursor.stress_loaded, cursor.void_ratio_loaded,
                cursor.broken_loaded};
  hold.ageing_jumps = cursor.ageing_jumps;
  hold.dynamic_stages = cursor.dynamic_stages;
  hold.largest_ripple = cursor.largest_ripple;
  hold.next_snapshot_age = cursor.next_snapshot_age;
  hold.breakages = cursor.breakages;
  if (cursor.aged_from > 0.0) hold.promise = Promise{cursor.aged_from, cursor.promised};
  return hold;
}

std::optional<Act> act_of(const OldCursor& cursor, const PackingState& packing, bool holding) {
  switch (cursor.act) {
    case OldCursor::Act::kPacking:
      return packing;
    case OldCursor::Act::kStart:
      return Starting{};
    case OldCursor::Act::kLoading:
      return loading_of(cursor);
    case OldCursor::Act::kDynamicStage:
      return dynamic_stage_of(cursor);
    case OldCursor::Act::kAgeing:
      return Ageing{};
    case OldCursor::Act::kBetweenStages:
      return Between{holding};
    case OldCursor::Act::kDone:
      return Done{holding};
  }
  return std::nullopt;
}

}  // namespace

bool read_format_7(Reader& reader, std::uint64_t version, RunState& state) {
  PackingState packing;
  OldCursor cursor;
  visit_packing(reader, packing);
  read_cursor(reader, cursor, version);
  const bool in_stage_of_hold =
      cursor.act == OldCursor::Act::kDynamicStage || cursor.act == OldCursor::Act::kAgeing;
  const bool holding = version < 3 ? in_stage_of_hold : cursor.holding;
  const std::optional<Act> act = act_of(cursor, packing, holding);
  if (!act) return false;
  state.act = *act;
  if (cursor.act != OldCursor::Act::kPacking) {
    state.packed = Packed{cursor.initial_count, cursor.void_ratio_reached, cursor.initial_grading_index,
                          packing.generation_friction};
  }
  state.aim = {cursor.sides, cursor.target, cursor.radial_target};
  state.peak = {cursor.peak_deviatoric_stress, cursor.strain_at_peak};
  if (holding || cursor.dynamic_stages > 0) state.hold = hold_of(cursor);
  state.stage = cursor.stage;
  state.curves = cursor.curves;
  return true;
}

}  // namespace creep
