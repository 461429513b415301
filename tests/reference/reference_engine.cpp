#include "tests/reference/reference_engine.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/arithmetic/random.h"
#include "core/dem/shear_history.h"
#include "core/physics/crack.h"
#include "core/physics/split_geometry.h"
#include "core/physics/strength.h"

namespace creep::reference {
namespace {

using Eigen::Vector3d;

double dot(const Vector3d& a, const Vector3d& b) {
  return std::fma(a.x(), b.x(), std::fma(a.y(), b.y(), a.z() * b.z()));
}

/// s a + b, each component fused.
Vector3d fused(double s, const Vector3d& a, const Vector3d& b) {
  return {std::fma(s, a.x(), b.x()), std::fma(s, a.y(), b.y()), std::fma(s, a.z(), b.z())};
}

Vector3d cross(const Vector3d& a, const Vector3d& b) {
  return {std::fma(a.y(), b.z(), 0.0 - a.z() * b.y()), std::fma(a.z(), b.x(), 0.0 - a.x() * b.z()),
          std::fma(a.x(), b.y(), 0.0 - a.y() * b.x())};
}

/// The nearest whole number of quanta of 2^exponent.
std::int64_t quanta(double value, int exponent) { return std::llrint(std::ldexp(value, -exponent)); }

double of_quanta(std::int64_t count, int exponent) {
  return std::ldexp(static_cast<double>(count), exponent);
}

double sign(double value) { return value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : 0.0; }

}  // namespace

struct Engine::Loads {
  explicit Loads(std::size_t grains)
      : force(grains, Vector3d::Zero()),
        couple(grains, Vector3d::Zero()),
        wall_stiffness(grains, 0.0),
        contact_stiffness(grains, 0.0),
        stress(grains, 0.0) {}
  std::vector<Vector3d> force, couple;  // a couple times its radius turns a grain
  std::vector<double> wall_stiffness, contact_stiffness;
  std::vector<double> stress;
  std::set<std::uint64_t> failed;
  std::int64_t wall_force[6] = {}, wall_load[6] = {};
  std::int64_t force_sum = 0, overlap_sum = 0, touching = 0;
};

Engine::Engine(const Experiment& experiment, const Specimen& specimen)
    : experiment_(experiment),
      law_(RoughLaw::make(experiment.material.roughness, experiment.material.roughness_n1,
                          experiment.material.roughness_n2)),
      table_(law_),
      fines_(specimen.fines),
      initial_mass_(specimen.initial_mass),
      friction_coefficient_(specimen.friction),
      time_step_(specimen.time_step),
      last_time_step_(specimen.last_time_step),
      dynamic_time_(specimen.clocks.dynamic_time),
      crack_time_(specimen.crack_time),
      mean_overlap_(specimen.mean_overlap),
      unbalanced_force_ratio_(specimen.unbalanced_force_ratio),
      wall_work_(specimen.energy.wall_work),
      next_id_(specimen.next_id),
      cycle_(specimen.cycle) {
  const Particles& particles = specimen.particles;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    grains_.push_back({particles.id[i], particles.parent[i], particles.generation[i], particles.position(i),
                       particles.velocity(i), particles.body[i].radius, particles.mass[i],
                       particles.limit_stress[i], particles.crack[i], particles.mobilised_stress[i]});
    if (experiment.material.free_rotation) {
      grains_.back().spin = {particles.spin[i].x, particles.spin[i].y, particles.spin[i].z};
    }
  }
  carried_ = specimen.walls.carried;
  for (const PairShear& pair : shear_history(specimen.contacts)) {
    const std::uint64_t first = particles.id[static_cast<std::size_t>(pair.first)];
    const std::uint64_t second = particles.id[static_cast<std::size_t>(pair.second)];
    shear_[{first, second}] = {pair.x, pair.y, pair.z};
  }
  for (std::size_t w = 0; w < 6; ++w) {
    walls_[w] = {specimen.walls.position[w], specimen.walls.velocity[w], specimen.walls.force[w],
                 specimen.walls.stiffness[w]};
  }
}

double Engine::wall_gap(std::size_t wall, const Grain& grain) const {
  const double along = grain.position[static_cast<Eigen::Index>(wall / 2)];
  return wall % 2 == 1 ? walls_[wall].position - along : along - walls_[wall].position;
}

