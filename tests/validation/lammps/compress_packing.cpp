// compress_packing load START FRICTION SPEED STEP EVERY COUNT
//     compresses it along z at constant closing SPEED [m/s]; a row every EVERY steps of STEP [s]
// compress_packing isotropic START FRICTION SPEED STEP EVERY COUNT
//     the same with the sides closing in proportion to their lengths: equal strains along x, y and z
// compress_packing shear START FRICTION SPEED STEP EVERY COUNT STRESS
//     the same as load with the sides held at STRESS by the servo, and spheres that may turn
//
// START is a packing at rest (settle_packing). All write a table of strain and wall stresses to the standard
// output.
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "core/dem/dynamics.h"
#include "tests/bench/packing_file.h"

namespace creep {
namespace {

Experiment smooth_unbreakable(double friction) {
  Experiment experiment;
  experiment.material.roughness = 0.0;
  experiment.material.friction = friction;
  experiment.material.comminution_limit = 1.0;
  return experiment;
}

Specimen start(const Experiment& experiment, const char* path) {
  absl::StatusOr<Specimen> specimen = bench::read_packing(path, experiment, 0.0);
  if (!specimen.ok()) {
    std::fprintf(stderr, "%s\n", std::string(specimen.status().message()).c_str());
    std::exit(1);
  }
  return *std::move(specimen);
}

const Kernels& kernels() { return avx2_kernels() != nullptr ? *avx2_kernels() : portable_kernels(); }

enum class Sides { kFixed, kClosing, kHeld };

struct Loading {
  Sides sides;
  double friction, speed, step;
  long every, count;
  double side_stress;  // of sides that are held
};

// FRICTION SPEED STEP EVERY COUNT
Loading loading_of(Sides sides, char** words, double side_stress) {
  return {sides,
          std::atof(words[0]),
          std::atof(words[1]),
          std::atof(words[2]),
          std::atol(words[3]),
          std::atol(words[4]),
          side_stress};
}

WallControl control_of(const Loading& loading, const Walls& walls) {
  WallControl control{};
  control[2] = {AxisControl::Mode::kVelocity, 0.0, loading.speed};
  for (std::size_t axis : {0, 1}) {
    if (loading.sides == Sides::kClosing) {
      const double speed = loading.speed * walls.length(axis) / walls.length(2);
      control[axis] = {AxisControl::Mode::kVelocity, 0.0, speed};
    } else if (loading.sides == Sides::kHeld) {
      control[axis] = {AxisControl::Mode::kServo, loading.side_stress, 4.0 * loading.speed, true};
    }
  }
  return control;
}

void load(const char* path, const Loading& loading) {
  Experiment experiment = smooth_unbreakable(loading.friction);
  experiment.material.free_rotation = loading.sides == Sides::kHeld;
  Dynamics dynamics(experiment, kernels(), {.threads = 1});
  Specimen specimen = start(experiment, path);
  dynamics.assess(specimen);
  const double height = specimen.walls.length(2), volume = specimen.walls.volume();
  const WallControl control = control_of(loading, specimen.walls);
  std::printf("axial_strain,axial_stress_Pa,radial_stress_Pa,volumetric_strain\n");
  for (long cycle = 0; cycle <= loading.every * loading.count; ++cycle) {
    const double strain = 1.0 - specimen.walls.length(2) / height;
    const double volume_loss = 1.0 - specimen.walls.volume() / volume;
    // Walls as the coming cycle meets them, for the areas; forces as it finds them.
    const double area[3] = {specimen.walls.area(0), specimen.walls.area(1), specimen.walls.area(2)};
    specimen.time_step = loading.step;
    dynamics.cycle(specimen, control);
    if (cycle % loading.every != 0) continue;
    const auto stress = [&](std::size_t axis) {
      return 0.5 * (specimen.walls.force[2 * axis] + specimen.walls.force[2 * axis + 1]) / area[axis];
    };
    std::printf("%.9e,%.9e,%.9e,%.9e\n", strain, stress(2), 0.5 * (stress(0) + stress(1)), volume_loss);
  }
}

}  // namespace
}  // namespace creep

int main(int count, char** words) {
  const std::string_view act = count > 1 ? words[1] : "";
  if ((act == "load" || act == "isotropic") && count == 8) {
    const creep::Sides sides = act == "load" ? creep::Sides::kFixed : creep::Sides::kClosing;
    creep::load(words[2], creep::loading_of(sides, words + 3, 0.0));
  } else if (act == "shear" && count == 9) {
    creep::load(words[2], creep::loading_of(creep::Sides::kHeld, words + 3, std::atof(words[8])));
  } else {
    std::fprintf(stderr,
                 "usage: compress_packing load START FRICTION SPEED STEP EVERY COUNT "
                 "| isotropic START FRICTION SPEED STEP EVERY COUNT "
                 "| shear START FRICTION SPEED STEP EVERY COUNT STRESS\n");
    return 2;
  }
  return 0;
}
