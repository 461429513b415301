#include "core/dem/measures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/arithmetic/elementary.h"
#include "core/dem/rotation.h"
#include "core/physics/grading.h"

namespace creep {
namespace {

double wall_gap(const Specimen& specimen, const Body& body, std::size_t wall) {
  const double centre[3] = {body.x, body.y, body.z};
  const std::size_t axis = wall / 2;
  return wall % 2 == 0 ? centre[axis] - specimen.walls.position[wall]
                       : specimen.walls.position[wall] - centre[axis];
}

}  // namespace

ElasticEnergy elastic_energy(const Specimen& specimen, const ContactModel& model) {
  const Contacts& contacts = specimen.contacts;
  const auto& body = specimen.particles.body;
  ElasticEnergy energy;
  for (std::size_t c = 0; c < contacts.count; ++c) {
    const Body& a = body[static_cast<std::size_t>(contacts.first[c])];
    const Body& b = body[static_cast<std::size_t>(contacts.second[c])];
    const ContactModel::Normal normal = model.between(a, b, contacts.root_radius[c]);
    if (!(normal.overlap > 0.0)) continue;
    energy.normal += model.modulus * contacts.root_radius[c] * model.law.energy(normal.overlap);
    const double squared = contacts.shear_x[c] * contacts.shear_x[c] +
                           contacts.shear_y[c] * contacts.shear_y[c] +
                           contacts.shear_z[c] * contacts.shear_z[c];
    energy.tangential += 0.5 * squared / (model.tangential_ratio * normal.stiffness);
  }
  for (std::size_t i = 0; i < body.size(); ++i) {
    for (std::size_t wall = 0; wall < 6; ++wall) {
      if ((contacts.near_walls[i] >> wall & 1u) == 0) continue;
      const double overlap = body[i].radius - wall_gap(specimen, body[i], wall);
      if (!(overlap > 0.0)) continue;
      energy.normal += model.wall_modulus * std::sqrt(body[i].radius) * model.law.energy(overlap);
      if (specimen.particles.wall_shear.empty()) continue;
      const auto& shear = specimen.particles.wall_shear[i].across[wall / 2];
      const double stiffness = model.at_wall(body[i], body[i].radius - overlap).stiffness;
      energy.tangential +=
          0.5 * (shear[0] * shear[0] + shear[1] * shear[1]) / (model.tangential_ratio * stiffness);
    }
  }
  return energy;
}

double kinetic_energy(const Specimen& specimen) {
  double energy = 0.0;
  for (std::size_t i = 0; i < specimen.particles.size(); ++i) {
    const Body& b = specimen.particles.body[i];
    energy += 0.5 * specimen.particles.inertial_mass[i] * (b.vx * b.vx + b.vy * b.vy + b.vz * b.vz);
  }
  for (std::size_t i = 0; i < specimen.particles.spin.size(); ++i) {
    const Spin& s = specimen.particles.spin[i];
    energy += 0.5 * moment_of_inertia(specimen.particles, i) * (s.x * s.x + s.y * s.y + s.z * s.z);
  }
  return energy;
}

double particle_mass(const Specimen& specimen) {
  double mass = 0.0;
  for (const double m : specimen.particles.mass) mass += m;
  return mass;
}

double fines_mass(const Specimen& specimen) {
  double mass = 0.0;
  for (const Fines& fines : specimen.fines) mass += fines.mass;
  return mass;
}

VoidRatio void_ratio(const Specimen& specimen, double density) {
  const double solid = particle_mass(specimen) / density;
  return {void_ratio(specimen.walls, solid + fines_mass(specimen) / density),
          void_ratio(specimen.walls, solid)};
}

double void_ratio(const Walls& walls, double solid_volume) { return walls.volume() / solid_volume - 1.0; }

double grading_index(const Specimen& specimen, const Material& material) {
  const GradingIndex index(material);
  double area = 0.0, mass = 0.0;
  for (std::size_t i = 0; i < specimen.particles.size(); ++i) {
    area += specimen.particles.mass[i] * index.particle_area(2.0 * specimen.particles.body[i].radius);
    mass += specimen.particles.mass[i];
  }
  for (const Fines& fines : specimen.fines) {
    area += fines.mass * index.fines_area(fines.smallest_sibling);
    mass += fines.mass;
  }
  return area / (mass * index.limit_area());
}

std::vector<double> passing(const Specimen& specimen, const Material& material,
                            const std::vector<double>& diameters) {
  std::vector<double> finer(diameters.size(), 0.0);
  double mass = 0.0;
  for (std::size_t i = 0; i < specimen.particles.size(); ++i) {
    mass += specimen.particles.mass[i];
    for (std::size_t k = 0; k < diameters.size(); ++k) {
      if (2.0 * specimen.particles.body[i].radius <= diameters[k]) finer[k] += specimen.particles.mass[i];
    }
  }
  const double exponent = 3.0 - material.fractal_dimension;
  for (const Fines& fines : specimen.fines) {
    mass += fines.mass;
    for (std::size_t k = 0; k < diameters.size(); ++k) {
      finer[k] += fines.mass * fractal_passing(diameters[k], fines.smallest_sibling,
                                               material.grading_index_min_diameter, exponent);
    }
  }
  for (double& fraction : finer) fraction /= mass;
  return finer;
}

ContactStress contact_stress(const Specimen& specimen, const ContactModel& model) {
  const Contacts& contacts = specimen.contacts;
  const auto& body = specimen.particles.body;
  double sum[3] = {0.0, 0.0, 0.0};
  for (std::size_t c = 0; c < contacts.count; ++c) {
    const Body& a = body[static_cast<std::size_t>(contacts.first[c])];
    const Body& b = body[static_cast<std::size_t>(contacts.second[c])];
    const double force = model.between(a, b, contacts.root_radius[c]).force;
    const double branch[3] = {b.x - a.x, b.y - a.y, b.z - a.z};
    const double distance = std::sqrt(branch[0] * branch[0] + branch[1] * branch[1] + branch[2] * branch[2]);
    const double shear[3] = {contacts.shear_x[c], contacts.shear_y[c], contacts.shear_z[c]};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sum[axis] += (force * branch[axis] / distance - shear[axis]) * branch[axis];
    }
  }
  for (std::size_t i = 0; i < body.size(); ++i) {
    for (std::size_t wall = 0; wall < 6; ++wall) {
      if ((contacts.near_walls[i] >> wall & 1u) == 0) continue;
      const double gap = wall_gap(specimen, body[i], wall);
      sum[wall / 2] += model.at_wall(body[i], gap).force * gap;
    }
  }
  const double volume = specimen.walls.volume();
  return {sum[2] / volume, 0.5 * (sum[0] + sum[1]) / volume};
}

