// Collisions of spheres with each other and with a rigid plane, by the product's own cycle.
//
// Smooth elastic impacts are tests 1 to 3 of Chung and Ooi (2011), Granular Matter 13:643-656, with their
// materials; Hertz gives each answer in closed form. Rough ones have no closed form: the equation of relative
// motion is integrated here from the paper's eqs 1-7.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "core/dem/dynamics.h"
#include "tests/core/dem_scenes.h"
#include "tests/validation/known_answers.h"

namespace creep {
namespace {

using testing::Ball;
using testing::balls;
using testing::widest_kernels;
using validation::KnownAnswers;

constexpr double kPi = std::numbers::pi;
const WallControl kFixedWalls{};

struct Impact {
  double overlap = 0.0;   // largest [m]
  double force = 0.0;     // largest, without damping [N]
  double duration = 0.0;  // of contact [s]
  double rebound = 0.0;   // separation speed [m/s]
};

/// Smooth grains of Young's modulus E.
Experiment smooth(double young_modulus, double poisson_ratio, double density) {
  Experiment experiment;
  experiment.material.shear_modulus = young_modulus / (2.0 * (1.0 + poisson_ratio));
  experiment.material.poisson_ratio = poisson_ratio;
  experiment.material.density = density;
  experiment.material.roughness = 0.0;
  experiment.material.wall_stiffness_factor = 2.0;  // rigid plane
  experiment.numerics.local_damping = 0.0;
  return experiment;
}

double sphere_mass_of(const Experiment& experiment, double radius) {
  return 4.0 / 3.0 * kPi * experiment.material.density * radius * radius * radius;
}

/// Runs at a fixed step until the contact has opened. @param overlap  from the specimen [m]. The force is
/// read off the acceleration of the last particle.
Impact collide(const Experiment& experiment, Specimen& specimen, double step,
               const std::function<double(const Specimen&)>& overlap,
               const std::function<double(const Specimen&)>& opening_speed) {
  Dynamics dynamics(experiment, widest_kernels(), {});
  dynamics.assess(specimen);
  specimen.time_step = step;
  Impact impact;
  double elapsed = 0.0;
  for (int cycle = 0; cycle < 1'000'000 && impact.duration == 0.0; ++cycle) {
    const Eigen::Vector3d before = specimen.particles.velocity(specimen.particles.size() - 1);
    const double kick = 0.5 * (specimen.last_time_step + step);
    dynamics.cycle(specimen, kFixedWalls);
    specimen.time_step = step;  // the product's own rule would shorten it in contact
    elapsed += step;
    const Eigen::Vector3d after = specimen.particles.velocity(specimen.particles.size() - 1);
    impact.force = std::max(impact.force, specimen.particles.mass.back() * (after - before).norm() / kick);
    const double now = overlap(specimen);
    impact.overlap = std::max(impact.overlap, now);
    impact.rebound = opening_speed(specimen);
    if (now < 0.0) impact.duration = elapsed + now / impact.rebound;
  }
  return impact;
}

/// Two equal spheres head on, each at half the speed.
Impact head_on(const Experiment& experiment, double radius, double speed, double step) {
  const double side = 20.0 * radius, middle = 0.5 * side;
  Specimen specimen = balls(experiment, side,
                            {{middle - radius, middle, middle, radius, 0.5 * speed, 0, 0},
                             {middle + radius, middle, middle, radius, -0.5 * speed, 0, 0}});
  const auto& body = specimen.particles.body;
  return collide(
      experiment, specimen, step, [&](const Specimen&) { return 2.0 * radius - (body[1].x - body[0].x); },
      [&](const Specimen&) { return body[1].vx - body[0].vx; });
}

/// One sphere falls on the plane z = 0.
Impact on_plane(const Experiment& experiment, double radius, double speed, double step) {
  const double side = 20.0 * radius;
  Specimen specimen = balls(experiment, side, {{0.5 * side, 0.5 * side, radius, radius, 0.0, 0.0, -speed}});
  const auto& body = specimen.particles.body;
  return collide(
      experiment, specimen, step, [&](const Specimen&) { return radius - body[0].z; },
      [&](const Specimen&) { return body[0].vz; });
}

/// Hertz: closed form. E' and r' reduced modulus and radius, m' reduced mass.
Impact hertz(double modulus, double radius, double mass, double speed) {
  Impact impact;
  impact.overlap = std::pow(15.0 * mass * speed * speed / (16.0 * modulus * std::sqrt(radius)), 0.4);
  impact.force = 4.0 / 3.0 * modulus * std::sqrt(radius) * std::pow(impact.overlap, 1.5);
  const double shape = 0.8 * std::sqrt(kPi) * std::tgamma(0.4) / std::tgamma(0.9);  // 2.943275
  impact.duration = shape * impact.overlap / speed;
  impact.rebound = speed;
  return impact;
}

void expect_same(KnownAnswers& answers, const Impact& measured, const Impact& known,
                 const std::string& name) {
  answers.relative(measured.overlap, known.overlap, name + ": overlap");
  answers.relative(measured.force, known.force, name + ": force");
  answers.relative(measured.duration, known.duration, name + ": duration");
  answers.relative(measured.rebound, known.rebound, name + ": rebound");
}

constexpr double kSteps = 10000.0;  // a collision
const char* const kOfTheStep = "10 000 steps a collision: (omega step)^2 / 8 = 1e-8";

TEST(ChungAndOoi, test_1_two_equal_spheres_head_on) {
  KnownAnswers answers("Chung & Ooi 1: equal glass, limestone spheres; force, overlap, duration, rebound",
                       2e-8, kOfTheStep);
  for (const auto& [name, young_modulus, poisson_ratio, density, printed] :
       {std::tuple{"glass", 48e9, 0.20, 2800.0, 10696.9}, {"limestone", 20e9, 0.25, 2500.0, 7108.2}}) {
    const Experiment experiment = smooth(young_modulus, poisson_ratio, density);
    constexpr double kRadius = 10e-3, kSpeed = 20.0;
    const Impact known = hertz(experiment.material.reduced_modulus(), 0.5 * kRadius,
                               0.5 * sphere_mass_of(experiment, kRadius), kSpeed);
    EXPECT_NEAR(known.force / printed, 1.0, 1e-5);  // six digits of other codes
    expect_same(answers, head_on(experiment, kRadius, kSpeed, known.duration / kSteps), known, name);
  }
}

TEST(ChungAndOoi, test_2_a_sphere_on_a_rigid_plane) {
  KnownAnswers answers("Chung & Ooi 2: aluminium, magnesium alloy sphere on a rigid plane; the same", 2e-8,
                       kOfTheStep);
  for (const auto& [name, young_modulus, poisson_ratio, density, printed] :
       {std::tuple{"aluminium alloy", 70e9, 0.30, 2699.0, 11369.9},
        {"magnesium alloy", 40e9, 0.35, 1800.0, 7232.7}}) {
    const Experiment experiment = smooth(young_modulus, poisson_ratio, density);
    constexpr double kRadius = 0.1, kSpeed = 0.2;
    const Impact known = hertz(2.0 * experiment.material.reduced_modulus(), kRadius,
                               sphere_mass_of(experiment, kRadius), kSpeed);
    EXPECT_NEAR(known.force / printed, 1.0, 1e-5);
    expect_same(answers, on_plane(experiment, kRadius, kSpeed, known.duration / kSteps), known, name);
  }
}

struct Test3 {
  const char* name;
  double young_modulus, poisson_ratio, density, printed_force;
};
constexpr std::array<Test3, 2> kTest3 = {
    {{"aluminium oxide", 380e9, 0.23, 4000.0, 615.35}, {"cast iron", 100e9, 0.25, 7000.0, 506.76}}};
constexpr double kTest3Radius = 2.5e-3, kTest3Speed = 3.9;

TEST(ChungAndOoi, test_3_a_sphere_on_a_rigid_plane_keeps_its_speed) {
  KnownAnswers answers(
      "Chung & Ooi 3, restitution 1: aluminium oxide, cast iron sphere on a rigid plane; the same", 2e-8,
      kOfTheStep);
  for (const Test3& test : kTest3) {
    const Experiment experiment = smooth(test.young_modulus, test.poisson_ratio, test.density);
    const Impact known = hertz(2.0 * experiment.material.reduced_modulus(), kTest3Radius,
                               sphere_mass_of(experiment, kTest3Radius), kTest3Speed);
    EXPECT_NEAR(known.force / test.printed_force, 1.0, 1e-5);
    expect_same(answers, on_plane(experiment, kTest3Radius, kTest3Speed, known.duration / kSteps), known,
                test.name);
  }
}

/// Local damping lets a sphere feel (1 + alpha) F on its way in and (1 - alpha) F on its way out, so a
/// collision has restitution e = sqrt((1 - alpha) / (1 + alpha)) whatever the law of F.
TEST(ChungAndOoi, test_3_a_damped_collision_has_the_restitution_of_its_damping) {
  KnownAnswers answers("Chung & Ooi 3, restitution 0.2 to 0.9 by local damping, smooth and rough", 2e-6,
                       "damping has the wrong sign for part of the step in which the velocity turns");
  for (const Test3& test : kTest3) {
    for (const double restitution : {0.2, 0.4, 0.6, 0.8, 0.9}) {
      Experiment experiment = smooth(test.young_modulus, test.poisson_ratio, test.density);
      experiment.numerics.local_damping =
          (1.0 - restitution * restitution) / (1.0 + restitution * restitution);
      const double duration = hertz(2.0 * experiment.material.reduced_modulus(), kTest3Radius,
                                    sphere_mass_of(experiment, kTest3Radius), kTest3Speed)
                                  .duration;
      const Impact impact = on_plane(experiment, kTest3Radius, kTest3Speed, duration / kSteps);
      answers.relative(impact.rebound / kTest3Speed, restitution, test.name);
    }
  }
  Experiment sand;  // rough, with its default damping of 0.7
  answers.relative(on_plane(sand, 0.105e-3, 1.0, 1e-10).rebound, std::sqrt(0.3 / 1.7), "rough sand");
}

/// Eqs 1-7 for two equal grains, written out anew.
struct RoughPair {
  double roughness = 0.6e-6, radius = 0.105e-3;
  double modulus = 0.5 * 2.0 * 32e9 * 1.19 / (1.0 - 0.19 * 0.19);
  double reduced_mass = 0.5 * 4.0 / 3.0 * kPi * 2650.0 * radius * radius * radius;