std::array<double, 2> Engine::wall_friction(double step, std::size_t index, std::size_t wall,
                                            double normal_force, double normal_stiffness, Loads& loads) {
  const Material& material = experiment_.material;
  const Grain& grain = grains_[index];
  const double side = wall % 2 == 1 ? 1.0 : -1.0;
  const auto first = static_cast<Eigen::Index>((wall / 2 + 1) % 3);
  const auto second = static_cast<Eigen::Index>((wall / 2 + 2) % 3);
  const auto known = wall_shear_.find({grain.id, wall});
  const std::array<double, 2> old = known == wall_shear_.end() ? std::array<double, 2>{} : known->second;
  const double arm = side * grain.radius;
  const double slip[2] = {(0.0 - (grain.velocity[first] + arm * grain.spin[second])) * step,
                          (0.0 - (grain.velocity[second] - arm * grain.spin[first])) * step};
  const double stiffness = material.tangential_ratio() * normal_stiffness;
  std::array<double, 2> shear = {old[0] + stiffness * slip[0], old[1] + stiffness * slip[1]};
  const double squared = shear[0] * shear[0] + shear[1] * shear[1];
  const double cap = material.wall_friction * normal_force;
  if (squared > cap * cap) {
    const double trial = std::sqrt(squared), scale = cap / trial;
    shear = {shear[0] * scale, shear[1] * scale};
    friction_ += quanta((trial - cap) * cap / stiffness, -70);
  }
  tangential_ += quanta(0.5 * ((old[0] + shear[0]) * slip[0] + (old[1] + shear[1]) * slip[1]), -70);
  loads.couple[index][first] -= side * shear[1];
  loads.couple[index][second] += side * shear[0];
  return shear;
}

void Engine::wall_forces(double step, bool check, Loads& loads) {
  const Material& material = experiment_.material;
  decltype(wall_shear_) closed;
  const double modulus = material.reduced_modulus() * material.wall_stiffness_factor;
  for (std::size_t i = 0; i < grains_.size(); ++i) {
    const Grain& grain = grains_[i];
    Vector3d of_walls = Vector3d::Zero();
    for (std::size_t w = 0; w < 6; ++w) {
      const double overlap = grain.radius - wall_gap(w, grain);
      if (overlap <= 0.0) continue;
      double g, slope;
      table_.evaluate(overlap, g, slope);
      const double prefactor = modulus * std::sqrt(grain.radius);
      const double force = prefactor * g, stiffness = prefactor * slope;
      of_walls[static_cast<Eigen::Index>(w / 2)] += w % 2 == 1 ? -force : force;
      if (material.wall_friction > 0.0) {
        const std::array<double, 2> shear = wall_friction(step, i, w, force, stiffness, loads);
        of_walls[static_cast<Eigen::Index>((w / 2 + 1) % 3)] += shear[0];
        of_walls[static_cast<Eigen::Index>((w / 2 + 2) % 3)] += shear[1];
        closed[{grain.id, w}] = shear;
      }
      loads.wall_stiffness[i] += stiffness;
      loads.wall_force[w] += quanta(force, -40);
      loads.wall_load[w] += quanta(stiffness, -20);
      const double area = grain.radius * overlap;
      loads.stress[i] = std::max(loads.stress[i], force / (std::numbers::pi * area));
      if (check && 2.0 * grain.radius >= material.comminution_limit &&
          force > std::numbers::pi * grain.limit_stress * area) {
        loads.failed.insert(grain.id);
      }
    }
    loads.force[i] += of_walls;  // after all neighbours
  }
  wall_shear_ = std::move(closed);
}

