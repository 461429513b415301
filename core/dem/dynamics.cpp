#include "core/dem/dynamics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/arithmetic/check.h"
#include "core/arithmetic/elementary.h"
#include "core/dem/rotation.h"
#include "core/physics/crack.h"

namespace creep {
namespace {

/// Cracks slower than this [m/s] would take 10^8 years through the smallest grain that can fail.
constexpr double kLeastCrackVelocity = 1e-20;

/// Bodies and resultants beyond this [bytes] come from memory in every cycle, not from a cache.
constexpr std::size_t kCached = 8 << 20;

double largest_wall_displacement(const Specimen& specimen) {
  double largest = 0.0;
  for (std::size_t w = 0; w < 6; ++w) {
    largest = std::max(largest, std::fabs(specimen.walls.position[w] - specimen.contacts.wall_reference[w]));
  }
  return largest;
}

}  // namespace

Dynamics::Dynamics(const Experiment& experiment, const Kernels& kernels, Options options)
    : experiment_(experiment),
      kernels_(kernels),
      options_(options),
      model_(experiment.material),
      search_(experiment.numerics.skin.value_or(0.01 * median_diameter(experiment.specimen.grading))),
      team_(options.threads),
      median_diameter_(median_diameter(experiment.specimen.grading)),
      crushable_(experiment.material.comminution_limit < std::numeric_limits<double>::infinity()),
      least_growing_ratio_(experiment.material.crack_velocity > 0.0
                               ? elementary::pow(kLeastCrackVelocity / experiment.material.crack_velocity,
                                                 1.0 / experiment.material.corrosion_index)
                               : 2.0) {
  of_member_.resize(static_cast<std::size_t>(team_.size()));
  grown_through_.resize(static_cast<std::size_t>(team_.size()));
}

double Dynamics::stable_step(double largest_stiffness_over_mass) const {
  // safety sqrt2 min sqrt(m / lambda_max(sum K_c)), with lambda_max bounded by the sum of normal stiffnesses:
  // 7 % too stiff for quartz in an isotropic environment, exact for the fragments with one contact that
  // decide the step. Where particles turn, a tangential spring moves them and turns them: its stiffness
  // counts (1/m + r^2/I) m = 3.5 times.
  const double softest =
      experiment_.material.free_rotation ? std::max(1.0, 3.5 * model_.tangential_ratio) : 1.0;
  return experiment_.numerics.time_step_safety * std::sqrt(2.0 / (softest * largest_stiffness_over_mass));
}

void Dynamics::ensure_list(Specimen& specimen) {
  if (specimen.contacts.valid) return;
  const Doing searching(options_.activity, Activity::kSearch);
  search_.search(specimen, team_, nullptr);
}

void Dynamics::relist(Specimen& specimen, const std::vector<std::int32_t>& new_index) {
  const Doing searching(options_.activity, Activity::kSearch);
  search_.search(specimen, team_, &new_index);
}

Dynamics::Sums Dynamics::compute(Specimen& specimen, CycleKind kind, double kick, double drift,
                                 CycleResult& result) {
  Contacts& contacts = specimen.contacts;
  Particles& particles = specimen.particles;
  ContactPhase contact_phase;
  contact_phase.body = particles.body.data();
  contact_phase.first = contacts.first.data();
  contact_phase.second = contacts.second.data();
  contact_phase.root_radius = contacts.root_radius.data();
  contact_phase.shear_x = contacts.shear_x.data();
  contact_phase.shear_y = contacts.shear_y.data();
  contact_phase.shear_z = contacts.shear_z.data();
  contact_phase.force = contacts.force.data();
  contact_phase.resultant = contacts.resultant.data();
  contact_phase.deferred = contacts.deferred.data();
  contact_phase.stress = contacts.stress.data();
  contact_phase.peak_stress = contacts.peak_stress.data();
  if (experiment_.material.free_rotation) {
    contacts.couple.resize(contacts.force.size());
    contact_phase.spin = particles.spin.data();
    contact_phase.couple = contacts.couple.data();
  }
  contact_phase.law = model_.view();
  contact_phase.modulus = model_.modulus;
  contact_phase.tangential_ratio = model_.tangential_ratio;
  contact_phase.friction = specimen.friction;
  contact_phase.drift = kind.move ? specimen.last_time_step : 0.0;
  contact_phase.ask_ahead = particles.size() * (sizeof(Body) + sizeof(ContactForce)) > kCached;
  of_member_.assign(of_member_.size(), Sums{});
  std::optional<Doing> doing;
  doing.emplace(options_.activity, Activity::kContacts);
  team_.run([&](int member) {
    const Share share = team_.share(contacts.count, member, kKernelGrain);
    kernels_.contacts(contact_phase, kind, share.begin, share.end,
                      of_member_[static_cast<std::size_t>(member)].contacts);
  });
  doing.reset();
  if (kind.check) {
    const Doing checking(options_.activity, Activity::kChecks);
    bool breaking = false;
    for (const Sums& sums : of_member_) breaking = breaking || sums.contacts.breaking;
    if (breaking) find_failures_in_contacts(specimen, result.failures);
  }

  ParticlePhase phase;
  phase.body = particles.body.data();
  phase.force = contacts.force.data();
  phase.resultant = contacts.resultant.data();
  phase.shared = contacts.shared.data();
  phase.stress = contacts.stress.data();
  phase.peak_stress = contacts.peak_stress.data();
  phase.own_begin = contacts.own_begin.data();
  phase.lower_begin = contacts.lower_begin.data();
  phase.lower_contact = contacts.lower_contact.data();
  phase.near_walls = contacts.near_walls.data();
  phase.special = contacts.special.data();
  phase.special_count = contacts.special.size();
  phase.reference = contacts.reference.data();
  phase.inertial_mass = particles.inertial_mass.data();
  phase.mobilised_stress = particles.mobilised_stress.data();
  if (kind.check) {
    breaking_at_walls_.resize(particles.size());
    phase.breaking = breaking_at_walls_.data();
  }
  std::copy(specimen.walls.position.begin(), specimen.walls.position.end(), phase.wall_position);
  if (!particles.wall_shear.empty()) {
    phase.wall_shear = particles.wall_shear.data();
    phase.spin = contact_phase.spin;
  }
  phase.law = contact_phase.law;
  phase.wall_friction = experiment_.material.wall_friction;
  phase.tangential_ratio = contact_phase.tangential_ratio;
  phase.last_drift = contact_phase.drift;
  phase.wall_modulus = model_.wall_modulus;
  phase.local_damping = experiment_.numerics.local_damping;
  phase.kick = kick;
  phase.drift = drift;
  if (kind.measure) {
    const double overlap = std::max(specimen.mean_overlap, model_.least_overlap);
    phase.floor_stiffness = model_.modulus * std::sqrt(0.5) * model_.law.slope(overlap);
  }
  CREEP_CHECK(contacts.particle_shares.size() == of_member_.size() + 1,
              "the list is of a team of another size");
  doing.emplace(options_.activity, Activity::kParticles);
  team_.run([&](int member) {
    const auto m = static_cast<std::size_t>(member);
    kernels_.particles(phase, kind, contacts.particle_shares[m], contacts.particle_shares[m + 1],
                       of_member_[m].particles);
  });

  doing.reset();

  Sums total = of_member_[0];
  for (std::size_t m = 1; m < of_member_.size(); ++m) {
    const ContactSums& c = of_member_[m].contacts;
    total.contacts.tangential_work += c.tangential_work;
    total.contacts.friction += c.friction;
    total.contacts.force += c.force;
    total.contacts.overlap += c.overlap;
    total.contacts.touching += c.touching;
    total.contacts.largest_overlap_ratio =
        std::max(total.contacts.largest_overlap_ratio, c.largest_overlap_ratio);
    const ParticleSums& p = of_member_[m].particles;
    for (std::size_t w = 0; w < 6; ++w) {
      total.particles.wall_force[w] += p.wall_force[w];
      total.particles.wall_stiffness[w] += p.wall_stiffness[w];
    }
    total.particles.tangential_work += p.tangential_work;
    total.particles.friction += p.friction;
    total.particles.damping += p.damping;
    total.particles.list_ends = total.particles.list_ends || p.list_ends;
    total.particles.resultant += p.resultant;
    total.particles.with_contacts += p.with_contacts;
    total.particles.largest_stiffness_over_mass =
        std::max(total.particles.largest_stiffness_over_mass, p.largest_stiffness_over_mass);
    total.particles.finite = total.particles.finite && p.finite;
    total.particles.breaking = total.particles.breaking || p.breaking;
  }
  return total;
}

void Dynamics::turn_particles(Specimen& specimen, double kick) {
  std::vector<FixedSum> work(of_member_.size(), FixedSum(kEnergyQuantum));
  team_.run([&](int member) {
    const Share share = team_.share(specimen.particles.size(), member);
    work[static_cast<std::size_t>(member)] =
        turn(specimen, experiment_.numerics.local_damping, kick, share.begin, share.end);
  });
  for (const FixedSum& share : work) specimen.energy.damping.merge(share);
}

void Dynamics::book(Specimen& specimen, const Sums& sums, CycleKind kind) const {
  EnergyLedger& energy = specimen.energy;
  energy.tangential_work.add_quanta(sums.contacts.tangential_work + sums.particles.tangential_work);
  energy.friction.add_quanta(sums.contacts.friction + sums.particles.friction);
  energy.damping.add_quanta(sums.particles.damping);
  Walls& walls = specimen.walls;
  for (std::size_t w = 0; w < 6; ++w) {
    const double force = static_cast<double>(sums.particles.wall_force[w]) * std::ldexp(1.0, kForceQuantum);
    if (kind.move) {
      // Work over the last drift by the mean of the forces at its ends: exact for kick-drift at a constant
      // step.
      const double inward = (w % 2 == 0 ? walls.velocity[w] : -walls.velocity[w]) * specimen.last_time_step;
      energy.wall_work += 0.5 * (walls.force[w] + force) * inward;
    }
    walls.force[w] = force;
    walls.stiffness[w] =
        static_cast<double>(sums.particles.wall_stiffness[w]) * std::ldexp(1.0, kStiffnessQuantum);
  }
  if (!kind.measure) return;
  const auto touching = static_cast<double>(sums.contacts.touching);
  specimen.mean_overlap =
      touching > 0.0 ? static_cast<double>(sums.contacts.overlap) * std::ldexp(1.0, kLengthQuantum) / touching
                     : 0.0;
  const double mean_force = touching > 0.0 ? static_cast<double>(sums.contacts.force) / touching : 0.0;
  specimen.unbalanced_force_ratio = mean_force > 0.0
                                        ? static_cast<double>(sums.particles.resultant) /
                                              static_cast<double>(sums.particles.with_contacts) / mean_force
                                        : 1.0;
}

void Dynamics::move_walls(Specimen& specimen, const WallControl& control, double drift) const {
  steer(specimen.walls, control, specimen.initial_mass, median_diameter_, drift);
  for (std::size_t w = 0; w < 6; ++w) specimen.walls.position[w] += specimen.walls.velocity[w] * drift;
}

void Dynamics::advance_clocks(Specimen& specimen, double drift) const {
  if (experiment_.numerics.inertia_scaling == InertiaScaling::kNone) {
    specimen.clocks.dynamic_time += drift;
    specimen.crack_time += drift;
  } else {
    specimen.clocks.suspended_time += drift;
  }
}

void Dynamics::grow_cracks(Specimen& specimen, CycleResult& result) {
  const Doing checking(options_.activity, Activity::kChecks);
  Particles& particles = specimen.particles;
  const double elapsed = specimen.crack_time;
  specimen.crack_time = 0.0;
  if (elapsed == 0.0 || !crushable_ || experiment_.material.crack_velocity == 0.0) return;
  team_.run([&](int member) {
    std::vector<Failure>& failed = grown_through_[static_cast<std::size_t>(member)];
    failed.clear();
    const Share share = team_.share(particles.size(), member);
    for (std::size_t i = share.begin; i < share.end; ++i) {
      const Body& body = particles.body[i];
      if (particles.mobilised_stress[i] < least_growing_ratio_ * particles.limit_stress[i]) continue;
      if (body.breaking_stress == std::numeric_limits<double>::infinity()) continue;
      const double ratio = particles.mobilised_stress[i] / particles.limit_stress[i];
      particles.crack[i] += crack_velocity(experiment_.material, ratio) * elapsed;
      if (particles.crack[i] >= body.radius) {
        failed.push_back({static_cast<std::int32_t>(i), FailureCause::kCrackInDynamicStage, ratio});
      }
    }
  });
  for (const auto& failed : grown_through_)
    result.failures.insert(result.failures.end(), failed.begin(), failed.end());
}

void Dynamics::find_failures_in_contacts(const Specimen& specimen, std::vector<Failure>& failures) const {
  const Contacts& contacts = specimen.contacts;
  for (std::size_t c = 0; c < contacts.count; ++c) {
    const std::int32_t pair[2] = {contacts.first[c], contacts.second[c]};
    const Body& a = specimen.particles.body[static_cast<std::size_t>(pair[0])];
    const Body& b = specimen.particles.body[static_cast<std::size_t>(pair[1])];
    const ContactModel::Normal normal = model_.between(a, b, contacts.root_radius[c]);
    if (!(normal.overlap > 0.0)) continue;
    const double area = contacts.root_radius[c] * contacts.root_radius[c] * normal.overlap;
    for (const std::int32_t index : pair) {
      const double limit = specimen.particles.body[static_cast<std::size_t>(index)].breaking_stress;
      if (normal.force > limit * area) {
        failures.push_back({index, FailureCause::kImmediate, normal.force / (limit * area)});
      }
    }
  }
}

void Dynamics::find_failures_at_walls(std::vector<Failure>& failures) {
  for (std::size_t i = 0; i < breaking_at_walls_.size(); ++i) {
    if (breaking_at_walls_[i] == 0.0) continue;
    failures.push_back({static_cast<std::int32_t>(i), FailureCause::kImmediate, breaking_at_walls_[i]});
    breaking_at_walls_[i] = 0.0;
  }
}

CycleResult Dynamics::cycle(Specimen& specimen, const WallControl& control) {
  const std::int64_t cycle = specimen.cycle;
  if (options_.rebuild_every > 0 && cycle % options_.rebuild_every == 0) specimen.contacts.valid = false;
  ensure_list(specimen);
  CycleKind kind;
  kind.measure = cycle % kMeasureInterval == 0;
  kind.check = may_fail_ && crushable_ && cycle % experiment_.numerics.failure_check_interval == 0;
  const double drift = specimen.time_step;
  const double kick = 0.5 * (specimen.last_time_step + drift);
  CycleResult result;
  const Sums sums = compute(specimen, kind, kick, drift, result);
  if (experiment_.material.free_rotation) turn_particles(specimen, kick);
  book(specimen, sums, kind);
  move_walls(specimen, control, drift);
  advance_clocks(specimen, drift);
  specimen.last_time_step = drift;
  ++specimen.cycle;
  // The list was made with half a skin for the walls.
  if (sums.particles.list_ends || largest_wall_displacement(specimen) > 0.5 * search_.skin()) {
    specimen.contacts.valid = false;
  }
  if (kind.measure) {
    result.finite = sums.particles.finite;
    result.largest_overlap_ratio = sums.contacts.largest_overlap_ratio;
    result.step_ratio = drift * std::sqrt(0.5 * sums.particles.largest_stiffness_over_mass);
    if (may_fail_) grow_cracks(specimen, result);
    if (cycle % kTimeStepInterval == 0)
      specimen.time_step = stable_step(sums.particles.largest_stiffness_over_mass);
  }
  if (kind.check && sums.particles.breaking) find_failures_at_walls(result.failures);
  if (result.failures.size() > 1) {
    // Immediate failure goes before a crack, the larger ratio before the smaller; then each particle once.
    std::sort(result.failures.begin(), result.failures.end(), [](const Failure& a, const Failure& b) {
      if (a.index != b.index) return a.index < b.index;
      if (a.cause != b.cause) return a.cause < b.cause;
      return a.stress_ratio > b.stress_ratio;
    });
    const auto last = std::unique(result.failures.begin(), result.failures.end(),
                                  [](const Failure& a, const Failure& b) { return a.index == b.index; });
    result.failures.erase(last, result.failures.end());
  }
  return result;
}

void Dynamics::assess(Specimen& specimen) {
  ensure_list(specimen);
  CycleKind kind;
  kind.measure = true;
  kind.move = false;
  CycleResult ignored;
  const Sums sums = compute(specimen, kind, 0.0, 0.0, ignored);
  book(specimen, sums, kind);
  specimen.time_step = stable_step(sums.particles.largest_stiffness_over_mass);
}

}  // namespace creep