  double force(double overlap) const {
    const double r = 0.5 * radius, d1 = 0.05 * roughness, d2 = 5.0 * roughness;
    const double f1 = roughness * modulus * std::sqrt(2.0 * r * roughness), f2 = 100.0 * f1;
    const double end = d1 + d2 + std::pow(3.0 * f2 / (4.0 * modulus * std::sqrt(r)), 2.0 / 3.0);
    const double b = 1.5 * (end - d1) / (end - d1 - d2);
    const double start = d1 + (end - d1) * std::pow(f1 / f2, 1.0 / b);
    const double c = b * start / (start - d1);
    if (overlap <= start) return f1 * std::pow(overlap / start, c);
    if (overlap < end) return f2 * std::pow((overlap - d1) / (end - d1), b);
    return 4.0 / 3.0 * modulus * std::sqrt(r) * std::pow(overlap - d1 - d2, 1.5);
  }

  /// Runge-Kutta of fourth order; curvature jumps of the law leave it of third.
  Impact collide(double speed, double step) const {
    const auto acceleration = [&](double x) { return x > 0.0 ? -force(x) / reduced_mass : 0.0; };
    double x = 0.0, v = speed, elapsed = 0.0;
    Impact impact;
    while (elapsed == 0.0 || x > 0.0) {
      const double h = step, before = v, was = x;
      const double v1 = v, a1 = acceleration(x), v2 = v + 0.5 * h * a1, a2 = acceleration(x + 0.5 * h * v1);
      const double v3 = v + 0.5 * h * a2, a3 = acceleration(x + 0.5 * h * v2);
      const double v4 = v + h * a3, a4 = acceleration(x + h * v3);
      x += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
      v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
      elapsed += h;
      if (before > 0.0 && v <= 0.0) {  // the peak lies where v crosses 0
        const double to_peak = h * before / (before - v);
        impact.overlap = was + 0.5 * before * to_peak;
        impact.force = force(impact.overlap);
      }
    }
    impact.duration = elapsed + x / std::fabs(v);
    impact.rebound = std::fabs(v);
    return impact;
  }
};

TEST(RoughCollision, has_the_overlap_force_and_duration_of_the_equation_of_motion) {
  KnownAnswers answers("Rough grains of 0.21 mm head on at 0.1 to 50 m/s; force, overlap, duration, rebound",
                       5e-8, "the step as above; the table of the law adds 1e-9");
  const RoughPair pair;
  Experiment experiment;
  experiment.numerics.local_damping = 0.0;
  struct Printed {
    double speed, overlap, force, duration;
  };
  for (const Printed& printed : {Printed{0.1, 0.0866721e-6, 1.06595e-3, 2.457e-6},
                                 {1.0, 0.429846e-6, 0.0214933, 1.21854e-6},
                                 {10.0, 2.13268e-6, 0.432158, 0.604851e-6},
                                 {50.0, 6.57997e-6, 3.47548, 0.373969e-6}}) {
    const Impact known = pair.collide(printed.speed, printed.duration / kSteps);
    EXPECT_NEAR(known.overlap / printed.overlap, 1.0, 1e-5);  // six digits computed by others
    EXPECT_NEAR(known.force / printed.force, 1.0, 1e-5);
    const Impact measured = head_on(experiment, pair.radius, printed.speed, printed.duration / kSteps);
    expect_same(answers, measured, known, std::to_string(printed.speed) + " m/s");
  }
}

/// Largest error of kinetic + elastic energy in the course of an undamped collision, over the energy brought
/// in.
double energy_error(const Experiment& experiment, double radius, double speed, double step) {
  const double side = 20.0 * radius, middle = 0.5 * side;
  Specimen specimen = balls(experiment, side,
                            {{middle - radius, middle, middle, radius, 0.5 * speed, 0, 0},
                             {middle + radius, middle, middle, radius, -0.5 * speed, 0, 0}});
  Dynamics dynamics(experiment, widest_kernels(), {});
  dynamics.assess(specimen);
  const ContactModel& model = dynamics.model();
  const double stiffness = model.modulus * std::sqrt(0.5 * radius),
               reduced_mass = 0.5 * specimen.particles.mass[0];
  const double brought = 0.5 * reduced_mass * speed * speed;
  double largest = 0.0, overlap = 0.0;
  const auto& body = specimen.particles.body;
  while (overlap >= 0.0) {
    specimen.time_step = step;
    const double before = body[0].vx - body[1].vx;
    dynamics.cycle(specimen, kFixedWalls);
    const double after = body[0].vx - body[1].vx;
    // Both velocities are half a step from the overlap before the drift.
    const double elastic = stiffness * model.law.energy(std::max(overlap, 0.0));
    const double kinetic = 0.5 * reduced_mass * 0.25 * (before + after) * (before + after);
    if (overlap > 0.0) largest = std::max(largest, std::fabs(kinetic + elastic - brought) / brought);
    overlap = 2.0 * radius - (body[1].x - body[0].x);
  }
  return largest;
}

TEST(Integrator, is_of_second_order) {
  KnownAnswers answers("Order of the integrator: energy error of undamped collisions, 100 to 800 steps each",
                       0.05, "the exponent of a law with kinks reaches 2 only in the limit");
  for (const bool rough : {false, true}) {
    Experiment experiment = rough ? Experiment() : smooth(76.16e9, 0.19, 2650.0);
    experiment.numerics.local_damping = 0.0;
    constexpr double kRadius = 0.105e-3, kSpeed = 10.0;
    const double duration = rough ? RoughPair().collide(kSpeed, 1e-10).duration
                                  : hertz(experiment.material.reduced_modulus(), 0.5 * kRadius,
                                          0.5 * sphere_mass_of(experiment, kRadius), kSpeed)
                                        .duration;
    double coarse = energy_error(experiment, kRadius, kSpeed, duration / 100.0);
    for (const double steps : {200.0, 400.0, 800.0}) {
      const double fine = energy_error(experiment, kRadius, kSpeed, duration / steps);
      answers.absolute(std::log2(coarse / fine), 2.0, rough ? "rough" : "smooth");
      coarse = fine;
    }
  }
}

}  // namespace
}  // namespace creep
