#include "core/output/samples.h"

#include <algorithm>
#include <cmath>

#include "core/arithmetic/elementary.h"
#include "core/dem/measures.h"
#include "core/experiment/fidelity.h"
#include "core/physics/grading.h"

namespace creep {
namespace {

double as_double(std::int64_t count) { return static_cast<double>(count); }

struct EnergyBalance {
  double normal, tangential, friction, damping, kinetic, removed, residual, unexplained;
};

EnergyBalance energy_balance(const Specimen& specimen, const ContactModel& model) {
  const EnergyLedger& ledger = specimen.energy;
  const ElasticEnergy elastic = elastic_energy(specimen, model);
  EnergyBalance balance{};
  balance.normal = elastic.normal;
  balance.tangential = elastic.tangential;
  balance.friction = ledger.friction.value();
  balance.damping = ledger.damping.value();
  balance.kinetic = kinetic_energy(specimen);
  balance.removed = ledger.removed_normal + ledger.removed_tangential + ledger.removed_kinetic;
  const double stored_tangential = elastic.tangential - ledger.initial_tangential;
  balance.residual =
      ledger.tangential_work.value() - balance.friction - stored_tangential - ledger.removed_tangential;
  balance.unexplained = ledger.wall_work - (elastic.normal + balance.kinetic - ledger.initial_stored) -
                        (stored_tangential + balance.friction + balance.residual) - balance.damping -
                        balance.removed;
  return balance;
}

/// Diameters at which grading curves are given: equal steps of ln d from d_min past the coarsest grain.
std::vector<double> curve_diameters(const Experiment& experiment) {
  constexpr int kPoints = 81;
  const double low = elementary::log(experiment.material.grading_index_min_diameter);
  const double high = elementary::log(1.05 * coarsest_diameter(experiment.specimen.grading));
  std::vector<double> diameters(kPoints);
  for (int k = 0; k < kPoints; ++k) {
    diameters[static_cast<std::size_t>(k)] = elementary::exp(low + (high - low) * k / (kPoints - 1));
  }
  return diameters;
}

struct RelativeBreakage {
  double hardin, einav;
};

/// Against the grading of the packed specimen, which is known from the experiment, whatever the run started
/// from. Einav's ultimate grading is fractal up to the coarsest grain.
RelativeBreakage relative_breakage(const RunState& state, const Experiment& experiment) {
  if (!state.packed) return {0.0, 0.0};
  const Material& material = experiment.material;
  const std::vector<double> diameters = curve_diameters(experiment);
  const std::vector<double> grains = stratified_diameters(experiment.specimen.grading, state.packed->count);
  double all = 0.0;
  for (const double d : grains) all += d * d * d;
  std::vector<double> initial(diameters.size(), 0.0), ultimate;
  for (std::size_t k = 0; k < diameters.size(); ++k) {
    for (const double d : grains) {
      if (d <= diameters[k]) initial[k] += d * d * d / all;
    }
    ultimate.push_back(fractal_passing(diameters[k], grains.back(), material.grading_index_min_diameter,
                                       3.0 - material.fractal_dimension));
  }
  const std::vector<double> current = passing(state.specimen, material, diameters);
  return {breakage_hardin(diameters, initial, current),
          breakage_einav(diameters, initial, current, ultimate)};
}

double mass_unexplained(const Specimen& specimen) {
  return (particle_mass(specimen) + fines_mass(specimen)) / specimen.initial_mass - 1.0;
}

}  // namespace

double creep_time(const RunState& state) {
  return in_hold(state.act) ? state.specimen.clocks.creep_time() : 0.0;
}

std::vector<double> sample_values(const RunState& state, const Experiment& experiment,
                                  const ContactModel& model, Phase phase) {
  const Specimen& s = state.specimen;
  const bool packing = phase == Phase::kPacking;
  const VoidRatio e = void_ratio(s, experiment.material.density);
  const ContactStress love_weber = contact_stress(s, model);
  const Coordination z = coordination(s, model);
  const EnergyBalance energy = energy_balance(s, model);
  return {as_double(state.stage),
          as_double(static_cast<std::int64_t>(phase)),
          as_double(dynamic_stage_number(state)),
          as_double(s.cycle),
          s.clocks.age,
          s.clocks.dynamic_time,
          creep_time(state),
          axial_strain(s),
          volumetric_strain(s),
          s.walls.stress(2),
          radial_stress(s.walls),
          love_weber.axial,
          love_weber.radial,
          e.with_fines,
          e.of_particles,
          grading_index(s, experiment.material),
          as_double(s.broken_total),
          as_double(static_cast<std::int64_t>(s.particles.size())),
          z.all,
          z.without_rattlers,
          s.unbalanced_force_ratio,
          inertial_number(s, experiment),
          s.time_step,
          s.friction,
          s.energy.wall_work,
          energy.normal,
          energy.tangential,
          energy.friction,
          energy.damping,
          energy.kinetic,
          energy.removed,
          packing ? 0.0 : energy.residual,
          packing ? 0.0 : energy.unexplained,
          mass_unexplained(s),
          value_of(Target::Measure::kMeanStress, s),
          value_of(Target::Measure::kDeviatoricStress, s)};
}

namespace {

struct StageRow {
  double number, ripple;
  const StageStart& start;
  const Calm& calm;
  bool settled;
};

std::vector<double> stage_row(const RunState& state, const StageRow& row, const Experiment& experiment) {
  const Specimen& s = state.specimen;
  return {row.number,
          as_double(state.stage),
          as_double(row.calm.cycle),
          row.start.creep_time,
          creep_time(state),
          s.clocks.age,
          s.clocks.dynamic_time,
          s.clocks.suspended_time - row.start.suspended_time,
          axial_strain(s),
          void_ratio(s, experiment.material.density).with_fines,
          s.walls.stress(2),
          grading_index(s, experiment.material),
          row.ripple,
          as_double(row.start.broken_at_start),
          as_double(s.broken_total - row.start.broken_before),
          s.unbalanced_force_ratio,
          s.time_step,
          as_double(static_cast<std::int64_t>(s.particles.size())),
          row.settled ? 1.0 : 0.0};
}

}  // namespace

std::vector<double> stage_values(const RunState& state, const Loading& loading, bool settled,
                                 const Experiment& experiment) {
  return stage_row(state, {-1.0, 0.0, loading.start, loading.calm, settled}, experiment);
}

std::vector<double> stage_values(const RunState& state, const DynamicStage& stage, bool settled,
                                 const Experiment& experiment) {
  const double number = as_double(dynamic_stage_number(state));
  return stage_row(state, {number, stage.ripple, stage.start, stage.calm, settled}, experiment);
}

std::vector<double> breakage_values(const RunState& state, const Failure& failure) {
  const Specimen& s = state.specimen;
  const auto i = static_cast<std::size_t>(failure.index);
  const Body& body = s.particles.body[i];
  return {static_cast<double>(s.particles.id[i]),
          as_double(static_cast<std::int64_t>(failure.cause)),
          as_double(dynamic_stage_number(state)),
          as_double(s.cycle),
          s.clocks.age,
          s.clocks.dynamic_time,
          creep_time(state),
          2.0 * body.radius,
          static_cast<double>(s.particles.generation[i]),
          body.x,
          body.y,
          body.z,
          failure.stress_ratio,
          s.particles.crack[i] / body.radius};
}

std::vector<std::vector<double>> grading_values(const RunState& state, const Experiment& experiment) {
  const std::vector<double> diameters = curve_diameters(experiment);
  const std::vector<double> finer = passing(state.specimen, experiment.material, diameters);
  std::vector<std::vector<double>> rows;
  for (std::size_t k = 0; k < diameters.size(); ++k) {
    rows.push_back({as_double(state.curves), creep_time(state), diameters[k], finer[k]});
  }
  return rows;
}

std::vector<SummaryFigure> summary_figures(const RunState& state, const Experiment& experiment,
                                           const ContactModel& model) {
  const Specimen& s = state.specimen;
  const Packed packed = state.packed.value_or(Packed{});
  const Hold hold = state.hold.value_or(Hold{});
  const VoidRatio e = void_ratio(s, experiment.material.density);
  const EnergyBalance energy = energy_balance(s, model);
  const RelativeBreakage breakage = relative_breakage(state, experiment);
  const std::int64_t breakages = experiment.numerics.ageing_error_tolerance
                                     ? hold.breakages
                                     : breakages_per_ageing(experiment.numerics, packed.count);
  return {{"void_ratio_target", experiment.specimen.void_ratio},
          {"void_ratio_reached", packed.void_ratio},
          {"generation_friction", packed.generation_friction},
          {"side_m", s.initial_height},
          {"initial_particles", as_double(packed.count)},
          {"void_ratio_before_creep", state.hold ? hold.start.void_ratio : e.with_fines},
          {"void_ratio", e.with_fines},
          {"void_ratio_particles", e.of_particles},
          {"axial_stress_Pa", s.walls.stress(2)},
          {"radial_stress_Pa", radial_stress(s.walls)},
          {"axial_strain", axial_strain(s)},
          {"axial_creep_strain", in_hold(state.act) ? axial_strain(s) - hold.start.axial_strain : 0.0},
          {"creep_time_s", creep_time(state)},
          {"age_s", s.clocks.age},
          {"dynamic_time_s", s.clocks.dynamic_time},
          {"suspended_time_s", s.clocks.suspended_time},
          {"dynamic_stages", as_double(hold.dynamic_stages)},
          {"ageing_jumps", as_double(hold.ageing_jumps)},
          {"breakages_per_ageing", as_double(breakages)},
          {"largest_ripple", hold.largest_ripple},
          {"grading_index_initial", packed.grading_index},
          {"grading_index", grading_index(s, experiment.material)},
          {"broken_before_creep", as_double(hold.start.broken_total)},
          {"broken_total", as_double(s.broken_total)},
          {"particles", as_double(static_cast<std::int64_t>(s.particles.size()))},
          {"cycles", as_double(s.cycle)},
          {"wall_work_J", s.energy.wall_work},
          {"energy_unexplained_J", energy.unexplained},
          {"mass_unexplained", mass_unexplained(s)},
          {"volumetric_strain", volumetric_strain(s)},
          {"mean_stress_Pa", value_of(Target::Measure::kMeanStress, s)},
          {"deviatoric_stress_Pa", value_of(Target::Measure::kDeviatoricStress, s)},
          {"peak_deviatoric_stress_Pa", state.peak.deviatoric_stress},
          {"axial_strain_at_peak", state.peak.axial_strain},
          {"axial_stress_before_hold_Pa", hold.start.axial_stress},
          {"breakage_hardin", breakage.hardin},
          {"breakage_einav", breakage.einav}};
}

}  // namespace creep
