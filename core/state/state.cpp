#include "core/state/state.h"

namespace creep {

bool in_hold(const Act& act) {
  struct {
    bool operator()(const PackingState&) const { return false; }
    bool operator()(const Starting&) const { return false; }
    bool operator()(const Loading&) const { return false; }
    bool operator()(const DynamicStage&) const { return true; }
    bool operator()(const Ageing&) const { return true; }
    bool operator()(const Between& between) const { return between.after_hold; }
    bool operator()(const Done& done) const { return done.after_hold; }
  } const is_hold;
  return std::visit(is_hold, act);
}

std::int64_t dynamic_stage_number(const RunState& state) {
  return in_hold(state.act) && state.hold ? state.hold->ageing_jumps : 0;
}

}  // namespace creep
