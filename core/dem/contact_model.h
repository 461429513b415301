// The contact law of one material in the forms that kernels, measures and splits need.
#pragma once

#include "core/dem/kernels.h"
#include "core/experiment/experiment.h"
#include "core/physics/contact_law.h"

namespace creep {

struct ContactModel {
  explicit ContactModel(const Material& material);

  RoughLaw law;             ///< exact
  LawTable table;           ///< what the cycle computes with
  double modulus;           ///< E' between grains [Pa]
  double wall_modulus;      ///< E' at walls [Pa]
  double tangential_ratio;  ///< kt/kn [-]
  double least_overlap;     ///< that the stiffness of a particle without contact is taken at [m]

  LawView view() const;

  struct Normal {
    double overlap = 0.0;    ///< [m]; force and stiffness are 0 where it is not positive
    double force = 0.0;      ///< [N]
    double stiffness = 0.0;  ///< [N/m]
  };
  /// Two bodies, with the bits of the contact kernel.
  Normal between(const Body& first, const Body& second, double root_radius) const;
  /// A body at a wall, with the bits of the particle kernel; gap from its centre to the wall [m].
  Normal at_wall(const Body& body, double gap) const;
};

}  // namespace creep