Coordination coordination(const Specimen& specimen, const ContactModel& model) {
  const Contacts& contacts = specimen.contacts;
  const auto& body = specimen.particles.body;
  std::vector<std::int32_t> ends(body.size(), 0);
  for (std::size_t c = 0; c < contacts.count; ++c) {
    const Body& a = body[static_cast<std::size_t>(contacts.first[c])];
    const Body& b = body[static_cast<std::size_t>(contacts.second[c])];
    if (!(model.between(a, b, contacts.root_radius[c]).overlap > 0.0)) continue;
    ++ends[static_cast<std::size_t>(contacts.first[c])];
    ++ends[static_cast<std::size_t>(contacts.second[c])];
  }
  double all = 0.0, bearing_ends = 0.0, bearing = 0.0;
  for (std::size_t i = 0; i < body.size(); ++i) {
    for (std::size_t wall = 0; wall < 6; ++wall) {
      if ((contacts.near_walls[i] >> wall & 1u) == 0) continue;
      if (model.at_wall(body[i], wall_gap(specimen, body[i], wall)).overlap > 0.0) ++ends[i];
    }
    all += ends[i];
    if (ends[i] >= 2) {
      bearing_ends += ends[i];
      bearing += 1.0;
    }
  }
  return {all / static_cast<double>(body.size()), bearing > 0.0 ? bearing_ends / bearing : 0.0};
}

std::vector<double> mobilised_stress(const Specimen& specimen, const ContactModel& model) {
  const Contacts& contacts = specimen.contacts;
  const auto& body = specimen.particles.body;
  std::vector<double> stress(body.size(), 0.0);
  for (std::size_t c = 0; c < contacts.count; ++c) {
    const auto first = static_cast<std::size_t>(contacts.first[c]);
    const auto second = static_cast<std::size_t>(contacts.second[c]);
    const ContactModel::Normal normal = model.between(body[first], body[second], contacts.root_radius[c]);
    if (!(normal.overlap > 0.0)) continue;
    const double area = contacts.root_radius[c] * contacts.root_radius[c] * normal.overlap;
    const double here = normal.force / (std::numbers::pi * area);
    stress[first] = std::max(stress[first], here);
    stress[second] = std::max(stress[second], here);
  }
  for (std::size_t i = 0; i < body.size(); ++i) {
    for (std::size_t wall = 0; wall < 6; ++wall) {
      if ((contacts.near_walls[i] >> wall & 1u) == 0) continue;
      const ContactModel::Normal normal = model.at_wall(body[i], wall_gap(specimen, body[i], wall));
      if (!(normal.overlap > 0.0)) continue;
      const double area = body[i].radius * normal.overlap;
      stress[i] = std::max(stress[i], normal.force / (std::numbers::pi * area));
    }
  }
  return stress;
}

double axial_strain(const Specimen& specimen) {
  if (specimen.initial_height == 0.0) return 0.0;
  return 1.0 - specimen.walls.length(2) / specimen.initial_height;
}

double volumetric_strain(const Specimen& specimen) {
  if (specimen.initial_volume == 0.0) return 0.0;
  return 1.0 - specimen.walls.volume() / specimen.initial_volume;
}

double radial_stress(const Walls& walls) { return 0.5 * (walls.stress(0) + walls.stress(1)); }

double value_of(Target::Measure measure, const Specimen& specimen) {
  const double axial = specimen.walls.stress(2), radial = radial_stress(specimen.walls);
  const double p = (axial + 2.0 * radial) / 3.0;
  using Measure = Target::Measure;
  switch (measure) {
    case Measure::kAxialStress:
      return axial;
    case Measure::kMeanStress:
      return p;
    case Measure::kDeviatoricStress:
      return axial - radial;
    case Measure::kStressRatio:
      return p > 0.0 ? (axial - radial) / p : 0.0;
    case Measure::kAxialStrain:
      return axial_strain(specimen);
    case Measure::kDeviatoricStrain:  // 2/3 (eps_a - eps_r) with eps_v = eps_a + 2 eps_r
      return axial_strain(specimen) - volumetric_strain(specimen) / 3.0;
  }
  return 0.0;
}

double inertial_number(const Specimen& specimen, const Experiment& experiment) {
  const Walls& walls = specimen.walls;
  const double rate = std::fabs(walls.velocity[4] - walls.velocity[5]) / walls.length(2);
  const double p = (walls.stress(0) + walls.stress(1) + walls.stress(2)) / 3.0;
  if (!(p > 0.0)) return 0.0;
  return rate * median_diameter(experiment.specimen.grading) * std::sqrt(experiment.material.density / p);
}

}  // namespace creep
