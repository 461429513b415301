// A plain engine for the same model: every pair of grains, one after the other, in ascending id. The oracle.
//
// It has no threads, no vector instructions, no neighbour list and no layout: grains stand in a vector by id,
// tangential forces in a map by pairs of ids. Of the product it uses the constitutive functions
// (core/physics, core/arithmetic) and the types of an experiment, nothing of core/dem but the state it starts
// from. Order of summation and fused operations are those that the model prescribes, so it agrees bit for
// bit. Inertia is not scaled here.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/dem/servo.h"
#include "core/dem/specimen.h"
#include "core/experiment/experiment.h"
#include "core/physics/contact_law.h"

namespace creep::reference {

struct Grain {
  std::uint64_t id = 0;
  std::uint64_t parent = 0;
  std::int32_t generation = 0;
  Eigen::Vector3d position, velocity;              ///< [m], [m/s]
  double radius = 0.0;                             ///< [m]
  double mass = 0.0;                               ///< [kg]
  double limit_stress = 0.0;                       ///< [Pa]
  double crack = 0.0;                              ///< [m]
  double mobilised_stress = 0.0;                   ///< of the last measuring cycle [Pa]
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();  ///< [rad/s]
};

struct Wall {
  double position = 0.0, velocity = 0.0;  ///< along its axis [m], [m/s]
  double force = 0.0, stiffness = 0.0;    ///< [N], [N/m]
};

class Engine {
 public:
  /// Starts from a specimen as it stands between two cycles.
  Engine(const Experiment& experiment, const Specimen& specimen);

  /// One cycle: forces, kick, drift, walls, clocks, cracks; then the grains that failed are split.
  void cycle(const WallControl& control);

  const std::vector<Grain>& grains() const { return grains_; }
  /// Force on the grain of lower id [N].
  const std::map<std::pair<std::uint64_t, std::uint64_t>, Eigen::Vector3d>& shear() const { return shear_; }
  /// Of a wall on a grain, along the axes after the wall's, in turn [N]; by id of the grain and number of the
  /// wall.
  const std::map<std::pair<std::uint64_t, std::size_t>, std::array<double, 2>>& wall_shear() const {
    return wall_shear_;
  }
  const std::array<Wall, 6>& walls() const { return walls_; }
  const std::vector<Fines>& fines() const { return fines_; }
  double time_step() const { return time_step_; }
  double dynamic_time() const { return dynamic_time_; }
  double unbalanced_force_ratio() const { return unbalanced_force_ratio_; }
  double wall_work() const { return wall_work_; }
  std::int64_t damping_quanta() const { return damping_; }        ///< [2^-70 J] since the start
  std::int64_t friction_quanta() const { return friction_; }      ///< [2^-70 J] since the start
  std::int64_t tangential_quanta() const { return tangential_; }  ///< [2^-70 J] since the start
  std::int64_t broken() const { return broken_; }                 ///< since the start

 private:
  struct Loads;  ///< forces and what is summed on the way
  void contact_forces(double step, bool check, Loads& loads);
  void wall_forces(double step, bool check, Loads& loads);
  std::array<double, 2> wall_friction(double step, std::size_t index, std::size_t wall, double normal_force,
                                      double normal_stiffness, Loads& loads);
  void book(const Loads& loads, bool measure);
  double stable_step(const Loads& loads) const;
  void move(const Loads& loads, double kick, double drift);
  void turn(const Loads& loads, double kick);
  void steer(const WallControl& control, double step);
  void grow_cracks(std::set<std::uint64_t>& failed);
  void split(const std::set<std::uint64_t>& failed);
  void assess();
  Eigen::Vector3d loaded_direction(std::size_t index) const;
  void add_grain(std::uint64_t id, std::uint64_t parent, std::int32_t generation, double radius,
                 const Eigen::Vector3d& position, const Eigen::Vector3d& velocity,
                 const Eigen::Vector3d& spin);
  double wall_gap(std::size_t wall, const Grain& grain) const;

  const Experiment& experiment_;
  RoughLaw law_;
  LawTable table_;
  std::vector<Grain> grains_;
  std::map<std::pair<std::uint64_t, std::uint64_t>, Eigen::Vector3d> shear_;
  std::map<std::pair<std::uint64_t, std::size_t>, std::array<double, 2>> wall_shear_;  // by grain and wall
  std::array<Wall, 6> walls_;
  std::array<double, 3> carried_{};
  std::vector<Fines> fines_;
  double initial_mass_, friction_coefficient_, time_step_, last_time_step_, dynamic_time_, crack_time_;
  double mean_overlap_, unbalanced_force_ratio_;
  double wall_work_ = 0.0;
  std::int64_t damping_ = 0, friction_ = 0, tangential_ = 0;
  std::uint64_t next_id_;
  std::int64_t cycle_;
  std::int64_t broken_ = 0;
};

}  // namespace creep::reference
