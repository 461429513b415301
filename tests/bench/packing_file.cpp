#include "tests/bench/packing_file.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "core/arithmetic/random.h"
#include "core/dem/particle_birth.h"

namespace creep::bench {
namespace {

using Sphere = std::array<double, 4>;

/// Cells about a grain wide, row by row: neighbours in space are near in memory.
std::array<long, 3> cell(const Sphere& s) {
  constexpr double kCell = 3e-4;
  return {static_cast<long>(s[2] / kCell), static_cast<long>(s[1] / kCell), static_cast<long>(s[0] / kCell)};
}

absl::Status read_box(const std::string& line, Walls& walls) {
  const std::size_t at = line.find("box");
  if (at == std::string::npos) return absl::InvalidArgumentError("the first line holds no box");
  std::istringstream in(line.substr(at + 3));
  std::array<double, 6> box{};
  for (double& value : box) in >> value;
  if (!in) return absl::InvalidArgumentError("the box needs six numbers");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    walls.position[2 * axis] = box[axis];
    walls.position[2 * axis + 1] = box[3 + axis];
    if (!(box[3 + axis] > box[axis])) return absl::InvalidArgumentError("the box is empty");
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Specimen> read_packing(const std::string& path, const Experiment& experiment,
                                      double largest_velocity) {
  std::ifstream in(path);
  if (!in) return absl::InvalidArgumentError(absl::StrCat(path, ": cannot be read"));
  Specimen specimen;
  std::vector<Sphere> spheres;
  std::string line;
  for (long number = 1; std::getline(in, line); ++number) {
    if (number == 1) {
      if (absl::Status status = read_box(line, specimen.walls); !status.ok()) return status;
    }
    if (line.empty() || line[0] == '#') continue;
    Sphere s{};
    std::istringstream row(line);
    if (!(row >> s[0] >> s[1] >> s[2] >> s[3]) || !(s[3] > 0.0)) {
      return absl::InvalidArgumentError(absl::StrCat(path, ":", number, ": expected x y z radius in metres"));
    }
    spheres.push_back(s);
  }
  if (spheres.empty()) return absl::InvalidArgumentError(absl::StrCat(path, ": no spheres"));
  std::sort(spheres.begin(), spheres.end(), [](const Sphere& a, const Sphere& b) {
    const auto ca = cell(a), cb = cell(b);
    return ca != cb ? ca < cb : a < b;
  });
  for (const Sphere& s : spheres) {
    Birth birth;
    birth.id = birth.parent = specimen.particles.size();
    birth.radius = s[3];
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      birth.position[axis] = s[axis];
      const double draw = uniform(experiment.specimen.seed, birth.id, RandomEvent::kShuffle, axis);
      birth.velocity[axis] = largest_velocity * (2.0 * draw - 1.0);
    }
    append_particle(specimen.particles, experiment, birth);
    specimen.initial_mass += specimen.particles.mass.back();
  }
  specimen.next_id = specimen.particles.size();
  specimen.friction = experiment.material.friction;
  return specimen;
}

}  // namespace creep::bench
