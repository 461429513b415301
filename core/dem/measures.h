// What can be read off a specimen. Nothing here changes it. Sums run in id order, so they are part of the
// determinism contract; they are made a few times in thousands of cycles.
#pragma once

#include <vector>

#include "core/dem/contact_model.h"
#include "core/dem/specimen.h"
#include "core/experiment/experiment.h"

namespace creep {

struct ElasticEnergy {
  double normal = 0.0;      ///< closed form, walls included [J]
  double tangential = 0.0;  ///< |shear force|^2 / (2 kt) [J]
};
/// Needs a valid list.
ElasticEnergy elastic_energy(const Specimen& specimen, const ContactModel& model);

/// Of the inertial masses, turning included [J].
double kinetic_energy(const Specimen& specimen);

/// Mass of all particles [kg].
double particle_mass(const Specimen& specimen);
/// Mass booked as fines [kg].
double fines_mass(const Specimen& specimen);

struct VoidRatio {
  double with_fines = 0.0;    ///< fines counted as solid
  double of_particles = 0.0;  ///< particles alone counted as solid
};
VoidRatio void_ratio(const Specimen& specimen, double density);
/// Of a box with so much solid [m3] in it.
double void_ratio(const Walls& walls, double solid_volume);

/// I_G (eq 13).
double grading_index(const Specimen& specimen, const Material& material);

/// Passing by mass at each of the diameters [m], fines included.
std::vector<double> passing(const Specimen& specimen, const Material& material,
                            const std::vector<double>& diameters);

struct ContactStress {
  double axial = 0.0;   ///< z [Pa]
  double radial = 0.0;  ///< mean of x and y [Pa]
};
/// Love-Weber stress, wall contacts included. Needs a valid list.
ContactStress contact_stress(const Specimen& specimen, const ContactModel& model);

struct Coordination {
  double all = 0.0;               ///< contact ends per particle, a wall contact counted as one end
  double without_rattlers = 0.0;  ///< over particles with at least two contacts
};
Coordination coordination(const Specimen& specimen, const ContactModel& model);

/// sigma_mob of each particle (eq 12), walls included, with the bits of a measuring cycle [Pa]. Needs a valid
/// list.
std::vector<double> mobilised_stress(const Specimen& specimen, const ContactModel& model);

double radial_stress(const Walls& walls);  ///< mean of x and y, by wall forces [Pa]

/// The present value of a measure, by wall forces and positions [Pa] or [-].
double value_of(Target::Measure measure, const Specimen& specimen);

/// Axial strain rate x d50 x sqrt(density / mean stress) [-]; 0 without stress.
double inertial_number(const Specimen& specimen, const Experiment& experiment);

double axial_strain(const Specimen& specimen);       ///< engineering, along z; 0 before the end of packing
double volumetric_strain(const Specimen& specimen);  ///< -dV/V0; 0 before the end of packing

}  // namespace creep