void Engine::contact_forces(double step, bool check, Loads& loads) {
  const Material& material = experiment_.material;
  // Pairs in ascending (first, second): each grain meets its lower neighbours before the higher ones, both in
  // ascending id.
  decltype(shear_) closed;
  for (std::size_t i = 0; i < grains_.size(); ++i) {
    for (std::size_t j = i + 1; j < grains_.size(); ++j) {
      const Grain &a = grains_[i], &b = grains_[j];
      const Vector3d branch = b.position - a.position;
      const double distance = std::sqrt(dot(branch, branch));
      const double overlap = (a.radius + b.radius) - distance;
      if (overlap <= 0.0) continue;
      const Vector3d n = branch * (1.0 / distance);
      double g, slope;
      table_.evaluate(overlap, g, slope);
      const double root_radius = std::sqrt(a.radius * b.radius / (a.radius + b.radius));
      const double prefactor = material.reduced_modulus() * root_radius;
      const double normal_force = prefactor * g, normal_stiffness = prefactor * slope;
      const double tangential_stiffness = material.tangential_ratio() * normal_stiffness;

      Vector3d apart = b.velocity - a.velocity;
      if (material.free_rotation) {
        const Vector3d rolling = fused(a.radius, a.spin, b.radius * b.spin);
        apart -= cross(rolling, n);
      }
      const Vector3d u = apart * step;
      const Vector3d s = fused(0.0 - dot(u, n), n, u);
      const auto known = shear_.find({a.id, b.id});
      const Vector3d old = known == shear_.end() ? Vector3d(0.0, 0.0, 0.0) : known->second;
      Vector3d shear = fused(tangential_stiffness, s, fused(0.0 - dot(old, n), n, old));
      const double cap = friction_coefficient_ * normal_force;
      if (dot(shear, shear) > cap * cap) {
        const double trial = std::sqrt(dot(shear, shear));
        shear = shear * (cap / trial);
        friction_ += quanta((trial - cap) * cap / tangential_stiffness, -70);
      }
      tangential_ += quanta(0.5 * dot(old + shear, s), -70);
      closed.emplace_hint(closed.end(), std::pair(a.id, b.id), shear);
      const Vector3d force = fused(0.0 - normal_force, n, shear);
      loads.force[i] += force;
      loads.force[j] -= force;
      if (material.free_rotation) {
        const Vector3d couple = cross(n, shear);
        loads.couple[i] += couple;
        loads.couple[j] += couple;
      }
      loads.contact_stiffness[i] += normal_stiffness;
      loads.contact_stiffness[j] += normal_stiffness;

      const double area = root_radius * root_radius * overlap;
      const double stress = normal_force / (std::numbers::pi * area);
      for (const std::size_t k : {i, j}) {
        loads.stress[k] = std::max(loads.stress[k], stress);
        if (check && 2.0 * grains_[k].radius >= material.comminution_limit &&
            normal_force > std::numbers::pi * grains_[k].limit_stress * area) {
          loads.failed.insert(grains_[k].id);
        }
      }
      loads.force_sum += quanta(std::sqrt(dot(force, force)), -40);
      loads.overlap_sum += quanta(overlap, -60);
      ++loads.touching;
    }
  }
  shear_ = std::move(closed);  // an open contact forgets
}

void Engine::book(const Loads& loads, bool measure) {
  for (std::size_t w = 0; w < 6; ++w) {
    walls_[w].force = of_quanta(loads.wall_force[w], -40);
    walls_[w].stiffness = of_quanta(loads.wall_load[w], -20);
  }
  if (!measure) return;
  std::int64_t resultant = 0, with_contacts = 0;
  for (std::size_t i = 0; i < grains_.size(); ++i) {
    grains_[i].mobilised_stress = loads.stress[i];
    if (loads.wall_stiffness[i] + loads.contact_stiffness[i] > 0.0) {
      const Vector3d& f = loads.force[i];
      resultant += quanta(std::sqrt(f.x() * f.x() + f.y() * f.y() + f.z() * f.z()), -40);
      ++with_contacts;
    }
  }
  const auto touching = static_cast<double>(loads.touching);
  mean_overlap_ = touching > 0.0 ? of_quanta(loads.overlap_sum, -60) / touching : 0.0;
  unbalanced_force_ratio_ = 1.0;
  if (loads.force_sum > 0) {
    unbalanced_force_ratio_ = static_cast<double>(resultant) / static_cast<double>(with_contacts) /
                              (static_cast<double>(loads.force_sum) / touching);
  }
}

double Engine::stable_step(const Loads& loads) const {
  // A grain without contact counts as if it had one of the mean overlap with another like it.
  const double overlap = std::max(mean_overlap_, std::max(0.1 * experiment_.material.roughness, 1e-9));
  const double floor = experiment_.material.reduced_modulus() * std::sqrt(0.5) * law_.slope(overlap);
  double largest = 0.0;
  for (std::size_t i = 0; i < grains_.size(); ++i) {
    const double sum = loads.wall_stiffness[i] + loads.contact_stiffness[i];
    const double stiffness = std::max(sum, floor * std::sqrt(grains_[i].radius));
    largest = std::max(largest, stiffness / grains_[i].mass);
  }
  if (experiment_.material.free_rotation)
    largest *= std::max(1.0, 3.5 * experiment_.material.tangential_ratio());
  return experiment_.numerics.time_step_safety * std::sqrt(2.0 / largest);
}

