#include "core/dem/splitter.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/arithmetic/random.h"
#include "core/dem/measures.h"
#include "core/dem/particle_birth.h"
#include "core/physics/split_geometry.h"

namespace creep {
namespace {

/// Unit vector from the centre of particle i to its most heavily loaded contact; z if it has none.
Eigen::Vector3d loaded_direction(const Specimen& specimen, const ContactModel& model, std::size_t i) {
  const Contacts& contacts = specimen.contacts;
  const Particles& particles = specimen.particles;
  const Body& body = particles.body[i];
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  double largest = 0.0;
  for (std::size_t wall = 0; wall < 6; ++wall) {
    if ((contacts.near_walls[i] >> wall & 1u) == 0) continue;
    const std::size_t axis = wall / 2;
    const double centre[3] = {body.x, body.y, body.z};
    const bool high = wall % 2 == 1;
    const double gap =
        high ? specimen.walls.position[wall] - centre[axis] : centre[axis] - specimen.walls.position[wall];
    const double force = model.at_wall(body, gap).force;
    if (force > largest) {
      largest = force;
      direction = Eigen::Vector3d::Zero();
      direction[static_cast<Eigen::Index>(axis)] = high ? 1.0 : -1.0;
    }
  }
  const auto look_at = [&](std::size_t c, std::size_t other) {
    const double force = model.between(body, particles.body[other], contacts.root_radius[c]).force;
    if (force > largest) {
      largest = force;
      direction = (particles.position(other) - particles.position(i)).normalized();
    }
  };
  for (std::int32_t k = contacts.lower_begin[i]; k < contacts.lower_begin[i + 1]; ++k) {
    const auto c = static_cast<std::size_t>(contacts.lower_contact[static_cast<std::size_t>(k)]);
    look_at(c, static_cast<std::size_t>(contacts.first[c]));
  }
  for (std::int32_t k = contacts.own_begin[i]; k < contacts.own_begin[i + 1]; ++k) {
    const auto c = static_cast<std::size_t>(k);
    look_at(c, static_cast<std::size_t>(contacts.second[c]));
  }
  return direction;
}

template <class Column>
void drop(Column& values, const std::vector<std::int32_t>& new_index) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < new_index.size(); ++i) {
    if (new_index[i] >= 0) values[kept++] = values[i];
  }
  values.resize(kept);
}

/// Takes the failed particles out; survivors keep their order.
std::vector<std::int32_t> remove(Particles& particles, const std::vector<Failure>& failures) {
  std::vector<std::int32_t> new_index(particles.size());
  std::size_t next_failure = 0;
  std::int32_t next = 0;
  for (std::size_t i = 0; i < new_index.size(); ++i) {
    const bool failed =
        next_failure < failures.size() && static_cast<std::size_t>(failures[next_failure].index) == i;
    new_index[i] = failed ? -1 : next++;
    if (failed) ++next_failure;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < new_index.size(); ++i) {
    if (new_index[i] >= 0) particles.body[kept++] = particles.body[i];
  }
  particles.body.resize(kept);
  drop(particles.id, new_index);
  drop(particles.parent, new_index);
  drop(particles.generation, new_index);
  drop(particles.mass, new_index);
  drop(particles.inertial_mass, new_index);
  drop(particles.limit_stress, new_index);
  drop(particles.crack, new_index);
  drop(particles.mobilised_stress, new_index);
  if (!particles.spin.empty()) drop(particles.spin, new_index);
  if (!particles.wall_shear.empty()) drop(particles.wall_shear, new_index);
  return new_index;
}

struct Parent {
  Body body;
  std::uint64_t id;
  std::int32_t generation;
  double mass;
  Eigen::Vector3d spin;  // 0 where rotation is blocked
  Eigen::Vector3d direction;
};

}  // namespace

void split(Specimen& specimen, const Experiment& experiment, Dynamics& dynamics,
           const std::vector<Failure>& failures) {
  if (failures.empty()) return;
  dynamics.ensure_list(specimen);
  Particles& particles = specimen.particles;
  const ElasticEnergy elastic_before = elastic_energy(specimen, dynamics.model());
  const double kinetic_before = kinetic_energy(specimen);
  std::vector<Parent> parents;
  parents.reserve(failures.size());
  for (const Failure& failure : failures) {
    const auto i = static_cast<std::size_t>(failure.index);
    Eigen::Vector3d spin = Eigen::Vector3d::Zero();
    if (!particles.spin.empty()) spin = {particles.spin[i].x, particles.spin[i].y, particles.spin[i].z};
    parents.push_back({particles.body[i], particles.id[i], particles.generation[i], particles.mass[i], spin,
                       loaded_direction(specimen, dynamics.model(), i)});
  }
  const std::vector<std::int32_t> new_index = remove(particles, failures);
  const auto& layout = sibling_layout(experiment.material.split_layout);
  for (const Parent& parent : parents) {
    const double turn = uniform(experiment.specimen.seed, parent.id, RandomEvent::kAzimuth);
    const Eigen::Matrix3d rotation = rotation_from_z(parent.direction, turn);
    const Eigen::Vector3d centre(parent.body.x, parent.body.y, parent.body.z);
    double sibling_mass = 0.0;
    for (const Sibling& sibling : layout) {
      const Eigen::Vector3d branch = parent.body.radius * (rotation * sibling.centre);
      const Eigen::Vector3d position = centre + branch;
      Birth birth;
      birth.id = specimen.next_id++;
      birth.parent = parent.id;
      birth.generation = parent.generation + 1;
      birth.radius = parent.body.radius * sibling.radius;
      for (int axis = 0; axis < 3; ++axis) birth.position[axis] = position[axis];
      birth.velocity[0] = parent.body.vx;
      birth.velocity[1] = parent.body.vy;
      birth.velocity[2] = parent.body.vz;
      if (experiment.material.free_rotation) {  // the fragments go on as the one body they were
        const Eigen::Vector3d of_turning = parent.spin.cross(branch);
        for (int axis = 0; axis < 3; ++axis) {
          birth.velocity[axis] += of_turning[axis];
          birth.spin[axis] = parent.spin[axis];
        }
      }
      append_particle(particles, experiment, birth);
      sibling_mass += particles.mass.back();
    }
    const double smallest = smallest_sibling_radius(experiment.material.split_layout);
    specimen.fines.push_back({parent.mass - sibling_mass, 2.0 * parent.body.radius * smallest});
    ++specimen.broken_total;
  }
  dynamics.relist(specimen, new_index);
  const ElasticEnergy elastic_after = elastic_energy(specimen, dynamics.model());
  specimen.energy.removed_normal += elastic_before.normal - elastic_after.normal;
  specimen.energy.removed_tangential += elastic_before.tangential - elastic_after.tangential;
  specimen.energy.removed_kinetic += kinetic_before - kinetic_energy(specimen);
  dynamics.assess(specimen);
}

}  // namespace creep
