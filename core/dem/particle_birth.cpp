#include "core/dem/particle_birth.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include "core/arithmetic/random.h"
#include "core/dem/measures.h"
#include "core/physics/crack.h"
#include "core/physics/grading.h"
#include "core/physics/strength.h"

namespace creep {
namespace {

/// The mass in the equation of motion [kg]. The stable step goes with sqrt(inertial mass / stiffness), and
/// the stiffness of a contact with sqrt(r'), so the lightest particle decides it: raising all below a
/// reference m_ref to m_ref lengthens the step by up to sqrt(m_ref / m). What moves quasi-statically does not
/// notice.
double inertial_mass(const Experiment& experiment, double mass, std::int32_t generation) {
  const double density = experiment.material.density;
  const Grading& grading = experiment.specimen.grading;
  switch (experiment.numerics.inertia_scaling) {
    case InertiaScaling::kNone:
      return mass;
    case InertiaScaling::kFragments:  // no fragment lighter than the finest initial particle
      return generation == 0 ? mass : std::max(mass, sphere_mass(0.5 * finest_diameter(grading), density));
    case InertiaScaling::kAll:  // nothing lighter than the median particle
      return std::max(mass, sphere_mass(0.5 * median_diameter(grading), density));
  }
  return mass;
}

}  // namespace

void let_walls_rub(Particles& particles, const Material& material) {
  particles.wall_shear.resize(material.wall_friction > 0.0 ? particles.size() : 0);
}

double sphere_mass(double radius, double density) {
  return 4.0 / 3.0 * std::numbers::pi * density * radius * radius * radius;
}

void append_particle(Particles& particles, const Experiment& experiment, const Birth& birth) {
  const Material& material = experiment.material;
  const std::uint64_t seed = experiment.specimen.seed;
  const double diameter = 2.0 * birth.radius;
  const double strength = limit_stress(material, diameter, normal(seed, birth.id, RandomEvent::kStrength));
  const double mass = sphere_mass(birth.radius, material.density);
  const bool can_fail = diameter >= material.comminution_limit;
  particles.body.push_back(
      {birth.position[0], birth.position[1], birth.position[2], birth.radius, birth.velocity[0],
       birth.velocity[1], birth.velocity[2],
       can_fail ? std::numbers::pi * strength : std::numeric_limits<double>::infinity()});
  particles.id.push_back(birth.id);
  particles.parent.push_back(birth.parent);
  particles.generation.push_back(birth.generation);
  particles.mass.push_back(mass);
  particles.inertial_mass.push_back(inertial_mass(experiment, mass, birth.generation));
  particles.limit_stress.push_back(strength);
  particles.crack.push_back(initial_crack(diameter, uniform(seed, birth.id, RandomEvent::kCrack)));
  particles.mobilised_stress.push_back(0.0);
  if (!particles.wall_shear.empty()) particles.wall_shear.push_back({});
  if (material.free_rotation) particles.spin.push_back({birth.spin[0], birth.spin[1], birth.spin[2], 0.0});
}

bool scale_inertia(Specimen& specimen, const Experiment& experiment) {
  Particles& particles = specimen.particles;
  const double kinetic_before = kinetic_energy(specimen);
  bool changed = false;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const double scaled = inertial_mass(experiment, particles.mass[i], particles.generation[i]);
    changed = changed || scaled != particles.inertial_mass[i];
    particles.inertial_mass[i] = scaled;
  }
  if (changed) specimen.energy.removed_kinetic += kinetic_before - kinetic_energy(specimen);
  return changed;
}

}  // namespace creep