void Engine::move(const Loads& loads, double kick, double drift) {
  for (std::size_t i = 0; i < grains_.size(); ++i) {
    Grain& grain = grains_[i];
    double power[3];
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double force = loads.force[i][axis], before = grain.velocity[axis];
      const double damping = experiment_.numerics.local_damping * std::fabs(force) * sign(before);
      const double after = before + (force - damping) * (kick / grain.mass);
      grain.velocity[axis] = after;
      grain.position[axis] += after * drift;
      power[axis] = damping * (0.5 * (before + after));
    }
    damping_ += quanta((power[0] + power[1] + power[2]) * kick, -70);
  }
}

void Engine::turn(const Loads& loads, double kick) {
  if (!experiment_.material.free_rotation) return;
  for (std::size_t i = 0; i < grains_.size(); ++i) {
    Grain& grain = grains_[i];
    double power[3];
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double moment = grain.radius * loads.couple[i][axis], before = grain.spin[axis];
      const double damping = experiment_.numerics.local_damping * std::fabs(moment) * sign(before);
      const double after =
          before + (moment - damping) * (kick / (0.4 * grain.mass * grain.radius * grain.radius));
      grain.spin[axis] = after;
      power[axis] = damping * (0.5 * (before + after));
    }
    damping_ += quanta((power[0] + power[1] + power[2]) * kick, -70);
  }
}

void Engine::steer(const WallControl& control, double step) {
  double length[3];
  for (std::size_t axis = 0; axis < 3; ++axis)
    length[axis] = walls_[2 * axis + 1].position - walls_[2 * axis].position;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Wall &low = walls_[2 * axis], &high = walls_[2 * axis + 1];
    double inward = 0.0, carried = 0.0;
    if (control[axis].mode == AxisControl::Mode::kServo) {
      const double cap = 0.5 * control[axis].closing_velocity;
      const double area = length[(axis + 1) % 3] * length[(axis + 2) % 3];
      const double error = control[axis].stress * area - 0.5 * (low.force + high.force);
      const double layers = 0.5 * (low.stiffness + high.stiffness) *
                            median_diameter(experiment_.specimen.grading) / length[axis];
      inward = layers > 0.0 ? error / (3.0 * std::sqrt(initial_mass_ * layers)) : sign(error) * cap;
      if (control[axis].follows && layers > 0.0) {
        carried = carried_[axis];
        inward += carried;
        if (-cap < inward && inward < cap) carried += error * step / (3.0 * 6.0 * initial_mass_);
      }
      if (inward > cap) inward = cap;
      if (inward < -cap) inward = -cap;
    } else if (control[axis].mode == AxisControl::Mode::kVelocity) {
      inward = 0.5 * control[axis].closing_velocity;
    }
    carried_[axis] = carried;
    low.velocity = inward;
    high.velocity = -inward;
  }
}

void Engine::grow_cracks(std::set<std::uint64_t>& failed) {
  for (Grain& grain : grains_) {
    if (2.0 * grain.radius < experiment_.material.comminution_limit) continue;
    const double ratio = grain.mobilised_stress / grain.limit_stress;
    grain.crack += crack_velocity(experiment_.material, ratio) * crack_time_;
    if (grain.crack >= grain.radius) failed.insert(grain.id);
  }
  crack_time_ = 0.0;
}

void Engine::cycle(const WallControl& control) {
  const bool measure = cycle_ % 10 == 0;
  const bool check = cycle_ % experiment_.numerics.failure_check_interval == 0;
  const double drift = time_step_, kick = 0.5 * (last_time_step_ + drift);
  Loads loads(grains_.size());
  contact_forces(last_time_step_, check, loads);
  wall_forces(last_time_step_, check, loads);
  const std::array<Wall, 6> before = walls_;
  const double step = cycle_ % 50 == 0 ? stable_step(loads) : time_step_;
  book(loads, measure);
  for (std::size_t w = 0; w < 6; ++w) {
    const double inward = (w % 2 == 0 ? before[w].velocity : -before[w].velocity) * last_time_step_;
    wall_work_ += 0.5 * (before[w].force + walls_[w].force) * inward;
  }
  move(loads, kick, drift);
  turn(loads, kick);
  steer(control, drift);
  for (Wall& wall : walls_) wall.position += wall.velocity * drift;
  dynamic_time_ += drift;
  crack_time_ += drift;
  last_time_step_ = drift;
  time_step_ = step;
  ++cycle_;
  if (measure) grow_cracks(loads.failed);
  if (!loads.failed.empty()) split(loads.failed);
}

