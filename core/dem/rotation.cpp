#include "core/dem/rotation.h"

#include <cmath>

namespace creep {
namespace {

/// Kicks one component of the spin; returns the work of damping over `kick` [W].
double kick_component(double& spin, double moment, double local_damping, double step_over_inertia) {
  const double before = spin;
  const double damping = before == 0.0 ? 0.0 : std::copysign(local_damping * std::fabs(moment), before);
  spin = before + (moment - damping) * step_over_inertia;
  return damping * (0.5 * (before + spin));
}

/// Adds normal x tangential force of the walls that rub particle i [N]; those it does not touch exert none.
void add_walls(const Specimen& specimen, std::size_t i, double& x, double& y, double& z) {
  double* const couple[3] = {&x, &y, &z};
  const Eigen::Vector3d centre = specimen.particles.position(i);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& force = specimen.particles.wall_shear[i].across[axis];
    const double middle = 0.5 * (specimen.walls.position[2 * axis] + specimen.walls.position[2 * axis + 1]);
    const double side = centre[static_cast<Eigen::Index>(axis)] > middle ? 1.0 : -1.0;
    *couple[(axis + 1) % 3] -= side * force[1];
    *couple[(axis + 2) % 3] += side * force[0];
  }
}

}  // namespace

double moment_of_inertia(const Particles& particles, std::size_t i) {
  const double radius = particles.body[i].radius;
  return 0.4 * particles.inertial_mass[i] * radius * radius;
}

FixedSum turn(Specimen& specimen, double local_damping, double kick, std::size_t begin, std::size_t end) {
  const Contacts& contacts = specimen.contacts;
  Particles& particles = specimen.particles;
  FixedSum work(kEnergyQuantum);
  for (std::size_t i = begin; i < end; ++i) {
    // In ascending neighbour id, like resultants. Both particles of a contact are turned the same way.
    double x = 0.0, y = 0.0, z = 0.0;
    const auto add = [&](std::int32_t contact) {
      const ContactForce& couple = contacts.couple[static_cast<std::size_t>(contact)];
      x += couple.x;
      y += couple.y;
      z += couple.z;
    };
    for (std::int32_t k = contacts.lower_begin[i]; k < contacts.lower_begin[i + 1]; ++k)
      add(contacts.lower_contact[static_cast<std::size_t>(k)]);
    for (std::int32_t c = contacts.own_begin[i]; c < contacts.own_begin[i + 1]; ++c) add(c);
    if (!particles.wall_shear.empty() && contacts.near_walls[i] != 0) add_walls(specimen, i, x, y, z);
    const double radius = particles.body[i].radius;
    const double step_over_inertia = kick / moment_of_inertia(particles, i);
    Spin& spin = particles.spin[i];
    const double power = kick_component(spin.x, radius * x, local_damping, step_over_inertia) +
                         kick_component(spin.y, radius * y, local_damping, step_over_inertia) +
                         kick_component(spin.z, radius * z, local_damping, step_over_inertia);
    work.add(power * kick);
  }
  return work;
}

}  // namespace creep
