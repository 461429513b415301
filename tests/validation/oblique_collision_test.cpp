// Oblique and spinning impacts of spheres that may turn: tests 4 to 8 of Chung and Ooi (2011), Granular
// Matter 13:643-656, at restitution 1, because the product has no viscous damping in its contacts.
//
// A sphere that hits a rigid plane with friction is one of two equal spheres that hit each other
// point-symmetrically: the contact point rests, half the overlap belongs to each, and stiffness over both is
// that of one on the plane. The product's walls are frictionless, so the tests on a plane run as such pairs.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/dem/dynamics.h"
#include "tests/core/dem_scenes.h"
#include "tests/validation/known_answers.h"

namespace creep {
namespace {

using testing::balls;
using testing::widest_kernels;
using validation::KnownAnswers;

constexpr double kPi = std::numbers::pi;
const WallControl kFixedWalls{};

Experiment turning(double young_modulus, double poisson_ratio, double density, double friction) {
  Experiment experiment;
  experiment.material.shear_modulus = young_modulus / (2.0 * (1.0 + poisson_ratio));
  experiment.material.poisson_ratio = poisson_ratio;
  experiment.material.density = density;
  experiment.material.friction = friction;
  experiment.material.roughness = 0.0;
  experiment.material.free_rotation = true;
  experiment.numerics.local_damping = 0.0;
  return experiment;
}

/// Motion of one sphere: x along the normal, y tangential, spin about z.
struct Motion {
  double normal = 0.0, tangential = 0.0, spin = 0.0;  // [m/s], [m/s], [rad/s]
};

/// How a collision is computed. The answers hold for a normal that does not turn while the spheres pass each
/// other. It turns by v_t t_c / R, and smooth collisions look alike at every speed but for this, which falls
/// with v^0.8: so they are run at a fraction of the speed, below which rounding of the overlap would show.
struct Resolution {
  double speed = 1e-6;     // over that of the test
  double steps = 20000.0;  // a collision
};

/// Spheres that touch at the start; runs until they have parted.
struct Collision {
  Collision(const Experiment& experiment, double first_radius, Motion first_motion, double second_radius,
            Motion second_motion, Resolution resolution = {})
      : first(first_motion), second(second_motion) {
    const double slow = resolution.speed;
    const double reach = first_radius + second_radius;
    Specimen specimen =
        balls(experiment, 20.0 * reach,
              {{-first_radius, 0, 0, first_radius, slow * first.normal, slow * first.tangential, 0},
               {second_radius, 0, 0, second_radius, slow * second.normal, slow * second.tangential, 0}});
    for (double& wall : specimen.walls.position)
      wall -= 10.0 * reach;  // so that rounding is that of small numbers
    specimen.particles.spin[0].z = slow * first.spin;
    specimen.particles.spin[1].z = slow * second.spin;
    Dynamics dynamics(experiment, widest_kernels(), {});
    dynamics.assess(specimen);
    const double m1 = specimen.particles.mass[0], m2 = specimen.particles.mass[1];
    const double closing = slow * (first.normal - second.normal);
    const double overlap = std::pow(
        15.0 * m1 * m2 / (m1 + m2) * closing * closing /
            (16.0 * experiment.material.reduced_modulus() * std::sqrt(first_radius * second_radius / reach)),
        0.4);
    const double step = 2.943275 * overlap / closing / resolution.steps;
    for (int cycle = 0; cycle < 1.1 * resolution.steps; ++cycle) {
      specimen.time_step = step;
      dynamics.cycle(specimen, kFixedWalls);
    }
    const auto motion = [&](std::size_t i) {
      const Body& body = specimen.particles.body[i];
      return Motion{body.vx / slow, body.vy / slow, specimen.particles.spin[i].z / slow};
    };
    first = motion(0);
    second = motion(1);
  }
  Motion first, second;  // after
};

/// A sphere on a rigid plane with friction: what comes towards the plane goes along +x.
Motion on_plane(const Experiment& experiment, double radius, const Motion& before,
                Resolution resolution = {}) {
  return Collision(experiment, radius, before, radius, {-before.normal, -before.tangential, before.spin},
                   resolution)
      .first;
}

/// Tangential impulse over mass while the contact slides all the time: mu (1 + e) times the normal velocity.
struct Sliding {
  double friction, radius;
  Motion after(const Motion& before) const {
    const double change = 2.0 * friction * before.normal;
    return {-before.normal, before.tangential - change, before.spin - 2.5 * change / radius};
  }
};

constexpr double kRadius4 = 2.5e-3, kSpeed4 = 3.9, kFriction4 = 0.092;

TEST(ChungAndOoi, test_4_oblique_impact_in_gross_sliding) {
  KnownAnswers answers(
      "Chung & Ooi 4, gross sliding from 40 to 85 degrees, two materials; tangential restitution, spin", 1e-5,
      "the normal turns by 2e-7 meanwhile: at 85 degrees 3e-6 of the normal velocity");
  for (const auto& [young_modulus, poisson_ratio, density] :
       {std::tuple{380e9, 0.23, 4000.0}, {70e9, 0.33, 2700.0}}) {
    const Experiment experiment = turning(young_modulus, poisson_ratio, density, kFriction4);
    for (const double degrees : {40.0, 50.0, 60.0, 70.0, 85.0}) {
      const double angle = degrees * kPi / 180.0;
      const Motion before{kSpeed4 * std::cos(angle), kSpeed4 * std::sin(angle), 0.0};
      const Motion after = on_plane(experiment, kRadius4, before);
      const Motion known = Sliding{kFriction4, kRadius4}.after(before);
      answers.relative(after.normal, known.normal, "normal velocity");
      answers.relative(after.tangential / before.tangential, known.tangential / before.tangential,
                       "restitution");
      answers.relative(after.spin, known.spin, "spin");
    }
  }
}

TEST(ChungAndOoi, test_4_oblique_impact_below_gross_sliding) {
  KnownAnswers answers("Chung & Ooi 4, sticking and partial slip, 5 to 25 degrees; tangential restitution",
                       2e-4, "known to four digits, from fine steps of the same incremental law");
  const Experiment experiment = turning(380e9, 0.23, 4000.0, kFriction4);
  for (const auto& [degrees, known] :
       {std::pair{5.0, 0.8989}, {10.0, 0.7161}, {15.0, 0.6284}, {20.0, 0.6092}, {25.0, 0.6260}}) {
    const double angle = degrees * kPi / 180.0;
    const Motion before{kSpeed4 * std::cos(angle), kSpeed4 * std::sin(angle), 0.0};
    answers.absolute(on_plane(experiment, kRadius4, before).tangential / before.tangential, known,
                     "restitution");
  }
}

TEST(ChungAndOoi, test_5_oblique_impact_at_constant_normal_velocity) {
  KnownAnswers sliding("Chung & Ooi 5, gross sliding, steel; surface velocity x - 7, spin -5", 5e-5,
                       "of numbers of order 10; the normal turns as above");
  KnownAnswers sticking("Chung & Ooi 5, sticking and partial slip, x = 1 to 6; surface velocity and spin",
                        2e-4, "known to four digits; first order of the step, 1.3e-4 at x = 1");
  KnownAnswers mindlin("Chung & Ooi 5, x = 3.97 against elastic finite elements; surface velocity and spin",
                       0.2, "the incremental law keeps its shear force while the contact unloads");
  constexpr double kRadius = 10e-6, kNormal = 5.0, kFriction = 0.3;
  const Experiment experiment = turning(208e9, 0.30, 7850.0, kFriction);
  struct Rebound {
    double surface, spin;
  };
  // Everything over mu times the normal velocity; x is the surface velocity before.
  const auto rebound = [&](double x) {
    const Motion after = on_plane(experiment, kRadius, {kNormal, x * kFriction * kNormal, 0.0});
    const double unit = kFriction * kNormal;
    return Rebound{(after.tangential + after.spin * kRadius) / unit, after.spin * kRadius / unit};
  };
  for (const double x : {7.5, 10.0, 15.0}) {
    const Rebound measured = rebound(x);
    sliding.absolute(measured.surface, x - 7.0, "surface velocity");
    sliding.absolute(measured.spin, -5.0, "spin");
  }
  for (const auto& [x, surface, spin] : {std::tuple{1.0, 0.5036, -0.3546},
                                         {2.0, -0.1756, -1.5540},
                                         {3.0, -1.0430, -2.8879},
                                         {4.0, -1.5600, -3.9714},
                                         {5.0, -1.6358, -4.7399},
                                         {6.0, -1.0, -5.0}}) {
    const Rebound measured = rebound(x);
    sticking.absolute(measured.surface, surface, "surface velocity at " + std::to_string(x));
    sticking.absolute(measured.spin, spin, "spin at " + std::to_string(x));
  }
  const Rebound measured = rebound(3.97);
  mindlin.absolute(measured.surface, -1.72, "surface velocity");
  mindlin.absolute(measured.spin, -4.04, "spin");
}

/// What the tolerances above rest on: of gross sliding the error is the turn of the normal alone, whatever
/// the step; of sticking it is of the first order, for each increment takes the stiffness at its end.
TEST(ObliqueCollision, errors_fall_with_the_order_that_is_expected_of_them) {
  const Experiment oxide = turning(380e9, 0.23, 4000.0, kFriction4);
  const double angle = 85.0 * kPi / 180.0;
  const Motion before{kSpeed4 * std::cos(angle), kSpeed4 * std::sin(angle), 0.0};
  const auto error_of_sliding = [&](Resolution resolution) {
    return on_plane(oxide, kRadius4, before, resolution).normal / -before.normal - 1.0;
  };
  KnownAnswers turn("Oblique impact in gross sliding at 85 degrees: error as speed^0.8, whatever the step",
                    0.02, "the turn of the normal to its first order, 1e-4, over an error of 1e-5");
  const double fast = error_of_sliding({1e-4, 20000.0}), slow = error_of_sliding({1e-5, 20000.0});
  turn.absolute(std::log10(fast / slow), 0.8, "exponent of the speed");
  turn.relative(error_of_sliding({1e-4, 2000.0}), fast, "error with ten times the step");

  const Experiment steel = turning(208e9, 0.30, 7850.0, 0.3);
  const auto surface = [&](double steps) {
    const Motion after = on_plane(steel, 10e-6, {5.0, 0.3 * 5.0, 0.0}, {1e-6, steps});
    return (after.tangential + after.spin * 10e-6) / 5.0;
  };
  KnownAnswers order("Oblique impact in sticking, x = 1, with 2 000 to 8 000 steps: order of the step", 0.05,
                     "the next order shows at 2 000 steps");
  const double coarse = surface(2000.0), middle = surface(4000.0), fine = surface(8000.0);
  order.absolute(std::log2((coarse - middle) / (middle - fine)), 1.0, "order");
}

TEST(ChungAndOoi, test_6_a_spinning_sphere_on_a_plane) {
  KnownAnswers answers("Chung & Ooi 6, gross sliding of a spinning sphere: recoil (x - 3.5 mu (1 + e)) / e",
                       1e-5, "of numbers of order 5; 20 000 steps a collision");
  constexpr double kRadius = 0.1, kNormal = 0.2, kFriction = 0.4;
  const Experiment experiment = turning(70e9, 0.33, 2700.0, kFriction);
  for (const double x : {3.0, 3.733, 5.677, 10.0}) {
    const Motion after = on_plane(experiment, kRadius, {kNormal, 0.0, x * kNormal / kRadius});
    answers.absolute((after.tangential + after.spin * kRadius) / -after.normal, x - 3.5 * kFriction * 2.0,
                     "recoil");
  }
}

TEST(ChungAndOoi, test_7_two_equal_spheres_with_mirrored_spins_roll_off_each_other) {
  KnownAnswers answers(
      "Chung & Ooi 7: equal spheres with mirrored spins keep them and gain no tangential velocity", 1e-12,
      "rounding");
  constexpr double kRadius = 0.1, kNormal = 0.2;
  const Experiment experiment = turning(70e9, 0.33, 2700.0, 0.4);
  for (const double spin : {0.175, 1.0, 17.0}) {
    const Collision collision(experiment, kRadius, {kNormal, 0.0, spin}, kRadius, {-kNormal, 0.0, -spin});
    answers.absolute(collision.first.tangential, 0.0, "tangential velocity");
    answers.relative(collision.first.spin, spin, "spin");
    answers.relative(collision.second.spin, -spin, "spin of the other");
  }
}

TEST(ChungAndOoi, test_8_a_spinning_sphere_on_a_larger_one) {
  KnownAnswers answers(
      "Chung & Ooi 8: unequal spheres in gross sliding; tangential velocities and spins of both", 1e-5,
      "rigid-body impulses; 20 000 steps a collision");
  constexpr double kSmall = 0.1, kLarge = 0.5, kNormal = 0.2, kFriction = 0.4, kSpin = 20.0;
  const Experiment experiment = turning(70e9, 0.33, 2700.0, kFriction);
  const Collision collision(experiment, kSmall, {kNormal, 0.0, kSpin}, kLarge, {-kNormal, 0.0, 0.0});
  const auto mass = [](double radius) { return 4.0 / 3.0 * kPi * 2700.0 * radius * radius * radius; };
  const double reduced = mass(kSmall) * mass(kLarge) / (mass(kSmall) + mass(kLarge));
  const double impulse = kFriction * 2.0 * reduced * 2.0 * kNormal;  // mu (1 + e) m' relative velocity
  answers.relative(collision.first.tangential, -impulse / mass(kSmall), "small sphere");
  answers.relative(collision.second.tangential, impulse / mass(kLarge), "large sphere");
  answers.relative(collision.first.spin, kSpin - 2.5 * impulse / (mass(kSmall) * kSmall),
                   "small sphere's spin");
  answers.relative(collision.second.spin, -2.5 * impulse / (mass(kLarge) * kLarge), "large sphere's spin");
}

}  // namespace
}  // namespace creep