void Engine::assess() {
  Loads loads(grains_.size());
  contact_forces(0.0, false, loads);
  wall_forces(0.0, false, loads);
  time_step_ = stable_step(loads);
  book(loads, true);
}

Vector3d Engine::loaded_direction(std::size_t index) const {
  const Grain& grain = grains_[index];
  const Material& material = experiment_.material;
  Vector3d direction = Vector3d::UnitZ();
  double largest = 0.0, slope = 0.0;
  for (std::size_t w = 0; w < 6; ++w) {
    const double overlap = grain.radius - wall_gap(w, grain);
    if (overlap <= 0.0) continue;
    double g;
    table_.evaluate(overlap, g, slope);
    const double force =
        material.reduced_modulus() * material.wall_stiffness_factor * std::sqrt(grain.radius) * g;
    if (force <= largest) continue;
    largest = force;
    direction = Vector3d::Zero();
    direction[static_cast<Eigen::Index>(w / 2)] = w % 2 == 1 ? 1.0 : -1.0;
  }
  for (const Grain& other : grains_) {
    if (other.id == grain.id) continue;
    const Vector3d branch = other.position - grain.position;
    const double overlap = (grain.radius + other.radius) - std::sqrt(dot(branch, branch));
    if (overlap <= 0.0) continue;
    double g;
    table_.evaluate(overlap, g, slope);
    const double reduced = std::min(grain.id, other.id) == grain.id
                               ? grain.radius * other.radius / (grain.radius + other.radius)
                               : other.radius * grain.radius / (other.radius + grain.radius);
    const double force = material.reduced_modulus() * std::sqrt(reduced) * g;
    if (force <= largest) continue;
    largest = force;
    direction = branch.normalized();
  }
  return direction;
}

void Engine::add_grain(std::uint64_t id, std::uint64_t parent, std::int32_t generation, double radius,
                       const Vector3d& position, const Vector3d& velocity, const Vector3d& spin) {
  const std::uint64_t seed = experiment_.specimen.seed;
  const double density = experiment_.material.density;
  Grain grain;
  grain.id = id;
  grain.parent = parent;
  grain.generation = generation;
  grain.position = position;
  grain.velocity = velocity;
  grain.spin = spin;
  grain.radius = radius;
  grain.mass = 4.0 / 3.0 * std::numbers::pi * density * radius * radius * radius;
  grain.limit_stress =
      limit_stress(experiment_.material, 2.0 * radius, normal(seed, id, RandomEvent::kStrength));
  grain.crack = initial_crack(2.0 * radius, uniform(seed, id, RandomEvent::kCrack));
  grains_.push_back(grain);
}

void Engine::split(const std::set<std::uint64_t>& failed) {
  const SplitLayout layout = experiment_.material.split_layout;
  std::vector<Grain> parents, survivors;
  std::vector<Vector3d> directions;
  for (std::size_t i = 0; i < grains_.size(); ++i) {
    if (!failed.contains(grains_[i].id)) {
      survivors.push_back(grains_[i]);
      continue;
    }
    parents.push_back(grains_[i]);
    directions.push_back(loaded_direction(i));
  }
  grains_ = survivors;
  std::erase_if(wall_shear_, [&](const auto& contact) { return failed.contains(contact.first.first); });
  std::erase_if(shear_, [&](const auto& contact) {
    return failed.contains(contact.first.first) || failed.contains(contact.first.second);
  });
  for (std::size_t p = 0; p < parents.size(); ++p) {
    const Grain& parent = parents[p];
    const double turn = uniform(experiment_.specimen.seed, parent.id, RandomEvent::kAzimuth);
    const Eigen::Matrix3d rotation = rotation_from_z(directions[p], turn);
    double kept = 0.0;
    for (const Sibling& sibling : sibling_layout(layout)) {
      const Vector3d branch = parent.radius * (rotation * sibling.centre);
      const Vector3d position = parent.position + branch;
      Vector3d velocity = parent.velocity;
      if (experiment_.material.free_rotation) velocity += parent.spin.cross(branch);
      add_grain(next_id_++, parent.id, parent.generation + 1, parent.radius * sibling.radius, position,
                velocity, parent.spin);
      kept += grains_.back().mass;
    }
    fines_.push_back({parent.mass - kept, 2.0 * parent.radius * smallest_sibling_radius(layout)});
    ++broken_;
  }
  assess();
}

}  // namespace creep::reference
